"""A broken plugin is refused, or ends the run, with its name, its file and the cause; and nothing is loaded
that nobody asked for."""

import copy
import json
import os
import shutil
import stat
import subprocess
import tempfile
import unittest
from pathlib import Path

PROGRAM = os.environ["DEFORM_PROGRAM"]
FIXTURES = Path(os.environ["DEFORM_FIXTURE_PLUGINS"])
TIMEOUT = 120  # seconds; a run here takes well below one

BAD_INPUT, DIVERGED, PLUGIN_FAILED = 2, 3, 4

SHEET = {
    "title": "Sheet that something is wrong with",
    "surface": {"plugin": "grid", "nodes": [7, 7], "size": [1.0, 1.0],
                "differences": "forward"},
    "material": {"density": 0.1, "damping": 1.0},
    "energies": [
        {"plugin": "stretching", "eta": 0.01},
        {"plugin": "bending", "xi": 1e-6, "normal": {"plugin": "exact"}},
    ],
    "forces": [{"plugin": "gravity", "acceleration": [0, 0, -1]}],
    "constraints": [{"plugin": "pin", "where": {"boundary": "left"}}],
    "integrator": {"plugin": "semi_implicit", "step": 0.02},
    "duration": 0.1,
    "probes": ["lowest"],
}


def sheet(kind, use):
    """The sheet with a plugin of a kind, in the place where a scene names it."""
    scene = copy.deepcopy(SHEET)
    if kind == "energy":
        scene["energies"].append(use)
    elif kind == "force":
        scene["forces"].append(use)
    elif kind == "constraint":
        scene["constraints"].append(use)
    elif kind == "collider":
        scene["colliders"] = [use]
    elif kind == "probe":
        scene["probes"].append(use)
    elif kind == "output":
        scene["outputs"] = [use]
    elif kind == "normal":
        scene["energies"][1]["normal"] = use
    elif kind == "shadow":
        scene["shadow"] = ["gauss", use]
    elif kind == "shape":
        scene["surface"]["rest"] = use
    elif kind == "integrator":
        scene["integrator"] = {**use, "step": 0.02}
    elif kind == "surface":
        scene["surface"] = use
        scene["constraints"] = []
    else:
        scene[kind] = use
    return scene


class BrokenPlugins(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="deform_broken_")
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        self.out = self.folder / "out"

    def deform(self, *arguments, cwd=None, **environment):
        clean = {k: v for k, v in os.environ.items() if k != "DEFORM_PLUGIN_PATH"}
        return subprocess.run([PROGRAM, *map(str, arguments)], cwd=cwd or self.folder, text=True,
                              capture_output=True, timeout=TIMEOUT, stdin=subprocess.DEVNULL,
                              env={**clean, **environment})

    def write(self, scene):
        path = self.folder / "sheet.json"
        path.write_text(json.dumps(scene), encoding="utf-8")
        return path

    def ends_with(self, code, kind, use, *said, plugins=FIXTURES):
        """Runs the sheet with a plugin and returns what it says, which must hold all that is to be said."""
        with self.subTest(kind=kind, use=use):
            result = self.deform("run", self.write(sheet(kind, use)), "--out", self.out, "--force",
                                 "--plugin-path", plugins)
            self.assertEqual(result.returncode, code, result.stderr)
            for text in said:
                self.assertIn(text, result.stderr)
            return result.stderr


class Refused(BrokenPlugins):
    """Libraries that do not load: exit code 2, and nothing is written."""

    def refused(self, name, *said, plugins=FIXTURES):
        self.ends_with(BAD_INPUT, "normal", {"plugin": name}, *said, plugins=plugins)
        self.assertFalse(self.out.exists(), "something was written")

    def test_libraries_that_were_built_otherwise(self):
        expected = {
            "api": "plugin API number", "alignment": "EIGEN_MAX_ALIGN_BYTES",
            "compiler": "compiler", "eigen": "Eigen version", "flavour": "build flavour",
            "size": "size of the ABI tag",
        }
        for name, what in expected.items():
            file = str(FIXTURES / f"normal-broken_{name}.so")
            self.refused(f"broken_{name}", file, what + " is", "expected", "build it again")

    def test_libraries_that_are_not_what_they_say(self):
        expected = {
            "kind": "must be named energy-broken_kind.so",
            "name": "must be named normal-another.so",
            "symbol": "has no symbol deform_plugin_descriptor",
            "parameters": 'declares the parameter "plugin"',
            "declaration": "no parameters today",
        }
        for name, what in expected.items():
            self.refused(f"broken_{name}", str(FIXTURES / f"normal-broken_{name}.so"), what)

    def test_a_text_is_no_library(self):
        file = self.folder / "normal-text.so"
        file.write_text("no library")
        self.refused("text", str(file), "cannot be loaded", plugins=self.folder)

    def test_a_library_that_is_cut_off(self):
        file = self.folder / "normal-short.so"
        file.write_bytes((FIXTURES / "normal-marker.so").read_bytes()[:4096])
        self.refused("short", str(file), "cannot be loaded", plugins=self.folder)

    def test_a_missing_file(self):
        self.refused("missing", 'no normal plugin "missing"', str(FIXTURES) + " (--plugin-path)",
                     "(installation)")

    def test_a_link_to_nothing(self):
        (self.folder / "normal-gone.so").symlink_to(self.folder / "nothing")
        self.refused("gone", str(self.folder / "normal-gone.so"), "no such file",
                     plugins=self.folder)

    def test_two_of_one_name(self):
        second = self.folder / "second"
        second.mkdir()
        shutil.copy(FIXTURES / "normal-marker.so", second)
        scene = self.write(sheet("normal", {"plugin": "marker"}))
        result = self.deform("run", scene, "--out", self.out, "--plugin-path", FIXTURES,
                             "--plugin-path", second)
        self.assertEqual(result.returncode, BAD_INPUT, result.stderr)
        self.assertIn('two normal plugins "marker"', result.stderr)
        for folder in (FIXTURES, second):
            self.assertIn(str(folder / "normal-marker.so"), result.stderr)

    def test_a_constructor_that_rejects_its_parameters(self):
        self.refused("throws_input", "/energies/1/normal/delta", "found 1, expected 2")


    def test_a_term_that_refuses_a_shadow(self):
        scene = sheet("shadow", "exact")
        scene["energies"] = ["picky"]
        result = self.deform("run", self.write(scene), "--out", self.out, "--plugin-path", FIXTURES)
        self.assertEqual(result.returncode, BAD_INPUT, result.stderr)
        for text in ("at /shadow/0: the shadow normal/gauss (", "/normal-gauss.so) of energy/picky (",
                     str(FIXTURES / "energy-picky.so"), "only the exact normal will do"):
            self.assertIn(text, result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertFalse(self.out.exists(), "something was written")


class Failing(BrokenPlugins):
    """Plugins that load and then fail: exit code 4."""

    def fails(self, kind, name, *said, **parameters):
        if kind == "shadow":
            origin = f"the shadow normal/{name} ({FIXTURES}/normal-{name}.so) of "
        else:
            origin = f"{kind}/{name} ({FIXTURES}/{kind}-{name}.so)"
        return self.ends_with(PLUGIN_FAILED, kind, {"plugin": name, **parameters}, origin, *said)

    def test_throwing_constructors(self):
        self.fails("normal", "throws_std", "out of ideas")
        self.fails("normal", "throws_int", "type int")
        self.fails("normal", "broken_interface", "no normal plugin")
        self.fails("normal", "broken_null", "no normal plugin")

    def test_shadows(self):
        energy = "energy/bending ("
        for name, parameters, cause in (("throws", {"what": "std"}, "out of ideas"),
                                        ("throws", {"what": "own"}, "OwnException"),
                                        ("throws_std", {}, "out of ideas"),
                                        ("nan", {}, "is not finite")):
            message = self.fails("shadow", name, energy, cause, **parameters)
            self.assertEqual(message.count("the shadow normal/"), 1, message)

    def test_throwing_steps(self):
        causes = {"std": "out of ideas", "int": "an exception of type int",
                  "own": "an exception of type deform::fixture::OwnException"}
        for kind in ("energy", "force", "normal", "integrator", "probe", "output", "constraint",
                     "collider", "solver", "shape"):
            for what, cause in causes.items():
                message = self.fails(kind, "throws", "failed while", cause, what=what)
                self.assertEqual(message.count("failed while"), 1, message)

    def test_throwing_answers(self):
        """What a plugin is asked of itself before it does anything."""
        for where, more in (("is_static", {}), ("lags_coefficients", {}), ("solves", {"solver": "cholmod"}),
                            ("resolves_contacts", {"colliders": [{"plugin": "plane", "point": [0, 0, -9]}]})):
            with self.subTest(where):
                scene = sheet("integrator", {"plugin": "throws", "what": "int", "where": where})
                result = self.deform("run", self.write({**scene, **more}), "--out", self.out, "--force",
                                     "--plugin-path", FIXTURES)
                self.assertEqual(result.returncode, PLUGIN_FAILED, result.stderr)
                self.assertIn(f"integrator/throws ({FIXTURES}/integrator-throws.so) failed while saying what it is",
                              result.stderr)

    def test_the_run_directory_tells_what_happened(self):
        self.fails("force", "throws", what="own")
        summary = json.loads((self.out / "summary.json").read_text())
        self.assertEqual(summary["status"], "plugin failed")
        self.assertIn("force/throws", summary["reason"])
        self.assertIn("OwnException", (self.out / "log.txt").read_text())

    def test_another_number_of_figures(self):
        for writes in (0, 1, 3):
            self.fails("probe", "wrong_columns", f"wrote {writes} figures, expected 2",
                       writes=writes)
        self.fails("probe", "wrong_columns", "a column has no name", unnamed=True)

    def test_another_number_of_positions(self):
        self.fails("shape", "wrong_size", "gave 50 positions, expected 49", more=1)
        self.fails("shape", "wrong_size", "gave 48 positions, expected 49", more=-1)
        self.fails("shape", "wrong_size", "node 48", "not finite", finite=False)
        self.fails("integrator", "wrong_size", "number of nodes")
        self.fails("constraint", "wrong", "made 48 positions of the 49", what="size")

    def test_nodes_that_there_are_not(self):
        self.fails("constraint", "wrong", "prescribes node 49, expected 0 to 48", what="node")
        self.fails("constraint", "wrong", "prescribes component 3", what="component")
        self.fails("energy", "wrong_tuples", "tuple 1 has node 49, expected 0 to 48", what="beyond")
        self.fails("energy", "wrong_tuples", "tuple 1 has node -1", what="negative")
        self.fails("energy", "wrong_tuples", "3 node numbers, expected a multiple", what="half")
        self.fails("energy", "wrong_tuples", "width() is 0", what="width")

    def test_couplings_that_there_are_not(self):
        said = {"undeclared": "coupling (2, 1), which couplings() does not declare",
                "place": "coupling (1, 0), expected",
                "unknown": "coupling (99, 1), expected",
                "fields": "declares -1 auxiliary fields, expected 0 to 8"}
        for what, text in said.items():
            self.fails("energy", "wrong_couplings", text, what=what)

    def test_surfaces_that_contradict_themselves(self):
        said = {"parameters": "parameters() has 3 rows, expected 4",
                "areas": "areas() has 5 rows, expected 4",
                "mass": "areas() has 0, expected a positive area",
                "rest": "rest() has 3 rows, expected 4",
                "initial": "initial() has 5 rows, expected 4",
                "finite": "initial() of node 2 is not finite",
                "faces": "faces().begin must ascend from 0 to the 4 entries",
                "corners": "faces() names node 4, expected 0 to 3",
                "samples": "samples(bending) was built for 5 nodes, expected 4",
                "weights": "samples(bending) has a sample of weight -1",
                "boundary": 'boundary("left") names node 4, expected 0 to 3',
                "edge": 'edge("left") must have the nodes of boundary("left") in its order',
                "edge_node": 'edge("left") names node 7, expected 0 to 3',
                "length": 'edge("left") has a length of 0 at node 2'}
        for what, text in said.items():
            self.fails("surface", "wrong_sizes", text, what=what)

    def test_the_surface_is_sound_where_nothing_is_wrong(self):
        self.ends_with(0, "surface", {"plugin": "wrong_sizes"})


class Diverging(BrokenPlugins):
    """Numbers that are not finite: the state diverged, exit code 3, and who gave them."""

    def test_not_a_number(self):
        # What is recorded of the first state has the energy's density in it.
        self.ends_with(DIVERGED, "energy", {"plugin": "nan"},
                       f"energy/nan ({FIXTURES}/energy-nan.so)", "not finite", "step 0")
        for kind in ("force", "integrator", "collider"):
            origin = f"{kind}/nan ({FIXTURES}/{kind}-nan.so)"
            self.ends_with(DIVERGED, kind, {"plugin": "nan"}, origin, "not finite", "step 1")
        self.ends_with(DIVERGED, "normal", {"plugin": "nan"}, "not finite", "step 1")
        self.ends_with(DIVERGED, "constraint", {"plugin": "wrong", "what": "nan"},
                       "constraint/wrong", "not finite")

    def test_not_a_number_from_a_time_on(self):
        self.ends_with(DIVERGED, "force", {"plugin": "nan", "from": 0.05}, "force/nan", "step 3")
        summary = json.loads((self.out / "summary.json").read_text())
        self.assertEqual((summary["steps"], summary["term"]), (2, "nan"))


class NobodyAsked(BrokenPlugins):
    """A scene names plugins, never places: nothing is loaded from where a stranger may have put it."""

    def setUp(self):
        super().setUp()
        self.marker = self.folder / "loaded"
        self.scene = self.write(sheet("normal", {"plugin": "marker"}))

    def run_scene(self, *arguments, **keywords):
        return self.deform("run", self.scene, "--out", self.out, *arguments,
                           DEFORM_FIXTURE_MARKER=str(self.marker), **keywords)

    def test_the_marker_tells_when_it_is_loaded(self):
        self.assertEqual(self.run_scene("--plugin-path", FIXTURES).returncode, 0)
        self.assertTrue(self.marker.exists())

    def test_neither_the_current_nor_the_scenes_folder_is_searched(self):
        elsewhere = self.folder / "elsewhere"
        inside = Path("lib") / "deform" / "plugins"
        for folder in (self.folder, elsewhere):
            for place in (folder, folder / inside, folder / "plugins"):
                place.mkdir(parents=True, exist_ok=True)
                shutil.copy(FIXTURES / "normal-marker.so", place)
        for cwd in (self.folder, elsewhere):
            result = self.run_scene(cwd=cwd, LD_LIBRARY_PATH=str(cwd))
            self.assertEqual(result.returncode, BAD_INPUT, result.stderr)
            self.assertIn('no normal plugin "marker"', result.stderr)
            self.assertFalse(self.marker.exists(), "a planted library was loaded")

    def test_a_scene_cannot_name_a_file(self):
        for name in (str(FIXTURES / "normal-marker.so"), "./normal-marker.so", "../plugins/marker"):
            self.write(sheet("normal", {"plugin": name}))
            result = self.run_scene()
            self.assertEqual(result.returncode, BAD_INPUT, result.stderr)
            self.assertFalse(self.marker.exists(), "a library was loaded that a scene named")

    def test_the_others_in_a_folder_are_not_loaded(self):
        self.write(SHEET)
        self.assertEqual(self.run_scene("--plugin-path", FIXTURES).returncode, 0)
        self.assertFalse(self.marker.exists(), "a library was loaded that no scene named")

    def test_unsafe_folders_of_the_environment_are_refused(self):
        def says(folder):
            result = self.run_scene(DEFORM_PLUGIN_PATH=folder)
            self.assertEqual(result.returncode, BAD_INPUT, result.stderr)
            self.assertFalse(self.marker.exists())
            return result.stderr

        shutil.copy(FIXTURES / "normal-marker.so", self.folder)
        self.assertIn("DEFORM_PLUGIN_PATH: the folder . is not an absolute path", says("."))
        self.assertIn("does not exist", says(str(self.folder / "none")))
        self.folder.chmod(self.folder.stat().st_mode | stat.S_IWOTH)
        self.assertIn(f"{self.folder} is world-writable", says(str(self.folder)))
        self.folder.chmod(stat.S_IRWXU)
        self.assertEqual(self.run_scene(DEFORM_PLUGIN_PATH=str(self.folder)).returncode, 0)

    def test_nor_does_the_way_to_a_folder_of_the_environment_lead_through_others(self):
        outer = self.folder / "outer"
        inner = outer / "inner"
        inner.mkdir(parents=True)
        library = Path(shutil.copy(FIXTURES / "normal-marker.so", inner))
        library.chmod(stat.S_IRWXU)
        link = self.folder / "link"
        link.symlink_to(inner)

        def refuses(place, why):
            for folder in (inner, link):
                result = self.run_scene(DEFORM_PLUGIN_PATH=str(folder))
                self.assertEqual(result.returncode, BAD_INPUT, result.stderr)
                self.assertIn(f"{place} {why}", result.stderr.replace(str(folder) + " is not safe: ", ""))
                self.assertFalse(self.marker.exists())

        outer.chmod(stat.S_IRWXU | stat.S_IWOTH)
        refuses(outer, "is world-writable")
        outer.chmod(stat.S_IRWXU)
        library.chmod(stat.S_IRWXU | stat.S_IWOTH)
        result = self.run_scene(DEFORM_PLUGIN_PATH=str(inner))
        self.assertEqual(result.returncode, BAD_INPUT, result.stderr)
        self.assertIn("normal-marker.so is world-writable", result.stderr)
        library.chmod(stat.S_IRWXU)
        if os.geteuid() == 0:
            os.chown(inner, 12345, 12345)
            refuses(inner, "belongs to another user (12345)")
            os.chown(inner, 0, 12345)
            inner.chmod(stat.S_IRWXU | stat.S_IWGRP)
            refuses(inner, "is writable by a group (12345)")
            os.chown(inner, 0, 0)
            inner.chmod(stat.S_IRWXU)
        self.assertEqual(self.run_scene(DEFORM_PLUGIN_PATH=str(link)).returncode, 0)


if __name__ == "__main__":
    unittest.main()
