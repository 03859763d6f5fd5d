"""What `deform run` promises: exit codes, the run directory, quietness, interruption."""

import csv
import hashlib
import json
import os
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

PROGRAM = os.environ["DEFORM_PROGRAM"]
SCENES = Path(os.environ["DEFORM_SCENES"])
FIXTURES = os.environ["DEFORM_FIXTURE_PLUGINS"]
TIMEOUT = 120  # seconds; a run here takes well below one


def sheet(**changes):
    """A sheet of paper that gravity and a point load bend, small enough to take no time."""
    scene = {
        "title": "Sheet of a test",
        "surface": {"plugin": "grid", "nodes": [9, 9], "size": [1.0, 1.0],
                    "differences": "forward", "border": "paper", "weights": "equal"},
        "material": {"density": 0.1, "damping": 1.0},
        "energies": [
            {"plugin": "stretching", "eta": 0.01},
            {"plugin": "bending", "xi": 1e-6, "form": "divergence", "normal": {"plugin": "exact"}},
        ],
        "forces": [
            {"plugin": "gravity", "acceleration": [0, 0, -1]},
            {"plugin": "point_load", "force": [0, 0, -0.01],
             "where": {"centre": [0.5, 0.5], "radius": 0.13}},
        ],
        "constraints": [{"plugin": "pin", "where": {"boundary": "all"}}],
        "integrator": {"plugin": "semi_implicit", "step": 0.02},
        "duration": 0.2,
        "outputs": [{"plugin": "vtk", "every": 5}, {"plugin": "obj", "every": 4}],
        "probes": [{"plugin": "energy"}, {"plugin": "lowest", "every": 4}],
        "variants": {"heavy": {"/material/density": 0.2}},
    }
    scene.update(changes)
    return scene


def diverging_sheet():
    """Sheet P of the reference figures: the estimator of Terzopoulos folds it, at 1e-4 at once."""
    return sheet(
        surface={"plugin": "grid", "nodes": [21, 21], "size": [1.0, 1.0],
                 "differences": "forward", "border": "paper", "weights": "equal"},
        energies=[
            {"plugin": "stretching", "eta": 0.01},
            {"plugin": "bending", "xi": 1e-4, "form": "divergence",
             "normal": {"plugin": "terzopoulos"}},
        ],
        forces=[{"plugin": "point_load", "force": [0, 0, -0.01],
                 "where": {"centre": [0.5, 0.5], "radius": 0.06}}],
        duration=2.0,
    )


class RunCommand(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="deform_cli_")
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        self.out = self.folder / "out"

    def write(self, scene, name="sheet.json"):
        path = self.folder / name
        path.write_text(scene if isinstance(scene, str) else json.dumps(scene), encoding="utf-8")
        return path

    def deform(self, *arguments):
        return subprocess.run([PROGRAM, *map(str, arguments)], cwd=self.folder, text=True,
                              capture_output=True, timeout=TIMEOUT, stdin=subprocess.DEVNULL)

    def run_scene(self, scene, *arguments, expect=0):
        result = self.deform("run", self.write(scene), "--out", self.out, *arguments)
        self.assertEqual(result.returncode, expect, result.stderr)
        return result

    def load(self, name):
        return json.loads((self.out / name).read_text(encoding="utf-8"))

    def rows(self):
        with open(self.out / "probes.csv", newline="", encoding="utf-8") as file:
            return list(csv.reader(file))


class Done(RunCommand):
    def test_run_directory_holds_what_is_promised(self):
        self.run_scene(sheet())
        for name in ("scene.json", "manifest.json", "probes.csv", "summary.json", "log.txt"):
            self.assertTrue((self.out / name).is_file(), name)
        self.assertEqual(list(self.out.rglob("*.part")), [])
        self.assertTrue(list(self.out.rglob("*.pvd")), "vtk wrote no series")
        self.assertTrue(list(self.out.rglob("*.obj")), "obj wrote nothing")
        self.assertTrue((self.out / "log.txt").read_text(encoding="utf-8"))

    def test_manifest(self):
        self.run_scene(sheet())
        manifest = self.load("manifest.json")
        self.assertEqual(manifest["status"], "done")
        self.assertEqual(manifest["exit_code"], 0)
        self.assertEqual(manifest["variant"], "base")
        self.assertEqual(manifest["steps"], 10)
        self.assertGreater(manifest["wall_seconds"], 0)
        self.assertRegex(manifest["started"], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ$")
        self.assertEqual(manifest["command_line"][1], "run")
        self.assertTrue(manifest["solver"])
        plugins = {(p["kind"], p["name"]): p for p in manifest["plugins"]}
        for used in (("surface", "grid"), ("normal", "exact"), ("probe", "lowest")):
            self.assertIn(used, plugins)
        self.assertNotIn(("normal", "gauss"), plugins, "a plugin that took no part")
        grid = plugins["surface", "grid"]
        self.assertEqual(grid["sha256"],
                         hashlib.sha256(Path(grid["file"]).read_bytes()).hexdigest())

    def test_rows_of_the_probes(self):
        self.run_scene(sheet())
        header, *rows = self.rows()
        self.assertEqual(header[:2], ["step", "time [s]"])
        lowest = header.index("lowest [m]")
        self.assertEqual([int(row[0]) for row in rows], list(range(11)))
        self.assertEqual([float(row[1]) for row in rows], [k * 0.02 for k in range(11)])
        # Due every fourth step, and at the last one.
        self.assertEqual([int(row[0]) for row in rows if row[lowest]], [0, 4, 8, 10])
        self.assertEqual(float(rows[0][lowest]), 0.0)
        self.assertLess(float(rows[-1][lowest]), 0.0)

    def test_no_row_where_no_probe_is_due(self):
        self.run_scene(sheet(probes=[{"plugin": "lowest", "every": 7}], outputs=[]))
        self.assertEqual([int(row[0]) for row in self.rows()[1:]], [0, 7, 10])

    def test_summary_agrees_with_the_table(self):
        self.run_scene(sheet())
        summary = self.load("summary.json")
        self.assertEqual(summary["status"], "done")
        self.assertEqual(summary["steps"], 10)
        self.assertEqual(summary["time"], 10 * 0.02)
        header, *rows = self.rows()
        column = [float(row[header.index("lowest [m]")] or "nan") for row in rows]
        figures = [figure for figure in column if figure == figure]
        lowest = summary["probes"]["lowest"]
        self.assertEqual(lowest["unit"], "m")
        self.assertEqual(lowest["final"], figures[-1])
        self.assertEqual(lowest["min"], min(figures))
        self.assertEqual(lowest["max"], max(figures))

    def test_recorded_scene_runs_again_to_the_same_figures(self):
        self.run_scene(sheet(), "--variant", "heavy")
        self.assertEqual(self.load("manifest.json")["variant"], "heavy")
        again = self.folder / "again"
        result = self.deform("run", self.out / "scene.json", "--out", again)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual((again / "probes.csv").read_bytes(),
                         (self.out / "probes.csv").read_bytes())

    def test_number_of_threads_changes_no_bit(self):
        self.run_scene(sheet(), "--threads", "1")
        first = (self.out / "probes.csv").read_bytes()
        self.assertEqual(self.load("manifest.json")["threads"], 1)
        self.run_scene(sheet(), "--force")
        self.assertEqual((self.out / "probes.csv").read_bytes(), first)

    def test_default_folder_names_scene_and_variant(self):
        scene = self.write(sheet())
        self.assertEqual(self.deform("run", scene).returncode, 0)
        self.assertEqual(self.deform("run", scene, "--variant", "heavy").returncode, 0)
        self.assertTrue((self.folder / "runs" / "sheet" / "summary.json").is_file())
        self.assertTrue((self.folder / "runs" / "sheet-heavy" / "summary.json").is_file())

    def test_set_replaces_values(self):
        self.run_scene(sheet(), "--set", "/duration=0.06", "--set", "/title=Another title")
        self.assertEqual(self.load("summary.json")["steps"], 3)
        self.assertEqual(self.load("manifest.json")["title"], "Another title")

    def test_two_probes_of_a_kind_have_columns_of_their_own(self):
        self.run_scene(sheet(probes=["lowest", {"plugin": "lowest", "every": 5}]))
        self.assertEqual(self.rows()[0][2:], ["lowest [m]", "lowest_2 [m]"])

    def test_scene_of_the_repository(self):
        result = self.deform("run", SCENES / "benchmarks" / "sheet_p.json", "--out", self.out,
                             "--set", "/duration=0.04", "--quiet")
        self.assertEqual(result.returncode, 0, result.stderr)


class Talk(RunCommand):
    def test_stderr_is_quiet_when_it_is_no_terminal(self):
        result = self.run_scene(sheet())
        self.assertEqual(result.stderr, "")
        self.assertIn(str(self.out), result.stdout)
        self.assertIn("ms/step", result.stdout)
        self.assertRegex(result.stdout, r"lowest \[m\] +-\d")

    def test_quiet_says_nothing(self):
        result = self.run_scene(sheet(), "--quiet")
        self.assertEqual((result.stdout, result.stderr), ("", ""))

    def test_bar_is_drawn_on_a_terminal_and_leaves_the_line_clean(self):
        controller, terminal = os.openpty()
        self.addCleanup(os.close, controller)
        scene = self.write(sheet(duration=4.0))
        process = subprocess.Popen([PROGRAM, "run", str(scene), "--out", str(self.out)],
                                   stdout=subprocess.DEVNULL, stderr=terminal)
        os.close(terminal)
        shown = b""
        try:
            while chunk := os.read(controller, 65536):
                shown += chunk
        except OSError:  # the other end is closed
            pass
        self.assertEqual(process.wait(TIMEOUT), 0)
        self.assertRegex(shown, rb"% \[[#.]+\] \d+/200 ")
        self.assertTrue(shown.endswith(b"\r\x1b[K"), shown[-80:])

    def test_duration_between_two_steps(self):
        result = self.run_scene(sheet(duration=0.05))
        self.assertRegex(result.stderr, r"sheet.json:1:\d+: .*0\.05 s is no whole number of steps "
                         r"of 0\.02 s: 3 are run, to 0\.06 s")
        self.assertEqual(self.load("summary.json")["steps"], 3)
        self.assertIn("no whole number of steps", (self.out / "log.txt").read_text())
        result = self.deform("validate", self.write(sheet(duration=0.05)))
        self.assertEqual(result.returncode, 0)
        self.assertEqual(result.stderr.count("no whole number of steps"), 1, result.stderr)

    def test_energy_from_nowhere_is_told(self):
        """An explicit method beyond its limit of stability, which here lies at about 4.5 ms."""
        # Loads that depend on velocities have no potential: each step is looked at by itself then.
        air = [{"plugin": "wind", "velocity": [0, 0, 0], "air_density": 1e-6}]
        for step, forces, told in ((0.004, [], None), (0.005, [], "first and what the loads did"),
                                   (0.004, air, None), (0.005, air, "J in step 20 ")):
            springs = {"surface": {"plugin": "grid", "nodes": [3, 3], "size": [1, 1]},
                       "material": {"density": 0.2}, "limits": {"distance": 1e6},
                       "energies": [{"plugin": "edge_springs", "stiffness": 1000}],
                       "velocity": ["0.01*a1", "0", "0"], "forces": forces,
                       "integrator": {"plugin": "symplectic_euler", "step": step},
                       "duration": 40 * step}
            said = self.run_scene(springs, "--quiet", "--force").stderr
            self.assertEqual("gains energy from nowhere" in said, told is not None, said)
            self.assertIn(told or "", said)

    def test_rounding_is_no_energy_from_nowhere(self):
        """Sheets at rest: on a table, and with nothing that acts on them."""
        resting = {"forces": ["gravity"], "colliders": ["plane"]}
        for integrator, step, more in (("backward_euler", 0.01, resting), ("bdf2", 0.01, resting),
                                       ("runge_kutta", 5e-4, {}), ("symplectic_euler", 5e-4, {})):
            scene = {"surface": {"plugin": "grid", "nodes": [9, 9], "size": [0.3, 0.3]},
                     "material": {"density": 0.3},
                     "energies": [{"plugin": "koiter", "young": 1e5, "poisson": 0.3,
                                   "thickness": 0.001}],
                     "integrator": {"plugin": integrator, "step": step}, "duration": 40 * step}
            said = self.run_scene({**scene, **more}, "--quiet", "--force").stderr
            self.assertNotIn("from nowhere", said)

    def test_an_unstable_run_that_ends_is_told(self):
        """A sheet thrown, which nothing acts on: a method with lagged coefficients diverges."""
        scene = {"surface": {"plugin": "grid", "nodes": [9, 9], "size": [0.3, 0.3]},
                 "material": {"density": 0.3}, "velocity": [1, 2, 3], "limits": {"distance": 1e9},
                 "energies": [{"plugin": "koiter", "young": 1e5, "poisson": 0.3,
                               "thickness": 0.001}],
                 "integrator": {"plugin": "semi_implicit", "step": 0.01}, "duration": 0.5}
        self.assertIn("from nowhere", self.run_scene(scene, "--quiet", "--force").stderr)

    def test_all_outputs_end(self):
        outputs = [{"plugin": "obj", "every": 5}, {"plugin": "footer", "every": 5}]
        self.run_scene(sheet(outputs=outputs), "--plugin-path", FIXTURES)
        self.assertEqual((self.out / "footer.txt").read_text(), "3 frames\n")

    def test_momentum_from_nowhere_is_told(self):
        """A free sheet under its weight and a profile of forces; one method counts forces twice."""
        for integrator in ("doubles_forces", "semi_implicit", "symplectic_euler", "runge_kutta",
                           "backward_euler", "bdf2", "implicit_midpoint"):
            with self.subTest(integrator=integrator):
                scene = {"surface": {"plugin": "grid", "nodes": [3, 3], "size": [1, 1]},
                         "energies": [{"plugin": "edge_springs", "stiffness": 10}],
                         "forces": ["gravity", {"plugin": "wind", "velocity": [0, 3, 1]},
                                    {"plugin": "point_load", "force": [1, 0, 0],
                                     "where": {"corners": "all"},
                                     "time": {"pulse": [0.175, 0.33]}}],
                         "integrator": {"plugin": integrator, "step": 0.01}, "duration": 0.4}
                said = self.run_scene(scene, "--quiet", "--force", "--plugin-path",
                                      FIXTURES).stderr
                self.assertEqual("momentum changes by" in said, integrator == "doubles_forces",
                                 said)
                if integrator == "doubles_forces":
                    self.assertIn("over the 4 steps up to step 20", said)

    def equilibrium(self, forces, constraints=(), **expect):
        """Of a stiff square of 0.1 m that weighs 0.981 N; its corners' height is probed."""
        return self.run_scene({
            "surface": {"plugin": "grid", "nodes": [5, 5], "size": [0.1, 0.1]},
            "material": {"density": 10},
            "energies": [{"plugin": "koiter", "young": 1e6, "poisson": 0.3, "thickness": 0.005}],
            "forces": ["gravity", *forces], "constraints": list(constraints),
            "integrator": {"plugin": "static", "step": 1}, "duration": 2,
            "probes": ["centre_of_mass",
                       {"plugin": "point", "where": {"corners": "all"}, "label": "corner"}],
        }, "--force", "--quiet", **expect)

    def height(self, name):
        names, *rows = self.rows()
        return float(rows[-1][next(i for i, n in enumerate(names) if n.startswith(name))])

    def test_springs_hold_an_equilibrium(self):
        everywhere = {"plugin": "spring", "stiffness": 50, "anchor": [0.05, 0.05, 0],
                      "where": {"box": [[0, 0], [0.1, 0.1]]}}
        self.equilibrium([everywhere])  # which leaves turns about the anchor free
        self.assertAlmostEqual(self.height("centre_of_mass.z"), -0.981 / 50, delta=1e-10)
        corners = {"left_bottom": [0, 0, 0.1], "left_top": [0, 0.1, 0.1],
                   "right_bottom": [0.1, 0, 0.1], "right_top": [0.1, 0.1, 0.1]}
        springs = [{"plugin": "spring", "stiffness": 20, "anchor": anchor,
                    "where": {"corners": corner}} for corner, anchor in corners.items()]
        self.equilibrium(springs)
        self.assertAlmostEqual(self.height("corner.z"), 0.1 - 0.981 / 80, delta=1e-9)

    def test_an_unstable_equilibrium_under_pressure_is_told(self):
        """A tube with open ends stays round under a pressure at which it should fold."""
        for pressure, unstable in ((-5, True), (-0.01, False), (5, False)):
            said = self.run_scene({
                "surface": {"plugin": "grid", "nodes": [16, 5], "size": [0.6283185307179586, 0.3],
                            "periodic": [True, False],
                            "rest": {"plugin": "arc", "radius": 0.1, "base": "axis"}},
                "energies": [{"plugin": "koiter", "young": 1e6, "poisson": 0.3,
                              "thickness": 0.001}],
                "forces": [{"plugin": "pressure", "pressure": pressure}],
                "integrator": {"plugin": "static", "step": 1}, "duration": 1,
            }, "--force", "--quiet").stderr
            self.assertEqual("not stable" in said, unstable, said)

    def test_springs_hold_what_they_resist_once_stretched(self):
        """At their rest length they do not resist being turned: the loads make them do so."""
        springs = [{"plugin": "spring", "stiffness": 50, "anchor": [x, y, 0.1], "rest_length": 0.1,
                    "where": {"corners": f"{'right' if x else 'left'}_{'top' if y else 'bottom'}"}}
                   for x in (0, 0.1) for y in (0, 0.1)]
        self.equilibrium(springs)
        self.assertAlmostEqual(self.height("centre_of_mass.x"), 0.05, delta=1e-9)
        self.assertAlmostEqual(self.height("corner.z"), -0.981 / 200, delta=1e-4)

    def test_loads_of_a_free_sheet_balance_in_parts(self):
        pull = [{"plugin": "edge_load", "where": {"boundary": side}, "force": [force, 0, 0]}
                for side, force in (("left", -50), ("right", 50))]
        self.run_scene({"surface": {"plugin": "grid", "nodes": [5, 5], "size": [0.1, 0.1]},
                        "energies": [{"plugin": "koiter", "young": 1e6, "poisson": 0.3,
                                      "thickness": 0.005}], "forces": pull,
                        "integrator": {"plugin": "static", "step": 1, "load_steps": 4},
                        "duration": 1}, "--quiet")

    def test_loads_that_nothing_balances(self):
        said = self.equilibrium([], expect=3).stderr
        self.assertIn("nothing holds the surface, and its loads do not balance", said)
        said = self.equilibrium([], [{"plugin": "pin", "where": {"boundary": "left"}}],
                                expect=3).stderr
        self.assertIn("free to move as a rigid body in 1 way, and its loads", said)

    def test_nodes_that_keep_a_thickness_touch(self):
        """A square that lies on a plane at the distance that nodes keep, and one just above it."""
        for height, touching in ((0.01, 25), (0.0101, 0)):
            self.run_scene({"surface": {"plugin": "grid", "nodes": [5, 5], "size": [1, 1]},
                            "energies": [{"plugin": "edge_springs", "stiffness": 10}],
                            "colliders": [{"plugin": "plane", "point": [0, 0, -height],
                                           "thickness": 0.01}],
                            "integrator": {"plugin": "backward_euler", "step": 0.01},
                            "duration": 0.02, "probes": ["contact"]}, "--force", "--quiet")
            names, *rows = self.rows()
            self.assertEqual(float(rows[-1][names.index("contact.nodes")]), touching)

    def test_an_error_below_rounding_is_refused(self):
        for integrator in ("backward_euler", "bdf2", "implicit_midpoint", "runge_kutta"):
            with self.subTest(integrator=integrator):
                result = self.deform("run", self.write(sheet(integrator={
                    "plugin": integrator, "step": 0.02, "error": 1e-300})), "--out", self.out)
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertRegex(result.stderr, r"/integrator.*'error' is 1e-300, expected 0 or")
                self.assertFalse(self.out.exists())

    def test_output_that_cannot_be_written(self):
        for arguments in (("plugins",), ("schema",), ("--help",), ("plugins", "normal/gauss")):
            with self.subTest(arguments=arguments), open("/dev/full", "w") as full:
                result = subprocess.run([PROGRAM, *arguments], stdout=full, stderr=subprocess.PIPE,
                                        text=True, timeout=TIMEOUT)
                self.assertEqual(result.returncode, 1)
                self.assertIn("cannot write", result.stderr)
                self.assertIn("No space left on device", result.stderr)

    def test_help_and_version(self):
        for arguments in (("--help",), ("run", "--help"), ("--version",)):
            result = self.deform(*arguments)
            self.assertEqual(result.returncode, 0)
            self.assertIn("deform", result.stdout)


class Remarks(RunCommand):
    """What is no error, though hardly meant: `validate` and `run` say it, once."""

    def square(self, constraints, **changes):
        scene = {"surface": {"plugin": "grid", "nodes": [5, 5], "size": [1, 1]},
                 "energies": [{"plugin": "edge_springs", "stiffness": 10}],
                 "constraints": constraints, "duration": 0.02,
                 "integrator": {"plugin": "backward_euler", "step": 0.01}}
        return scene | changes

    def remarks(self, scene):
        validated = self.deform("validate", self.write(scene))
        self.assertEqual(validated.returncode, 0, validated.stderr)
        self.assertEqual(self.run_scene(scene, "--force", "--quiet").stderr, validated.stderr)
        self.assertEqual("warning" in validated.stderr, bool(validated.stderr))
        return validated.stderr.splitlines()

    def move(self, displacements, times=(0, 1), side="left", **more):
        return {"plugin": "move", "where": {"boundary": side}, "times": list(times),
                "displacements": displacements} | more

    PIN = {"plugin": "pin", "where": {"boundary": "left"}}
    CLAMP = {"plugin": "clamp", "where": {"boundary": "left"}}

    def test_of_constraints_that_contradict_each_other(self):
        away = self.move([[0, 0, 0], [0, 0, 0.1]])
        back = self.move([[0, 0, 0], [0, 0, 0.1], [0, 0, 0]], times=[0, 0.003, 0.006])
        for constraints in ([away, self.PIN], [back, self.PIN], [self.PIN, away, self.CLAMP],
                            [away, self.move([[0, 0, 0], [0, 0, -0.1]])]):
            with self.subTest(constraints=constraints):
                said = self.remarks(self.square(constraints))
                self.assertEqual(len(said), 1, said)
                self.assertRegex(said[0], r"sheet\.json:1:\d+: at /constraints/\d: .* over from move "
                                 r"\(at /constraints/\d\), which moves them elsewhere: z of node 0")
        for constraints in ([self.PIN, away], [self.CLAMP, away], [away, away],
                            [away, self.PIN | {"components": ["x", "y"]}],
                            [self.move([[0, 0, 0], [0, 0, 1]], side="right"), self.CLAMP]):
            with self.subTest(constraints=constraints):
                self.assertEqual(self.remarks(self.square(constraints)), [])

    def test_of_a_start_that_tears(self):
        said = self.remarks(self.square([self.move([[0, 0, 0.125], [0, 0, 0.5]])]))
        self.assertEqual(len(said), 1, said)
        self.assertRegex(said[0], r"at /constraints/0: node 0 is at z = 0\.125 m when the run begins")
        self.assertEqual(self.remarks(self.square([self.move([[0, 0, 0], [0, 0, 0.1]])])), [])

    def test_none_of_newton_error_with_colliders(self):
        said = self.remarks(self.square([], colliders=["plane"], integrator={
            "plugin": "bdf2", "step": 0.01, "newton_error": 1e-4}))
        self.assertEqual(said, [], "it counts there, too")


class BadInput(RunCommand):
    def refuse(self, *arguments):
        result = self.deform(*arguments)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertTrue(result.stderr)
        self.assertFalse(self.out.exists(), "something was written")
        return result.stderr

    def test_missing_scene(self):
        message = self.refuse("run", self.folder / "absent.json", "--out", self.out)
        self.assertIn("absent.json", message)

    def test_unknown_plugin(self):
        scene = self.write(sheet(integrator={"plugin": "semi_implicitt", "step": 0.02}))
        message = self.refuse("run", scene, "--out", self.out)
        self.assertIn("semi_implicit", message)

    def test_all_problems_of_the_plugins_at_once(self):
        scene = self.write(sheet(
            forces=[{"plugin": "point_load", "force": [0, 0, -1],
                     "where": {"centre": [7, 7], "radius": 0.1}}],
            constraints=[{"plugin": "pin", "where": {"boundary": "north"}}]))
        message = self.refuse("run", scene, "--out", self.out)
        self.assertIn("/forces/0", message)
        self.assertIn("/constraints/0", message)

    def test_usage(self):
        scene = self.write(sheet())
        self.refuse("run", scene, "--out", self.out, "--fast")
        self.refuse("run", scene, "--out", self.out, "--set", "no pointer")
        self.refuse("run", scene, "--out", self.out, "--threads", "0")
        self.refuse("run")
        self.refuse()

    def test_unknown_variant(self):
        self.assertIn("heavy", self.refuse("run", self.write(sheet()), "--out", self.out,
                                           "--variant", "heawy"))

    def test_existing_folder_is_refused_without_force(self):
        self.out.mkdir()
        scene = self.write(sheet())
        result = self.deform("run", scene, "--out", self.out)
        self.assertEqual(result.returncode, 2)
        self.assertIn("--force", result.stderr)
        self.assertEqual(list(self.out.iterdir()), [])
        self.assertEqual(self.deform("run", scene, "--out", self.out, "--force").returncode, 0)
        (self.out / "stale.txt").write_text("old")
        self.assertEqual(self.deform("run", scene, "--out", self.out, "--force").returncode, 0)
        self.assertFalse((self.out / "stale.txt").exists())

    def test_force_keeps_its_hands_off_other_folders(self):
        self.out.mkdir()
        (self.out / "thesis.tex").write_text("years of work")
        result = self.deform("run", self.write(sheet()), "--out", self.out, "--force")
        self.assertEqual(result.returncode, 2)
        self.assertEqual([p.name for p in self.out.iterdir()], ["thesis.tex"])


class Ends(RunCommand):
    def test_divergence_is_a_result(self):
        result = self.run_scene(diverging_sheet(), expect=3)
        summary = self.load("summary.json")
        self.assertEqual(summary["status"], "diverged")
        self.assertEqual(summary["step"], summary["steps"] + 1)
        self.assertIn(summary["term"], ("stretching", "bending"))
        self.assertTrue(0 <= summary["node"] < 21 * 21)
        self.assertIn(f"step {summary['step']}", result.stderr)
        self.assertRegex(result.stdout, r"ended +diverged\n")
        self.assertEqual(self.load("manifest.json")["exit_code"], 3)
        # The last good state is on record, and what was written is whole.
        self.assertEqual(int(self.rows()[-1][0]), summary["steps"])
        self.assertTrue(list(self.out.rglob("*.pvd")))

    def test_interruption(self):
        scene = self.write(sheet(duration=1e5, outputs=[]))
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(signal=number):
                self.out = self.folder / number.name
                process = subprocess.Popen(
                    [PROGRAM, "run", str(scene), "--out", str(self.out)],
                    stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
                self.wait_for_rows(process)
                process.send_signal(number)
                _, message = process.communicate(timeout=TIMEOUT)
                self.assertEqual(process.returncode, 130, message)
                self.assertIn("interrupted", message)
                summary = self.load("summary.json")
                self.assertEqual(summary["status"], "interrupted")
                self.assertEqual(int(self.rows()[-1][0]), summary["steps"])
                self.assertEqual(self.load("manifest.json")["status"], "interrupted")

    def wait_for_rows(self, process):
        table = self.out / "probes.csv"
        deadline = time.monotonic() + TIMEOUT
        while not (table.exists() and table.read_text().count("\n") > 3):
            self.assertIsNone(process.poll(), "the run ended by itself")
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.02)

    def test_manifest_says_running_meanwhile(self):
        scene = self.write(sheet(duration=1e5, outputs=[]))
        process = subprocess.Popen([PROGRAM, "run", str(scene), "--out", str(self.out)],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.wait_for_rows(process)
        status = self.load("manifest.json")["status"]
        process.send_signal(signal.SIGINT)
        process.wait(TIMEOUT)
        self.assertEqual(status, "running")

    def test_full_disk_is_an_error_that_names_the_file(self):
        # A limit on the size of files stands in for the disk.
        scene = self.write(sheet(duration=1e5, outputs=[]))
        result = subprocess.run(
            ["sh", "-c", 'ulimit -f 32; exec "$@"', "sh", PROGRAM, "run", scene, "--out", self.out],
            capture_output=True, text=True, timeout=TIMEOUT)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("probes.csv", result.stderr)
        self.assertIn("File too large", result.stderr)
        self.assertEqual(self.load("summary.json")["status"], "failed")
        width = len(self.rows()[0])
        self.assertTrue(all(len(row) == width for row in self.rows()), "half a row")


if __name__ == "__main__":
    unittest.main()
