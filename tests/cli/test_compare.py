"""What `deform compare` promises: rows for whatever happens, the same bytes however it is run."""

import csv
import json
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

PROGRAM = os.environ["DEFORM_PROGRAM"]
SCENES = Path(os.environ["DEFORM_SCENES"])
FIXTURES = os.environ["DEFORM_FIXTURE_PLUGINS"]
TIMEOUT = 240  # seconds


def sheet(**changes):
    """Paper pressed at its centre, in three estimators."""
    scene = {
        "title": "Sheet of a test",
        "surface": {"plugin": "grid", "nodes": [9, 9], "size": [1.0, 1.0],
                    "differences": "forward", "border": "paper", "weights": "equal"},
        "material": {"density": 0.1, "damping": 1.0},
        "energies": [
            {"plugin": "stretching", "eta": 0.01},
            {"plugin": "bending", "xi": 1e-6, "form": "divergence",
             "normal": {"plugin": "gauss", "delta": 0.5}},
        ],
        "forces": [{"plugin": "point_load", "force": [0, 0, -0.01],
                    "where": {"centre": [0.5, 0.5], "radius": 0.13}}],
        "constraints": [{"plugin": "pin", "where": {"boundary": "all"}}],
        "integrator": {"plugin": "semi_implicit", "step": 0.02},
        "duration": 0.4,
        "probes": ["lowest", "mirror_asymmetry", "in_plane_displacement", "flatness"],
        "variants": {
            "exact": {"/energies/1/normal": "exact"},
            "terzopoulos": {"/energies/1/normal": "terzopoulos"},
        },
    }
    scene.update(changes)
    return scene


class CompareTest(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="deform_compare_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def write(self, scene, name="scene.json"):
        file = self.folder / name
        file.write_text(json.dumps(scene))
        return file

    def compare(self, scene, *arguments, code=0, out="c"):
        """Runs it and returns what it said, and the comparison's folder."""
        file = scene if isinstance(scene, Path) else self.write(scene)
        folder = self.folder / out
        done = subprocess.run([PROGRAM, "compare", file, "--out", folder, *arguments],
                              capture_output=True, text=True, timeout=TIMEOUT)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done, folder

    @staticmethod
    def summary(folder):
        return json.loads((folder / "summary.json").read_text())

    def figures(self, folder):
        """{run: {figure: value}}"""
        return {run["name"]: {name: figure["value"] for name, figure in run["figures"].items()}
                for run in self.summary(folder)["variants"]}

    @staticmethod
    def rows(folder):
        with open(folder / "comparison.csv", newline="") as file:
            return list(csv.DictReader(file))


class Results(CompareTest):
    def test_folder_and_table(self):
        done, folder = self.compare(sheet())
        for name in ("base", "exact", "terzopoulos"):
            self.assertTrue((folder / name / "probes.csv").is_file())
            self.assertIn(name, done.stdout)
        names = {entry.name for entry in folder.iterdir()}
        self.assertLessEqual({"comparison.csv", "cost.csv", "summary.json", "manifest.json"}, names)
        self.assertNotIn("progress", done.stdout)

    def test_rows_say_what_the_trajectories_say(self):
        """Independently from probes: the lowest node of either run is in the rows' difference."""
        _, folder = self.compare(sheet())

        def lowest(run):
            with open(folder / run / "probes.csv", newline="") as file:
                return {row["step"]: float(row["lowest [m]"]) for row in csv.DictReader(file)}

        base = lowest("base")
        rows = self.rows(folder)
        self.assertEqual(len(rows), 2 * 21)
        for row in rows:
            expected = lowest(row["run"])[row["step"]] - base[row["step"]]
            self.assertEqual(float(row["difference of lowest [m]"]), expected)
            self.assertLessEqual(float(row["rms [m]"]), float(row["max [m]"]))
            self.assertLessEqual(float(row["hausdorff [m]"]), float(row["max [m]"]) * (1 + 1e-12))

    def test_same_scene_has_no_difference(self):
        _, folder = self.compare(sheet(variants={"same": {}}))
        for row in self.rows(folder):
            self.assertEqual([float(row[name]) for name in ("rms [m]", "max [m]", "hausdorff [m]")],
                             [0, 0, 0])
        self.assertIsNone(self.summary(folder)["variants"][1]["parts"])

    def test_a_duration_between_two_steps_is_said_once(self):
        done, folder = self.compare(sheet(duration=0.05))
        self.assertEqual(done.stderr.count("no whole number of steps"), 1, done.stderr)
        self.assertIn("no whole number of steps", (folder / "exact" / "log.txt").read_text())

    def test_parting_is_the_first_row_beyond_the_tolerance(self):
        _, folder = self.compare(sheet(), "--tolerance", "1e-5")
        summary = self.summary(folder)
        self.assertEqual(summary["tolerance"], {"value": 1e-5, "unit": "m"})
        for run in summary["variants"][1:]:
            beyond = [row for row in self.rows(folder)
                      if row["run"] == run["name"] and float(row["max [m]"]) > 1e-5]
            if not beyond:
                self.assertIsNone(run["parts"])
                continue
            self.assertEqual(run["parts"]["step"], int(beyond[0]["step"]))
            self.assertEqual(run["parts"]["node"], int(beyond[0]["node"]))
            self.assertEqual(run["parts"]["where"],
                             [float(beyond[0]["a1 [m]"]), float(beyond[0]["a2 [m]"])])

    def test_order_and_base(self):
        _, folder = self.compare(sheet(comparison={"base": False, "reference": "exact"}))
        summary = self.summary(folder)
        self.assertEqual([run["name"] for run in summary["variants"]], ["exact", "terzopoulos"])
        self.assertEqual(summary["reference"], "exact")
        _, folder = self.compare(sheet(), "--variants", "terzopoulos,base", "--force")
        self.assertEqual([run["name"] for run in self.summary(folder)["variants"]],
                         ["terzopoulos", "base"])


class Failures(CompareTest):
    def test_divergence_throw_and_crash_are_rows(self):
        broken = {
            "diverges": {"/energies/1/normal": "terzopoulos", "/energies/1/xi": 1e-4},
            "throws": {"/energies/1/normal": {"plugin": "throws", "what": "int"}},
            "throws_at_once": {"/energies/1/normal": {"plugin": "throws_std"}},
            "no_node": {"/forces/0/where": {"centre": [0.51, 0.5], "radius": 0.001}},
        }
        # Sheet P of the reference figures, which Terzopoulos' estimator folds at once.
        scene = sheet(variants=broken, surface=dict(sheet()["surface"], nodes=[21, 21]))
        scene["forces"][0]["where"]["radius"] = 0.06
        done, folder = self.compare(scene, "--plugin-path", FIXTURES)
        runs = {run["name"]: run for run in self.summary(folder)["variants"]}
        self.assertEqual(runs["base"]["status"], "done")
        self.assertEqual(runs["diverges"]["status"], "diverged")
        self.assertIn("step", runs["diverges"]["reason"])
        self.assertEqual(runs["throws"]["status"], "plugin failed")
        self.assertIn("normal-throws.so", runs["throws"]["reason"])
        self.assertEqual(runs["throws_at_once"]["status"], "plugin failed")
        self.assertIn("normal-throws_std.so", runs["throws_at_once"]["reason"])
        self.assertEqual(runs["no_node"]["status"], "refused")
        self.assertIn("node", runs["no_node"]["reason"])
        for name in ("diverges", "throws", "throws_at_once", "no_node"):
            self.assertIn(name, done.stdout)

    def test_reference_that_fails(self):
        scene = sheet(variants={"throws": {"/energies/1/normal": {"plugin": "throws_std"}}})
        done, folder = self.compare(scene, "--reference", "throws", "--plugin-path", FIXTURES)
        self.assertEqual([run["status"] for run in self.summary(folder)["variants"]],
                         ["done", "plugin failed"])
        self.assertIn("throws plugin failed", done.stdout)

    def test_a_reference_that_diverges_is_none(self):
        """Sheet P under Terzopoulos' estimator: the first run that is done stands in, and says so."""
        scene = sheet(surface=dict(sheet()["surface"], nodes=[21, 21]), comparison={
            "reference": "diverges"}, variants={
            "diverges": {"/energies/1/normal": "terzopoulos", "/energies/1/xi": 1e-4},
            "exact": {"/energies/1/normal": "exact"}})
        scene["forces"][0]["where"]["radius"] = 0.06
        claims = self.write({"claims": ["exact.done == 1", "exact.distance.max < 1"]}, "expect.json")
        done, folder = self.compare(scene, "--expect", claims, code=5)
        summary = self.summary(folder)
        self.assertEqual(summary["reference"], "base")
        self.assertEqual(summary["planned_reference"], "diverges")
        self.assertIn("diverges was to be the reference, but ended as \"diverged\": base",
                      " ".join(done.stdout.split()))
        self.assertIn("exact.distance.max is not of diverges, the reference", done.stderr)
        self.assertGreater(self.figures(folder)["exact"]["distance.max"], 0)

    def test_plugins_must_be_there_for_what_is_run_only(self):
        scene = sheet(variants={"lost": {"/energies/1/normal": "not_there"},
                                "exact": {"/energies/1/normal": "exact"}})
        file = self.write(scene)
        for variant, code in (("exact", 0), ("base", 0), ("lost", 2)):
            done = subprocess.run(
                [PROGRAM, "run", file, "--variant", variant, "--out", self.folder / variant],
                capture_output=True, text=True, timeout=TIMEOUT)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn('no normal plugin "not_there"', done.stderr)
        self.compare(file, "--variants", "base,exact")
        self.compare(file, code=2, out="all")
        done = subprocess.run([PROGRAM, "validate", file], capture_output=True, text=True,
                              timeout=TIMEOUT)
        self.assertEqual(done.returncode, 2)

    def test_bad_input_writes_nothing(self):
        for arguments, words in (
                (("--variants", "exakt"), ['"exakt"', 'did you mean "exact"']),
                (("--reference", "exactt"), ['"exactt"', 'did you mean "exact"']),
                (("--reference", "refined:exactt"), ['"exactt"']),
                (("--vary", "/energies/1/normal/plugin=gaus,exact"),
                 ["--vary /energies/1/normal/plugin", 'did you mean "gauss"']),
                (("--vary", "/energies/7/xi=1"), ["/energies/7"]),
                (("--vary", "energies/1/xi=1"), ["/POINTER=V1,V2"]),
                (("--vary", "/energies/1/xi=1,-1"), ["-1", ">= 0"]),
                (("--expect", "nothing.json"), ["nothing.json"]),
                (("--tolerance", "0"), ["tolerance"]),
                (("--set", "/title=x", "--variants", "refined"), ['"refined"']),
        ):
            done, folder = self.compare(sheet(), *arguments, code=2)
            for word in words:
                self.assertIn(word, done.stderr, arguments)
            self.assertFalse(folder.exists(), arguments)

    def test_folder_is_not_replaced(self):
        _, folder = self.compare(sheet())
        self.compare(sheet(), code=2)
        done, _ = self.compare(sheet(), "--force")
        self.assertEqual(done.stderr, "")
        self.assertEqual(list(folder.glob(".*")), [])
        other = self.folder / "mine"
        other.mkdir()
        (other / "letter.txt").write_text("mine")
        self.compare(sheet(), "--force", code=2, out="mine")
        self.compare(sheet(), "--resume", code=2, out="mine")
        self.assertTrue((other / "letter.txt").exists())


class Vary(CompareTest):
    def test_plugins_with_other_parameters(self):
        done, folder = self.compare(
            sheet(), "--vary", "/energies/1/normal/plugin=terzopoulos,gauss,exact")
        runs = {run["name"]: run for run in self.summary(folder)["variants"]}
        self.assertEqual(list(runs), ["normal=terzopoulos", "normal=gauss", "normal=exact"])
        self.assertEqual(runs["normal=gauss"]["dropped"], [])
        self.assertEqual(runs["normal=exact"]["dropped"], ["/energies/1/normal/delta"])
        self.assertIn("/energies/1/normal/delta", done.stdout)
        self.assertEqual(self.summary(folder)["reference"], "normal=gauss")  # the scene's own
        scene = json.loads((folder / "normal=exact" / "scene.json").read_text())
        self.assertEqual(scene["energies"][1]["normal"], {"plugin": "exact"})

    def test_set_and_variants_drop_as_vary_does(self):
        scene = sheet(variants={"exact": {"/energies/1/normal/plugin": "exact"}})
        file = self.write(scene)
        for arguments, name in ((("--variant", "exact"), "a"),
                                (("--set", "/energies/1/normal/plugin=exact"), "b")):
            done = subprocess.run([PROGRAM, "run", file, "--out", self.folder / name, *arguments],
                                  capture_output=True, text=True, timeout=TIMEOUT)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("at /energies/1/normal/delta: dropped", done.stderr)
        done = subprocess.run(  # what is said of the new one is refused
            [PROGRAM, "run", file, "--out", self.folder / "c", "--set",
             "/energies/1/normal/plugin=exact", "--set", "/energies/1/normal/delta=1"],
            capture_output=True, text=True, timeout=TIMEOUT)
        self.assertEqual(done.returncode, 2, done.stdout)
        self.assertIn('normal plugin "exact" has no "delta"', done.stderr)

    def test_what_another_option_replaces_is_refused(self):
        parent, child = "/energies/1/normal=exact,gauss", "/energies/1/normal/delta=0.1,1"
        for arguments, words in (
                (("--vary", child, "--vary", parent), "replaces what --vary"),
                (("--vary", "/energies/1/xi=1e-6,1e-7", "--vary", "/energies/1/xi=1e-5,1e-6"),
                 "replaces what --vary"),
                (("--set", "/energies/1/normal/delta=0.1", "--vary", parent), "replaces what --set"),
                (("--vary", "/energies/1/normal/plugin=exact,terzopoulos", "--vary", child),
                 "the plugin of no run has such a parameter")):
            done, folder = self.compare(sheet(), *arguments, code=2)
            self.assertIn(words, done.stderr)
            self.assertFalse(folder.exists())

    def test_runs_of_one_scene_are_said(self):
        done, folder = self.compare(sheet(duration=0.1), "--vary", "/energies/1/xi=1e-6,1.0e-6")
        self.assertEqual(self.summary(folder)["variants"][1]["same_as"], "xi=1e-6")
        self.assertIn("is the same scene as xi=1e-6.", done.stdout)

    def test_grid_fits_a_hundred_columns(self):
        done, folder = self.compare(
            sheet(duration=0.1), "--vary", "/energies/1/xi=0,1e-7,1e-6,2e-6,5e-6",
            "--vary", "/energies/0/eta=0.01,0.02,0.05,0.1",
            "--vary", "/energies/1/normal/plugin=terzopoulos,gauss,exact", "--jobs", "2")
        self.assertEqual(len(self.summary(folder)["variants"]), 60)
        self.assertLessEqual(max(len(line) for line in done.stdout.splitlines()), 100)
        self.assertIn("xi=1e-7+eta=0.05+normal=exact", done.stdout)

    def test_values_with_commas_in_them(self):
        _, folder = self.compare(sheet(duration=0.1), "--vary", "/surface/nodes=[9,9],[17,17]")
        self.assertEqual([run["name"] for run in self.summary(folder)["variants"]],
                         ["nodes=9_9", "nodes=17_17"])
        self.assertGreater(self.figures(folder)["nodes=17_17"]["distance.max"], 0)

    def test_without_common_times_nothing_is_measured(self):
        _, folder = self.compare(sheet(duration=0.06), "--vary", "/integrator/step=0.02,0.007")
        run = self.summary(folder)["variants"][1]
        self.assertIn("no recorded time but the start", run["not_measured"])
        self.assertNotIn("distance", run["figures"])

    def test_steps_of_different_size_meet_at_equal_times(self):
        _, folder = self.compare(sheet(), "--vary", "/integrator/step=0.02,0.04")
        times = [float(row["time [s]"]) for row in self.rows(folder)]
        self.assertEqual(len(times), 11)
        for i, time_ in enumerate(times):
            self.assertAlmostEqual(time_, 0.04 * i, places=12)


class Names(CompareTest):
    def test_names_that_mean_something_else(self):
        for name in ("refined", "report.html", "x" * 300):
            done, folder = self.compare(sheet(variants={name: {}}), code=2)
            self.assertIn("cannot be called", done.stderr)
            self.assertFalse(folder.exists())


class Refined(CompareTest):
    def test_the_largest_distance_sees_what_is_between_the_nodes(self):
        _, folder = self.compare(sheet(variants={}), "--reference", "refined")
        for row in self.rows(folder):
            self.assertLessEqual(float(row["hausdorff [m]"]), float(row["max [m]"]) * (1 + 1e-12))

    def test_error_falls_with_the_grid(self):
        """A coarser grid is farther from the same refined reference of its own kind."""
        errors = []
        for nodes in ([9, 9], [17, 17]):
            surface = dict(sheet()["surface"], nodes=nodes)
            _, folder = self.compare(sheet(surface=surface, variants={}), "--reference", "refined",
                                     "--force")
            finer = json.loads((folder / "refined" / "scene.json").read_text())
            self.assertEqual(finer["surface"]["nodes"], [2 * n - 1 for n in nodes])
            self.assertEqual(finer["integrator"]["step"], 0.005)
            self.assertEqual(len(self.rows(folder)), 21)
            errors.append(self.figures(folder)["base"]["rms"])
        self.assertLess(errors[1], errors[0])


    def test_what_a_finer_grid_lacks_is_named(self):
        rows = "".join(f"{i / 8} {j / 8} 0\n" for j in range(9) for i in range(9))
        (self.folder / "rest.txt").write_text(rows)
        surface = dict(sheet()["surface"], rest={"plugin": "file", "path": "rest.txt"})
        done, folder = self.compare(sheet(surface=surface, variants={}), "--reference", "refined",
                                    code=2)
        self.assertIn("--reference refined: the scene on a grid twice as fine: ", done.stderr)
        self.assertIn("81 positions", done.stderr)
        self.assertFalse(folder.exists())


class Resume(CompareTest):
    def test_jobs_give_the_same_bytes(self):
        _, one = self.compare(sheet(), "--jobs", "1", out="one")
        _, two = self.compare(sheet(), "--jobs", "2", out="two")
        self.assertEqual((one / "comparison.csv").read_bytes(), (two / "comparison.csv").read_bytes())

    def test_killed_and_resumed(self):
        scene = self.write(sheet(duration=4.0, checkpoint={"every": 20},
                                 surface=dict(sheet()["surface"], nodes=[21, 21])))
        _, whole = self.compare(scene, "--jobs", "2", out="whole")
        folder = self.folder / "killed"
        process = subprocess.Popen(
            [PROGRAM, "compare", scene, "--out", folder, "--jobs", "2"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + TIMEOUT
        while time.monotonic() < deadline and not (folder / "exact" / "checkpoint.bin").exists():
            time.sleep(0.001)
        process.kill()
        self.assertEqual(process.wait(), -signal.SIGKILL)
        self.assertFalse((folder / "comparison.csv").exists())
        _, folder = self.compare(scene, "--resume", out="killed")
        self.assertEqual((folder / "comparison.csv").read_bytes(),
                         (whole / "comparison.csv").read_bytes())

    def test_interrupted(self):
        scene = self.write(sheet(duration=40.0))
        folder = self.folder / "c"
        process = subprocess.Popen([PROGRAM, "compare", scene, "--out", folder],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        while not (folder / "base" / "probes.csv").exists():
            time.sleep(0.001)
        process.send_signal(signal.SIGINT)
        _, stderr = process.communicate(timeout=TIMEOUT)
        self.assertEqual(process.returncode, 130, stderr)
        self.assertIn("--resume", stderr)
        summary = json.loads((folder / "base" / "summary.json").read_text())
        self.assertEqual(summary["status"], "interrupted")
        self.assertTrue((folder / "base" / "checkpoint.bin").exists())

    def test_takes_over_what_is_unchanged(self):
        scene = sheet()
        _, folder = self.compare(scene)
        times = {name: (folder / name / "manifest.json").stat().st_mtime_ns
                 for name in ("base", "exact", "terzopoulos")}
        scene["variants"]["exact"]["/energies/1/xi"] = 2e-6
        _, folder = self.compare(scene, "--resume")
        changed = {name for name, then in times.items()
                   if (folder / name / "manifest.json").stat().st_mtime_ns != then}
        self.assertEqual(changed, {"exact"})

    def test_a_damaged_trajectory_is_run_again(self):
        _, folder = self.compare(sheet())
        whole = (folder / "comparison.csv").read_bytes()
        os.truncate(folder / "base" / "trajectory.bin", 100)
        _, folder = self.compare(sheet(), "--resume")
        self.assertEqual((folder / "comparison.csv").read_bytes(), whole)

    def test_other_plugin_file_is_run_again(self):
        _, folder = self.compare(sheet())
        manifest = folder / "exact" / "manifest.json"
        content = json.loads(manifest.read_text())
        next(p for p in content["plugins"] if p["name"] == "exact")["sha256"] = "0" * 64
        manifest.write_text(json.dumps(content))
        self.compare(sheet(), "--resume")
        self.assertNotIn("0" * 64, manifest.read_text())

    def test_a_run_that_is_refused_has_no_figures_of_an_earlier_one(self):
        claims = self.write({"claims": ["exact.steps == 20"]}, "expect.json")
        self.compare(sheet(), "--expect", claims)
        for change, status in (
                ({"/forces/0/where": {"centre": [0.51, 0.5], "radius": 0.001}}, "refused"),
                ({"/forces/0": {"plugin": "ends", "how": "exit", "when": "constructor"}}, "plugin failed")):
            with self.subTest(status=status):
                scene = sheet(variants=dict(sheet()["variants"], exact=change))
                done, folder = self.compare(scene, "--expect", claims, "--resume", "--plugin-path",
                                            FIXTURES, code=5)
                self.assertIn("does not hold: exact.steps == 20", done.stderr)
                run = next(run for run in self.summary(folder)["variants"] if run["name"] == "exact")
                self.assertEqual(run["status"], status)
                self.assertNotIn("distance", run["figures"])
            self.compare(sheet(), "--expect", claims, "--force")


class Killed(CompareTest):
    def test_a_run_that_a_signal_ends_is_no_result(self):
        scene = self.write(sheet(duration=400.0, variants={"other": {"/energies/1/xi": 2e-6}}))
        folder = self.folder / "c"
        process = subprocess.Popen([PROGRAM, "compare", scene, "--out", folder], text=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(process.kill)
        for name in ("base", "other"):
            while not (folder / name / "probes.csv").exists():
                self.assertIsNone(process.poll(), "it ended by itself")
                time.sleep(0.001)
            holder = (folder / name / ".deform-lock").read_text()
            os.kill(int(re.match(r"process (\d+) ", holder)[1]), signal.SIGKILL)
        _, stderr = process.communicate(timeout=TIMEOUT)
        self.assertEqual(process.returncode, 1, stderr)
        for name in ("base", "other"):
            self.assertIn(f"{name}: the program was killed by signal 9 (Killed)", stderr)
        self.assertEqual([run["status"] for run in self.summary(folder)["variants"]], ["crashed"] * 2)


class Changed(CompareTest):
    """What changes while a comparison runs must not be found in one run and not in another."""

    def start_and_change(self, scene, change, *arguments):
        """Changes something while the first run goes on; returns what the comparison said."""
        folder = self.folder / "c"
        process = subprocess.Popen([PROGRAM, "compare", self.write(scene), "--out", folder, *arguments],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        while not (folder / "base" / "probes.csv").exists():
            self.assertIsNone(process.poll(), "it ended by itself")
            time.sleep(0.001)
        change()
        _, stderr = process.communicate(timeout=TIMEOUT)
        self.assertEqual(process.returncode, 2, stderr)
        self.assertFalse((folder / "summary.json").exists())
        return stderr

    def scene(self, **changes):
        return sheet(duration=40.0, variants={"other": {"/energies/1/xi": 2e-6}}, **changes)

    def test_a_file_of_the_scene(self):
        eta = self.folder / "eta.txt"
        eta.write_text("0.01 0.01\n0.01 0.01\n")
        scene = self.scene()
        scene["energies"][0]["eta"] = {"map": "eta.txt"}
        for text in ("0.01 0.01\n0.01 0.02\n", "no numbers\n"):
            with self.subTest(text=text):
                stderr = self.start_and_change(scene, lambda: eta.write_text(text), "--force")
                self.assertIn("run other: files changed while the comparison ran", stderr)
                self.assertIn(str(eta), stderr)
            eta.write_text("0.01 0.01\n0.01 0.01\n")
            shutil.rmtree(self.folder / "c")

    def test_a_plugin(self):
        plugins = self.folder / "plugins"
        plugins.mkdir()
        library = plugins / "integrator-two_step.so"
        shutil.copy(Path(FIXTURES) / library.name, library)

        def replace():
            (self.folder / "new").write_bytes(library.read_bytes() + b"another build")
            os.replace(self.folder / "new", library)

        scene = self.scene(integrator={"plugin": "two_step", "step": 0.02})
        stderr = self.start_and_change(scene, replace, "--plugin-path", plugins)
        self.assertIn(str(library), stderr)


class Expect(CompareTest):
    def expect(self, claims, code):
        file = self.write({"claims": claims} if isinstance(claims, list) else claims, "expect.json")
        done, folder = self.compare(sheet(), "--expect", file, "--force", code=code)
        return done

    def test_claims_that_hold(self):
        done = self.expect(["base.mirror_asymmetry < 1e-12",
                            "terzopoulos.mirror_asymmetry > 100 * base.mirror_asymmetry",
                            "abs(exact.lowest - base.lowest) < 1e-3 && exact.done == 1",
                            "exact.difference.lowest.max < 1e-3", "exact.parts_at > 1"], 0)
        self.assertEqual(done.stdout.count("holds: "), 5)

    def test_claims_that_do_not(self):
        done = self.expect(["base.lowest > exact.lowest + 1", "exact.steps == 20"], 5)
        self.assertIn("does not hold: base.lowest > exact.lowest + 1 (base.lowest = -", done.stderr)
        self.assertNotIn("exact.steps", done.stderr)

    def test_figures_that_there_will_not_be_are_refused_before_anything_runs(self):
        for claim, words in (
                ("base.lowst < 0", ['"base" has no figure "lowst"', 'did you mean "lowest"?']),
                ("exact.difference.lowst < 0", ['did you mean "difference.lowest"?']),
                ("base.distance < 1", ['"base" is the reference, which has no distance']),
        ):
            done = self.expect([claim], 2)
            self.assertIn("expect.json:1:", done.stderr)
            for word in words:
                self.assertIn(word, done.stderr)
            self.assertFalse((self.folder / "c").exists(), claim)

    def test_what_is_no_claim(self):
        for claims, words in (
                (["exakt.lowest < 0"], ["/claims/0", '"exakt" is no run', '"exact"']),
                (["base.lowest"], ["expected a comparison"]),
                (["1 < 2"], ["RUN.FIGURE"]),
                (["base.lowest < "], ["/claims/0"]),
                ([3], ["expected text"]),
                ({"claim": []}, ["expected {"]),
        ):
            done = self.expect(claims, 2)
            for word in words:
                self.assertIn(word, done.stderr)


class Paper(CompareTest):
    SCENE = SCENES / "paper" / "fig05_fig07.json"
    CLAIMS = SCENES / "paper" / "fig05_fig07.expect.json"

    def test_figures_5_and_7(self):
        done, _ = self.compare(self.SCENE, "--jobs", "2", "--expect", self.CLAIMS)
        self.assertNotIn("does not hold", done.stdout)

    def test_the_claims_can_fail(self):
        """The rival's estimator in its place: the file must say so."""
        rival = self.write(json.loads(re.sub(
            r"^ *//.*$", "", self.SCENE.read_text().replace('"terzopoulos"', '"exact"'),
            flags=re.MULTILINE)))
        done, _ = self.compare(rival, "--expect", self.CLAIMS, code=5)
        self.assertIn("does not hold: terzopoulos_1e-7.mirror_asymmetry > 1e-3", done.stderr)


if __name__ == "__main__":
    unittest.main()
