"""`deform plugin check`: every built-in plugin keeps its promises, and one that breaks any is found out."""

import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

PROGRAM = os.environ["DEFORM_PROGRAM"]
SOURCE = Path(os.environ["DEFORM_SOURCE"])
FIXTURES = Path(os.environ["DEFORM_FIXTURE_PLUGINS"])
BUILT_IN = Path(PROGRAM).parent.parent / "lib" / "deform" / "plugins"
TIMEOUT = 300

FAILED = 5

# A curved piece of a surface, cut into triangles.
N = 6
CURVED = "".join(f"v {i / 5} {j / 5} {0.1 * (i * j + i * i) / 25}\n" for j in range(N) for i in range(N))
CURVED += "".join(f"f {a} {a + 1} {a + N + 1}\nf {a} {a + N + 1} {a + N}\n"
                  for j in range(N - 1) for a in range(N * j + 1, N * j + N))

LEFT = {"boundary": "left"}
# What a scene must say of those plugins that have required parameters, and further ways to use others.
PARAMETERS = {
    "shape/arc": [{"radius": 0.5}, {"radius": 0.4, "along": 2, "side": -1}],
    "shape/sphere_patch": [{"radius": 1.5}],
    "shape/hemisphere": [{"radius": 0.5}, {"radius": 10, "sector": 90, "hole": 30}],
    "shape/torus": [{"radius": 0.5, "tube": 0.2}],
    "shape/helicoid": [{"height": 0.5, "inner": -0.5, "turns": -0.5}],
    "shape/formula": [{"z": "k*sin(2*pi*a1/L1)*a2", "constants": {"k": 0.1}}],
    "surface/grid": [
        {"nodes": [9, 7]}, {"nodes": [9, 7], "differences": "forward", "border": "paper",
                            "weights": "equal"}, {"nodes": [9, 7], "differences": "central"},
        {"nodes": [24, 7], "periodic": [True, False], "rest": {"plugin": "arc",
                                                               "radius": 0.15915494309189535}}],
    "normal/gauss": [{"delta": 0}, {"delta": 0.5}, {"delta": "infinity"}],
    "energy/bending": [{"xi": 1e-4, "form": form, "normal": normal}
                       for form in ("divergence", "expanded")
                       for normal in ({"plugin": "exact"}, {"plugin": "terzopoulos"},
                                      {"plugin": "gauss", "delta": 0})],
    "energy/edge_springs": [{}, {"diagonals": False}, {"stiffness": {"formula": "1 + a1"}}],
    "energy/koiter": [{"young": 1e4, "poisson": 0.3, "thickness": 1e-2},
                      {"young": {"formula": "1e4*(1+a1)"}, "poisson": 0, "thickness": 1e-2}],
    "energy/koiter_orthotropic": [{"young_1": 2e4, "young_2": 1e4, "shear": 4e3, "poisson": 0.3,
                                   "thickness": 1e-2}, {"material": "paper", "thickness": 1e-6}],
    "energy/stretching": [{}, {"eta": {"formula": "0.01*(1+a1)"}}],
    "force/point_load": [{"force": [0, 0, -1], "where": LEFT}],
    "force/edge_load": [{"force": [0, 0, -1], "where": LEFT}],
    "force/moment": [{"moment": 0.1, "axis": [0, 2, 0], "where": LEFT}],
    "force/spring": [{"anchor": [0.5, 0.4, 0.3], "where": LEFT},
                     {"anchor": [0.5, 0.4, 0.3], "where": LEFT, "rest_length": 0.2}],
    "force/gravity": [{}, {"time": {"ramp": [0, 1]}}],
    "force/pressure": [{"pressure": 2}, {"pressure": -1, "time": {"ramp": [0, 1]}}],
    "force/wind": [{}, {"velocity": [3, 1, 2]}, {"velocity": [0, 0, -5], "drag": 0, "friction": 1}],
    "probe/point": [{"where": LEFT}],
    "probe/folds": [{"where": {"boundary": "bottom"}}],
    "probe/line_stretch": [{"where": {"boundary": "bottom"}}],
    "constraint/pin": [{"where": LEFT}, {"where": LEFT, "components": ["z"]}],
    "constraint/clamp": [{"where": LEFT}, {"where": {"boundary": ["left", "top"]}, "tangent": "full"}],
    "constraint/symmetry": [{"where": LEFT, "plane": "x"}],
    "constraint/move": [{"where": LEFT, "times": [0, 1], "displacements": [[0, 0, 0], [0, 0, 0.1]]}],
}


def parameters_of(library, folder):
    plugin = library.stem.replace("-", "/", 1)
    if plugin == "shape/file":  # is checked with grids of 9 × 7 nodes and of 17 × 13
        return []
    if plugin == "surface/mesh":
        file = Path(folder) / "curved.obj"
        file.write_text(CURVED)
        return [{"path": str(file)}]
    return PARAMETERS.get(plugin, [{}])


class PluginCheck(unittest.TestCase):
    def check(self, library, parameters=None, code=0):
        arguments = [PROGRAM, "plugin", "check", str(library)]
        if parameters is not None:
            arguments += ["--parameters", json.dumps(parameters)]
        result = subprocess.run(arguments, text=True, capture_output=True, timeout=TIMEOUT)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        return result.stdout + result.stderr

    def test_every_built_in_plugin_keeps_its_promises(self):
        libraries = sorted(BUILT_IN.glob("*.so"))
        self.assertGreater(len(libraries), 30)
        with tempfile.TemporaryDirectory() as folder:
            for library in libraries:
                for parameters in parameters_of(library, folder):
                    with self.subTest(plugin=library.stem, parameters=parameters):
                        found = self.check(library, parameters)
                        self.assertIn(str(library), found)
                        self.assertNotIn("FAILED", found)

    def find_out(self, kind, about, *names, name="liar", key="about", **more):
        with self.subTest(kind=kind, about=about):
            found = self.check(FIXTURES / f"{kind}-{name}.so", {key: about, **more}, FAILED)
            failed = [line.strip() for line in found.splitlines() if " FAILED" in line]
            for expected in names:
                self.assertTrue(any(line.startswith(expected) for line in failed), found)

    def test_who_breaks_no_promise_passes(self):
        libraries = sorted(FIXTURES.glob("*-liar.so"))
        self.assertGreater(len(libraries), 8)
        for library in libraries:
            with self.subTest(library=library.name):
                self.check(library, {"about": "nothing"})

    def test_energies(self):
        self.find_out("energy", "gradient", "force = −gradient of the energy")
        self.find_out("energy", "symmetry", "lagged operator: symmetric")
        self.find_out("energy", "semidefinite", "lagged operator: semidefinite")
        self.find_out("energy", "adding", "adds to what is there")
        self.find_out("energy", "blocks", "same bits in blocks")
        self.find_out("energy", "writing", "writes nothing beyond a block")
        self.find_out("energy", "finite", "gives finite numbers")
        self.find_out("energy", "sharing", "same bits when asked again", "same bits on several")
        self.find_out("energy", "dependence", "exact tangent = −derivative of the force")
        self.find_out("energy", "reading", "reads only what it says",
                      "gives finite numbers")

    def test_an_energy_alone_is_right_as_far_as_differences_tell(self):
        found = self.check(FIXTURES / "energy-density_alone.so")
        stress = [line for line in found.splitlines() if line.strip().startswith("stress ")]
        self.assertEqual(len(stress), 1, found)
        self.assertIn("reported", stress[0])
        self.assertIn("`stress`", found)

    def test_scalar_unknowns_take_part(self):
        for mass in (0, 0.1):
            self.check(FIXTURES / "energy-hidden_springs.so", {"mass": mass, "initial": 0.01})

    def test_what_is_not_finite_is_named(self):
        found = self.check(FIXTURES / "normal-liar.so", {"about": "finite"}, FAILED)
        self.assertRegex(" ".join(found.split()), r"\b[psc](_[12xyz])? of pair (11|12|22) at sample \d+")
        found = self.check(FIXTURES / "energy-liar.so", {"about": "finite"}, FAILED)
        self.assertIn("the energy density at sample 0 is inf", " ".join(found.split()))

    def test_a_new_plugin_has_a_name_of_its_own(self):
        with tempfile.TemporaryDirectory() as folder:
            result = subprocess.run([PROGRAM, "plugin", "new", "energy", "koiter"], text=True,
                                    capture_output=True, timeout=TIMEOUT, cwd=folder)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn("there is a plugin energy/koiter already", result.stderr)
            self.assertEqual(list(Path(folder).iterdir()), [])

    def test_normals(self):
        self.find_out("normal", "dependence", "writes only what dependence() allows")
        self.find_out("normal", "blocks", "same bits in blocks")
        self.find_out("normal", "sharing", "same bits when asked again", "same bits on several")
        self.find_out("normal", "branches", "names a branch for every sample")
        self.find_out("normal", "finite", "gives finite numbers")

    def test_forces(self):
        self.find_out("force", "potential", "force = −gradient of the potential")
        self.find_out("force", "stiffness", "−∂f/∂r")
        self.find_out("force", "drag", "−∂f/∂v")
        self.find_out("force", "adding", "adds to what is there")
        self.find_out("force", "neighbours", "a node's force depends on that node alone",
                      "same bits in blocks")
        for about, name in (("potential", "force = −gradient of the potential"),
                            ("tangent", "exact tangent = −∂f/∂r"),
                            ("bound", "−∂f/∂v is at most the damping that bounds it"),
                            ("stiffness", "a bound of the damping comes without a stiffness")):
            self.find_out("force", about, name, name="coupled_liar")
        self.check(FIXTURES / "force-coupled_liar.so", {"about": "nothing"})

    def test_constraints(self):
        self.find_out("constraint", "others", "writes no component that it did not reserve")
        self.find_out("constraint", "time", "depends on time alone")

    def test_integrators(self):
        self.find_out("integrator", "time", "advances time by the step")
        self.find_out("integrator", "constraints", "prescribed positions end where")
        self.find_out("integrator", "rest", "without force nothing moves")
        self.find_out("integrator", "memory", "saved and loaded half-way, the run is the same")

    def test_solvers(self):
        self.find_out("solver", "solution", "|A x − b| / |b|")
        self.find_out("solver", "memory", "remembers nothing of earlier values")
        self.find_out("solver", "regular", "factorises regular matrices")
        self.find_out("solver", "use", "suits some matrices")

    def test_recorders(self):
        self.find_out("output", "place", "writes below the run's folder only")
        self.find_out("output", "writing", "writes something")
        self.find_out("output", "ending", "ends well without a frame")
        self.find_out("probe", "columns", "has columns")
        self.find_out("probe", "repetition", "same figures in another run")
        self.find_out("probe", "memory", "saved, loaded and saved again")
        self.find_out("probe", "finite", "measures")

    def test_surfaces_and_shapes(self):
        self.find_out("shape", "repetition", "same bits when asked again")
        for about, name in (("operators", "operators: first derivatives"),
                            ("area", "areas of samples and of nodes"),
                            ("inwards", "edges: along and inwards are unit vectors")):
            self.find_out("surface", about, name, name="wrong_sizes", key="what")

    def test_throwing_is_a_failed_check(self):
        libraries = sorted(FIXTURES.glob("*-throws.so"))
        self.assertGreater(len(libraries), 8)
        for library in libraries:
            with self.subTest(library=library.name):
                self.assertIn("OwnException", self.check(library, {"what": "own"}, FAILED))

    def test_every_kind_has_built_in_plugins_and_its_row_in_the_documentation(self):
        refused = subprocess.run([PROGRAM, "plugins", "colour"], text=True, capture_output=True, timeout=TIMEOUT)
        self.assertEqual(refused.returncode, 2, refused.stderr)
        page = (SOURCE / "docs" / "write-a-plugin.md").read_text(encoding="utf-8")
        kinds = refused.stderr.strip().rpartition("kinds are ")[2].split(", ")
        self.assertIn("energy", kinds)
        for kind in kinds:
            with self.subTest(kind=kind):
                self.assertTrue(list(BUILT_IN.glob(f"{kind}-*.so")))
                self.assertRegex(page, rf"(?m)^\| {kind}\b")

    def test_what_does_not_load(self):
        found = self.check(FIXTURES / "normal-broken_api.so", code=2)
        self.assertIn("plugin API number", found)
        found = self.check(FIXTURES / "normal-missing.so", code=2)
        self.assertIn("no such file", found)
        found = self.check(Path("/etc/hostname"), code=2)
        self.assertIn("KIND-NAME.so", found)

    def test_required_parameters_must_be_given(self):
        found = self.check(BUILT_IN / "force-point_load.so", code=2)
        self.assertIn("where", found)
        self.assertIn("--parameters", found)
        found = self.check(BUILT_IN / "normal-gauss.so", {"delta": -1}, code=2)
        self.assertIn("delta", found)

    def test_a_library_goes_before_an_installed_one_of_its_name(self):
        with tempfile.TemporaryDirectory() as folder:
            copy = Path(folder) / "normal-exact.so"
            copy.write_bytes((BUILT_IN / "normal-exact.so").read_bytes())
            self.assertIn(str(copy), self.check(copy))


if __name__ == "__main__":
    unittest.main()
