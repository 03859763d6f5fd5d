"""A run is what its folder says: files that changed, that are damaged or gone, other processes, full disks.

DEFORM_FLIPS: how many bits are flipped in each binary file (default 12).
DEFORM_FLIPS_VALGRIND: how many of them under valgrind, where that is installed (default 1).
"""

import hashlib
import json
import os
import random
import resource
import shutil
import signal
import struct
import subprocess
import time
import unittest
from pathlib import Path

from test_run_command import PROGRAM, TIMEOUT, RunCommand, sheet

FIXTURES = os.environ["DEFORM_FIXTURE_PLUGINS"]
FLIPS = int(os.environ.get("DEFORM_FLIPS", "12"))
FLIPS_VALGRIND = int(os.environ.get("DEFORM_FLIPS_VALGRIND", "1"))
NODES = 9
FILES = ("eta.txt", "xi.txt", "rest.txt", "initial.txt")
ABOUT_THE_PROCESS = {"log.txt", "manifest.json", "report.html"}


def content(folder, but=frozenset()):
    return {str(path.relative_to(folder)): path.read_bytes() for path in Path(folder).rglob("*")
            if path.is_file() and path.name not in but}


def grid(rows):
    return "".join(" ".join(map(repr, row)) + "\n" for row in rows)


def positions(height):
    return grid([i / (NODES - 1), j / (NODES - 1), height * (i == j == 4)]
                for j in range(NODES) for i in range(NODES))


class FilesTest(RunCommand):
    def scene_with_files(self, **changes):
        """A sheet whose stiffness, rest and first state stand in files beside it; 10 steps."""
        (self.folder / "eta.txt").write_text(grid([[0.01, 0.02], [0.015, 0.02]]))
        (self.folder / "xi.txt").write_text(grid([[1e-6, 2e-6], [1e-6, 1e-6]]))
        (self.folder / "rest.txt").write_text(positions(0))
        (self.folder / "initial.txt").write_text(positions(0.001))
        scene = sheet(variants={}, outputs=[{"plugin": "vtk", "every": 3}],
                      checkpoint={"every": 4, "seconds": 0}, **changes)
        scene["surface"] = {"plugin": "grid", "nodes": [NODES, NODES], "size": [1.0, 1.0],
                            "differences": "symmetric"}
        scene["surface"].update(rest={"plugin": "file", "path": "rest.txt"},
                                initial={"plugin": "file", "path": "initial.txt"})
        scene["energies"][0]["eta"] = {"map": "eta.txt"}
        scene["energies"][1] = {"plugin": "bending_variational", "xi": {"map": "xi.txt"}}
        return self.write(scene)

    def run_part(self, scene, *arguments, expect=0, out=None):
        result = self.deform("run", scene, "--out", out or self.out, "--quiet", *arguments)
        self.assertEqual(result.returncode, expect, result.stderr)
        return result

    def refuse_to_resume(self, scene, *arguments, code=2):
        before = content(self.out)
        result = self.deform("run", scene, "--out", self.out, "--resume", *arguments)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        self.assertEqual(content(self.out), before, "something was changed")
        return result.stderr

    OTHER = 65534

    def allow_another_user(self):
        """All may write to the test's folder; only root can be another user."""
        if os.getuid() != 0:
            self.skipTest("needs root, to be somebody who is not")
        self.folder.chmod(0o777)

    def deform_as_another_user(self, *arguments, expect=0):
        result = subprocess.run([PROGRAM, *map(str, arguments)], cwd=self.folder, text=True,
                                capture_output=True, timeout=TIMEOUT, user=self.OTHER, group=self.OTHER,
                                extra_groups=[])
        self.assertEqual(result.returncode, expect, result.stdout + result.stderr)
        return result

    def start(self, *arguments):
        process = subprocess.Popen([PROGRAM, *map(str, arguments)], cwd=self.folder, text=True,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        self.addCleanup(process.wait, TIMEOUT)
        self.addCleanup(process.kill)
        return process

    def wait_for(self, file, process):
        deadline = time.monotonic() + TIMEOUT
        while not file.exists():
            self.assertIsNone(process.poll(), "it ended by itself")
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.005)

    def shown(self, folder):
        """The data of the report's page, and what was said."""
        result = self.deform("report", folder)
        self.assertEqual(result.returncode, 0, result.stderr)
        page = (folder / "report.html").read_text()
        data = page.split('<script id="deform-data" type="application/json">')[1]
        return json.loads(data.split("</script>")[0]), result.stderr


class ChangedFiles(FilesTest):
    def changed(self, name, how):
        """A file that can still be read, and what it held before."""
        path = self.folder / name
        old = path.read_text()
        rows = old.splitlines(keepends=True)
        if how == "a digit":
            *others, last = rows[0].split()
            rows[0] = " ".join([*others, repr(float(last) * (1 + 1e-9) or 1e-9)]) + "\n"
        elif how == "a comment":
            rows.append("# the same numbers, but another file\n")
        elif how == "an empty line":
            rows.append("\n")
        elif how == "scaled":
            rows = [" ".join(repr(1.001 * float(x)) for x in row.split()) + "\n" for row in rows]
        else:
            rows = [row.replace(" ", ",") for row in rows]
        path.write_text("".join(rows))
        return path, old

    def each_change(self):
        for name in FILES:
            for how in ("a digit", "a comment", "an empty line", "scaled", "commas"):
                path, old = self.changed(name, how)
                self.assertNotEqual(path.read_text(), old)
                yield path
                path.write_text(old)

    def test_resumed_runs_are_refused(self):
        scene = self.scene_with_files()
        self.run_part(scene, "--set", "/duration=0.1")
        for path in self.each_change():
            message = self.refuse_to_resume(scene)
            self.assertIn(str(path), message)
            self.assertIn("--force", message)
        self.run_part(scene, "--resume")  # and with the old files it goes on
        self.assertEqual(self.load("manifest.json")["resumed_after_step"], 5)

    def test_finished_runs_are_not_called_this_scenes(self):
        scene = self.scene_with_files()
        self.run_part(scene)
        for path in self.each_change():
            self.assertIn(str(path), self.refuse_to_resume(scene))

    def test_new_runs_and_comparisons_take_the_new_file(self):
        scene = self.scene_with_files()
        folder = self.folder / "c"
        first = self.deform("compare", scene, "--out", folder, "--quiet")
        self.assertEqual(first.returncode, 0, first.stderr)
        self.run_part(scene)
        for path in self.each_change():
            self.run_part(scene, "--force")
            again = self.deform("compare", scene, "--out", folder, "--resume", "--quiet")
            self.assertEqual(again.returncode, 0, again.stderr)
            self.assertEqual((folder / "base" / "probes.csv").read_bytes(),
                             (self.out / "probes.csv").read_bytes())
            manifest = json.loads((folder / "base" / "manifest.json").read_text())
            known = {entry["sha256"] for entry in manifest["files"]}
            self.assertIn(hashlib.sha256(path.read_bytes()).hexdigest(), known)

    def test_other_programs_and_plugins(self):
        scene = self.scene_with_files()
        self.run_part(scene, "--set", "/duration=0.1")
        folder = self.folder / "c"
        self.assertEqual(self.deform("compare", scene, "--out", folder, "--quiet").returncode, 0)
        for change in (lambda m: m.update(version="0.0.9"),
                       lambda m: m["library"].update(sha256="0" * 64),
                       lambda m: m["plugins"][0].update(sha256="0" * 64),
                       lambda m: m.pop("library"), lambda m: m.update(plugins=5),
                       lambda m: m.update(files="none"), lambda m: m.update(files=[1, {}])):
            for run in (self.out, folder / "base"):
                manifest = json.loads((run / "manifest.json").read_text())
                good = (run / "manifest.json").read_text()
                change(manifest)
                (run / "manifest.json").write_text(json.dumps(manifest))
                if run == self.out:
                    self.refuse_to_resume(scene)
                    (run / "manifest.json").write_text(good)
                else:
                    done = self.deform("compare", scene, "--out", folder, "--resume", "--quiet")
                    self.assertEqual(done.returncode, 0, done.stderr)
                    again = json.loads((run / "manifest.json").read_text())
                    self.assertEqual(again["library"], json.loads(good)["library"])

    def test_a_folder_can_be_moved_with_its_files(self):
        scene = self.scene_with_files()
        self.run_part(scene, "--set", "/duration=0.1")
        recorded = self.load("scene.json")
        self.assertEqual(recorded["energies"][0]["eta"]["map"], "../eta.txt")
        self.assertEqual(recorded["surface"]["rest"]["path"], "../rest.txt")
        there = self.folder / "elsewhere"
        there.mkdir()
        for name in FILES + ("sheet.json", "out"):
            shutil.move(self.folder / name, there / name)
        again = self.folder / "again"
        self.run_part(there / "out" / "scene.json", out=again)
        self.assertEqual((again / "probes.csv").read_bytes(),
                         (there / "out" / "probes.csv").read_bytes())
        self.run_part(there / "sheet.json", "--resume", out=there / "out")
        self.assertEqual(json.loads((there / "out" / "summary.json").read_text())["steps"], 10)

    def test_the_manifest_says_what_a_run_was_made_with(self):
        scene = self.scene_with_files(integrator={"plugin": "backward_euler", "step": 0.02})
        self.run_part(scene)
        manifest = self.load("manifest.json")
        self.assertNotIn("none was needed", manifest["solver"])
        self.assertTrue(manifest["cpu"])
        self.assertIn("tbb", manifest["built_with"])
        self.assertTrue(any("libtbb.so" in library for library in manifest["libraries"]))
        self.assertIn("commit", manifest)
        self.assertEqual([entry["pointer"] for entry in manifest["files"]],
                         ["/surface/rest/path", "/surface/initial/path", "/energies/0/eta/map",
                          "/energies/1/xi/map"])
        for result in manifest["results"]:
            found = (self.out / result["file"]).read_bytes()
            self.assertEqual(len(found), result["bytes"])
            self.assertEqual(hashlib.sha256(found).hexdigest(), result["sha256"])


class Held(FilesTest):
    def assert_refused(self, process, *arguments):
        result = self.deform(*arguments)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn(f"process {process.pid} on ", result.stderr)
        self.assertRegex(result.stderr, r" since \d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ")

    def test_one_process_has_a_run(self):
        scene = self.write(sheet(duration=1e5, outputs=[], checkpoint={"every": 10}))
        process = self.start("run", scene, "--out", self.out)
        self.wait_for(self.out / "checkpoint.bin", process)
        for arguments in (("run", scene, "--out", self.out),
                          ("run", scene, "--out", self.out, "--force"),
                          ("run", scene, "--out", self.out, "--resume"),
                          ("compare", scene, "--out", self.out, "--force"),
                          ("report", self.out)):
            self.assert_refused(process, *arguments)
        self.assertIsNone(process.poll())
        process.kill()
        process.communicate(timeout=TIMEOUT)
        result = self.deform("report", self.out)  # what was killed holds nothing
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_one_process_has_a_comparison(self):
        scene = self.write(sheet(duration=1e5, outputs=[], checkpoint={"every": 10}))
        process = self.start("compare", scene, "--out", self.out)
        self.wait_for(self.out / "base" / "checkpoint.bin", process)
        for option in ("--resume", "--force"):
            self.assert_refused(process, "compare", scene, "--out", self.out, option)
        self.assert_refused(process, "report", self.out)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=TIMEOUT)
        self.assertEqual(process.returncode, 130)

    def test_another_user_sees_who_has_it(self):
        self.allow_another_user()
        scene = self.write(sheet(duration=1e5, outputs=[], checkpoint={"every": 10}))
        process = self.start("run", scene, "--out", self.out)
        self.wait_for(self.out / "checkpoint.bin", process)
        self.out.chmod(0o777)
        for arguments in (("report", self.out), ("run", scene, "--out", self.out, "--force"),
                          ("compare", scene, "--out", self.out, "--force")):
            result = self.deform_as_another_user(*arguments, expect=2)
            self.assertIn(f"process {process.pid} on ", result.stderr)
        self.assertIsNone(process.poll())

    def test_a_folder_within_which_another_process_works_is_not_replaced(self):
        scene = self.write(sheet(outputs=[]))
        self.run_part(scene)
        inner = self.out / "inner"
        long = self.write(sheet(duration=1e5, outputs=[], checkpoint={"every": 10}), "long.json")
        process = self.start("run", long, "--out", inner)
        self.wait_for(inner / "checkpoint.bin", process)
        for command in ("run", "compare"):
            self.assert_refused(process, command, scene, "--out", self.out, "--force")
            self.assertEqual(self.load("summary.json")["status"], "done")
            self.assertEqual(list(self.out.glob(".deform-*")), [])
        self.assertIsNone(process.poll())
        process.send_signal(signal.SIGINT)
        _, stderr = process.communicate(timeout=TIMEOUT)
        self.assertEqual(process.returncode, 130, stderr)
        self.assertTrue((inner / "summary.json").exists())
        self.run_part(scene, "--force")
        self.assertFalse(inner.exists())

    def test_of_two_that_begin_at_once_one_runs(self):
        scene = self.write(sheet(duration=2.0))
        both = [self.start("run", scene, "--out", self.out, "--quiet") for _ in range(2)]
        for process in both:
            process.communicate(timeout=TIMEOUT)
        self.assertEqual(sorted(process.returncode for process in both), [0, 2])
        self.assertEqual(self.load("manifest.json")["status"], "done")
        self.assertEqual(self.load("summary.json")["steps"], 100)


    @unittest.skipUnless(shutil.which("strace"), "strace makes a process wait at a system call")
    def test_who_is_refused_has_removed_nothing(self):
        """One looks whether the folder is there; before it goes on another makes and holds it."""
        scene = self.write(sheet(duration=1e5, outputs=[], checkpoint={"every": 10}))
        late = subprocess.Popen(
            ["strace", "-f", "-qq", "-o", "/dev/null", "-P", str(self.out), "-e", "trace=%%stat",
             "-e", "inject=%%stat:delay_exit=4000000:when=3", PROGRAM, "run", str(scene), "--out",
             str(self.out)], cwd=self.folder, text=True, stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE)
        self.addCleanup(late.kill)
        time.sleep(1.5)
        process = self.start("run", scene, "--out", self.out)
        self.wait_for(self.out / "checkpoint.bin", process)
        _, stderr = late.communicate(timeout=TIMEOUT)
        self.assertEqual(late.returncode, 2, stderr)
        self.assertIsNone(process.poll())
        self.assertLessEqual({"manifest.json", "scene.json", "probes.csv", "log.txt"},
                             {path.name for path in self.out.iterdir()})


class Damaged(FilesTest):
    def flipped(self, path, good, rng):
        bad = bytearray(good)
        bit = rng.randrange(8 * len(good))
        bad[bit // 8] ^= 1 << bit % 8
        path.write_bytes(bad)
        return bit

    def assert_no_crash(self, result, *codes):
        self.assertIn(result.returncode, codes, result.stdout + result.stderr)
        self.assertNotIn("internal error", result.stderr)

    def valgrind(self, *arguments):
        # The loader compares paths of libraries word by word, beyond their ends.
        loader = self.folder / "loader.supp"
        loader.write_text("{\n  loader\n  Memcheck:Addr8\n  fun:strncmp\n  fun:is_dst\n  ...\n}\n")
        return subprocess.run(
            ["valgrind", "--quiet", "--error-exitcode=99", "--leak-check=no",
             f"--suppressions={loader}", PROGRAM, *map(str, arguments)], cwd=self.folder, text=True, capture_output=True, timeout=600)

    def forget_results(self, run):
        """As if the run had been killed: its files have to stand for themselves."""
        text = (run / "manifest.json").read_text()
        manifest = json.loads(text)
        manifest.pop("results")
        (run / "manifest.json").write_text(json.dumps(manifest))
        return text

    def test_flipped_bits_in_a_trajectory(self):
        scene = self.write(sheet(outputs=[], variants={"heavy": {"/material/density": 0.2}}))
        self.assertEqual(self.deform("compare", scene, "--out", self.out).returncode, 0)
        csv = (self.out / "comparison.csv").read_bytes()
        rng = random.Random(3)
        for number in range(FLIPS):
            run = self.out / ("base", "heavy")[number % 2]
            path = run / "trajectory.bin"
            good = path.read_bytes()
            bit = self.flipped(path, good, rng)
            with self.subTest(run=run.name, bit=bit):
                self.assert_no_crash(self.deform("report", self.out), 0)
                page = (self.out / "report.html").read_bytes()
                self.assertTrue(b"nothing is shown of" in page, "the report says nothing of it")
                manifest = self.forget_results(run)
                check = self.valgrind if number < FLIPS_VALGRIND and shutil.which("valgrind") \
                    else self.deform
                self.assert_no_crash(check("report", self.out), 0, 2)
                path.write_bytes(good)
                (run / "manifest.json").write_text(manifest)
        # A comparison knows them by their hashes, and runs them again.
        self.assertEqual(self.deform("compare", scene, "--out", self.out, "--force").returncode, 0)
        for _ in range(max(FLIPS // 4, 1)):
            path = self.out / "heavy" / "trajectory.bin"
            good = path.read_bytes()
            self.flipped(path, good, rng)
            self.assert_no_crash(self.deform("compare", scene, "--out", self.out, "--resume"), 0)
            self.assertEqual(path.read_bytes(), good)
            self.assertEqual((self.out / "comparison.csv").read_bytes(), csv)

    def test_a_report_says_which_run_is_gone(self):
        scene = self.write(sheet(outputs=[]))
        self.assertEqual(self.deform("compare", scene, "--out", self.out).returncode, 0)
        self.assertEqual(self.shown(self.out)[1], "")
        shutil.rmtree(self.out / "heavy")
        data, said = self.shown(self.out)
        self.assertIn(f"warning: nothing is known of what {self.out / 'heavy'} held", said)
        self.assertEqual([variant["frames"] > 0 for variant in data["variants"]], [True, False])

    def test_a_report_says_what_it_lacks(self):
        scene = self.write(sheet(outputs=[], variants={}))
        self.run_part(scene)
        data, said = self.shown(self.out)
        self.assertEqual((len(data["variants"][0]["probes"]["rows"]), said), (11, ""))
        for name, change, has_probes, has_shape in (
                ("trajectory.bin", lambda p: os.truncate(p, 3000), True, False),
                ("trajectory.bin", lambda p: os.truncate(p, 10), True, False),
                ("trajectory.bin", Path.unlink, True, False),
                ("probes.csv", Path.unlink, False, True),
                ("probes.csv", lambda p: self.change_byte(p, 200), False, True),
                ("summary.json", Path.unlink, False, True),
                ("scene.json", Path.unlink, True, True)):
            path = self.out / name
            good = path.read_bytes()
            change(path)
            with self.subTest(name=name):
                data, said = self.shown(self.out)
                self.assertIn("warning: nothing is shown of ", said)
                self.assertIn(str(path), said)
                self.assertTrue(any(str(path) in note for note in data["notes"]), data["notes"])
                variant, = data["variants"]
                self.assertEqual((len(variant["probes"]["rows"]) > 0, variant["frames"] > 0),
                                 (has_probes, has_shape))
            path.write_bytes(good)

    def test_flipped_bits_in_a_checkpoint(self):
        scene = self.scene_with_files()
        self.run_part(scene, "--set", "/duration=0.1")
        path = self.out / "checkpoint.bin"
        good = path.read_bytes()
        rng = random.Random(4)
        for number in range(FLIPS):
            bit = self.flipped(path, good, rng)
            with self.subTest(bit=bit):
                self.refuse_to_resume(scene)
                if number < FLIPS_VALGRIND and shutil.which("valgrind"):
                    done = self.valgrind("run", scene, "--out", self.out, "--resume")
                    self.assertEqual(done.returncode, 2, done.stderr)
                self.reseal(path)
                self.resume_forged(scene)
        path.write_bytes(good)

    @staticmethod
    def reseal(path):
        """What no accident does: a checksum that is right."""
        sealed = path.read_bytes()[:-64]
        path.write_bytes(sealed + hashlib.sha256(sealed).hexdigest().encode())

    def resume_forged(self, scene):
        """It is refused, or a state that could be; a run of its own decides about that one."""
        copy = self.folder / "copy"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(self.out, copy)
        self.assert_no_crash(self.deform("run", scene, "--out", copy, "--resume"), 0, 2, 3)

    def test_steps_that_lead_nowhere(self):
        """A length of the next step that is negative would never reach the end of one."""
        scene = self.write(sheet(outputs=[], variants={}, integrator={
            "plugin": "bdf2", "step": 0.02, "error": 1e-4}))
        self.run_part(scene, "--set", "/duration=0.1")
        path = self.out / "checkpoint.bin"
        good = path.read_bytes()
        name = b"simulation/integrator/bdf2/next_step"
        at = good.index(name) + len(name)
        for value in (-1.0, float("nan"), float("-inf"), float("inf")):
            path.write_bytes(good[:at] + struct.pack("<d", value) + good[at + 8:])
            self.reseal(path)
            self.assertIn("next_step", self.refuse_to_resume(scene))

    def test_what_a_checkpoint_relies_on_must_be_there(self):
        scene = self.scene_with_files()
        self.run_part(scene, "--set", "/duration=0.1")
        frame = self.out / "vtk" / "surface_000000.vtp"
        for path, change in (
                (self.out / "trajectory.bin", Path.unlink),
                (self.out / "trajectory.bin", lambda p: os.truncate(p, 100)),
                (self.out / "trajectory.bin", lambda p: self.change_byte(p, 500)),
                (self.out / "probes.csv", Path.unlink),
                (self.out / "probes.csv", lambda p: self.change_byte(p, 30)),
                (frame, Path.unlink),
                (frame, lambda p: os.truncate(p, 10))):
            with self.subTest(file=path.name):
                good = path.read_bytes()
                change(path)
                message = self.refuse_to_resume(scene)
                self.assertIn(str(path), message)
                self.assertIn("put back", message)
                path.write_bytes(good)
        self.run_part(scene, "--resume")

    @staticmethod
    def change_byte(path, at):
        bad = bytearray(path.read_bytes())
        bad[at] ^= 1
        path.write_bytes(bad)


class Kept(FilesTest):
    """Nothing old goes before the new run has taken its first step."""

    def assert_kept(self, arguments, code, *words, out=None):
        before = content(self.out)
        result = self.deform(*arguments, "--out", self.out, "--force")
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        for word in words:
            self.assertIn(word, result.stderr)
        self.assertEqual(content(self.out), before)

    def test_solvers_that_cannot_take_the_matrix(self):
        self.run_scene(sheet())
        clamped = [{"plugin": "clamp", "where": {"boundary": "left"}}]
        static = {"plugin": "static", "step": 0.02}
        euler = {"plugin": "backward_euler", "step": 0.02}
        koiter = [{"plugin": "koiter", "young": 1e6, "poisson": 0.3, "thickness": 1e-3}]
        for solver, integrator, constraints in (("multigrid", static, None),
                                                ("multigrid", euler, clamped),
                                                ("multigrid", static, clamped)):
            changes = {"energies": koiter, "integrator": integrator, "solver": {"plugin": solver}}
            if constraints:
                changes["constraints"] = constraints
            scene = self.write(sheet(**changes), "bad.json")
            with self.subTest(integrator=integrator["plugin"], constraints=constraints):
                self.assert_kept(("run", scene), 2, '"multigrid"', "/solver", '"cholmod"')
                validated = self.deform("validate", scene)
                self.assertEqual(validated.returncode, 2, validated.stdout)
                self.assertIn('"cholmod"', validated.stderr)
                changes["solver"] = {"plugin": "cholmod"}
                good = self.write(sheet(**changes), "good.json")
                self.assertEqual(self.deform("validate", good).returncode, 0)

    def test_failures_in_the_first_step(self):
        self.run_scene(sheet())
        for changes, code in (
                ({"integrator": {"plugin": "throws", "what": "std", "step": 0.02}}, 4),
                ({"forces": [{"plugin": "nan", "from": -1.0}]}, 3)):
            scene = self.write(sheet(**changes), "bad.json")
            with self.subTest(changes=changes):
                self.assert_kept(("run", scene, "--plugin-path", FIXTURES), code, "stays")
        self.assert_kept(("run", self.write("{}", "empty.json")), 2)

    def test_comparisons(self):
        scene = self.write(sheet())
        self.assertEqual(self.deform("compare", scene, "--out", self.out).returncode, 0)
        bad = self.write(sheet(integrator={"plugin": "throws", "what": "std", "step": 0.02}), "bad.json")
        self.assert_kept(("compare", bad, "--plugin-path", FIXTURES), 4, "stays")

    def test_a_run_that_succeeds_replaces_it(self):
        self.run_scene(sheet())
        (self.out / "old").write_text("old")
        self.run_scene(sheet(), "--force")
        self.assertFalse((self.out / "old").exists())
        self.assertEqual([p.name for p in self.out.iterdir() if p.name.startswith(".")], [])

    def test_resumed_without_a_checkpoint(self):
        """It begins anew; what is there goes with the first step only."""
        fails = {"plugin": "throws", "what": "std", "step": 0.02}
        scene = self.write(sheet(outputs=[], variants={}, duration=1e5, integrator=fails))
        self.out.mkdir()
        (self.out / "manifest.json").write_text('{"program": "deform", "status": "running"}')
        completed = self.deform("run", scene, "--out", self.folder / "x", "--plugin-path", FIXTURES)
        self.assertEqual(completed.returncode, 4, completed.stderr)
        shutil.copy(self.folder / "x" / "scene.json", self.out)
        (self.out / "probes.csv").write_text("hours of work")
        before = content(self.out)
        result = self.deform("run", scene, "--out", self.out, "--resume", "--plugin-path", FIXTURES)
        self.assertEqual(result.returncode, 4, result.stderr)
        self.assertIn("stays", result.stderr)
        self.assertEqual(content(self.out), before)

    def test_what_cannot_be_removed_is_in_nobodys_way(self):
        self.allow_another_user()
        scene = self.write(sheet())
        run = ("run", scene, "--out", self.out, "--force")
        self.deform_as_another_user(*run)
        locked = self.out / "vtk" / "kept"
        locked.mkdir()
        (locked / "file").write_text("kept")
        for path in (locked / "file", locked):
            os.chown(path, self.OTHER, self.OTHER)
        locked.chmod(0o555)
        result = self.deform_as_another_user(*run)
        self.assertRegex(result.stderr, r"warning: .*something stays: cannot remove \S+/out/")
        self.assertEqual(self.load("summary.json")["status"], "done")
        gone = self.out / ".deform-old-gone"
        self.assertTrue((gone / "vtk" / "kept" / "file").exists())
        # It can be used as ever, and goes when it can be removed.
        self.deform_as_another_user(*run)
        self.deform_as_another_user("run", scene, "--out", self.out, "--resume", "--set", "/duration=0.3")
        self.assertEqual([path.name for path in self.out.glob(".deform-old*")], [gone.name])
        (gone / "vtk" / "kept").chmod(0o755)
        self.deform_as_another_user("report", self.out)
        self.assertEqual(list(self.out.glob(".deform-*")), [])

    def test_killed_before_its_first_step(self):
        self.run_scene(sheet())
        before = content(self.out)
        slow = self.write(sheet(surface=dict(sheet()["surface"], nodes=[257, 257]), outputs=[],
                                integrator={"plugin": "backward_euler", "step": 0.02}), "slow.json")
        process = self.start("run", slow, "--out", self.out, "--force")
        self.wait_for(self.out / ".deform-old", process)
        process.kill()
        process.communicate(timeout=TIMEOUT)
        result = self.deform("report", self.out)
        self.assertEqual(result.returncode, 0, result.stderr)
        after = content(self.out)
        for name in before:
            if name != "report.html":
                self.assertEqual(after[name], before[name], name)


class Links(FilesTest):
    def test_planted_links_are_not_followed(self):
        scene = self.scene_with_files()
        self.run_part(scene, "--set", "/duration=0.1")
        precious = self.folder / "precious"
        precious.write_text("kept")
        names = ("report.html.part", "manifest.json.part", "checkpoint.bin.part",
                 "summary.json.part", "scene.json.part", "vtk/surface_000006.vtp.part",
                 "vtk/surface.pvd.part")
        for name in names:
            (self.out / name).unlink(missing_ok=True)
            (self.out / name).symlink_to(precious)
        (self.out / "log.txt").unlink()
        (self.out / "log.txt").symlink_to(precious)
        self.run_part(scene, "--resume")
        self.assertEqual(precious.read_text(), "kept")
        (self.out / "report.html.part").symlink_to(precious)
        self.assertEqual(self.deform("report", self.out).returncode, 0)
        self.assertEqual(precious.read_text(), "kept")

    def test_what_is_gone_on_with_is_no_link(self):
        scene = self.scene_with_files()
        self.run_part(scene, "--set", "/duration=0.1")
        for name in ("probes.csv", "trajectory.bin", "vtk"):
            with self.subTest(name=name):
                elsewhere = self.folder / "elsewhere"
                shutil.move(self.out / name, elsewhere)
                (self.out / name).symlink_to(elsewhere)
                before = content(elsewhere) if elsewhere.is_dir() else elsewhere.read_bytes()
                result = self.deform("run", scene, "--out", self.out, "--resume")
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertEqual(
                    content(elsewhere) if elsewhere.is_dir() else elsewhere.read_bytes(), before)
                (self.out / name).unlink()
                shutil.move(elsewhere, self.out / name)


class Full(FilesTest):
    def limited(self, kilobytes, *arguments):
        """With a limit on the size of files, which stands in for a full disk."""
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (int(kilobytes * 2**10),) * 2)
        return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                              cwd=self.folder, timeout=TIMEOUT, restore_signals=False,
                              preexec_fn=limit)

    def test_comparison_whose_runs_cannot_write(self):
        scene = self.write(sheet(outputs=[]))
        # Too little for a trajectory's header, enough for the rest.
        result = self.limited(8, "compare", scene, "--out", self.out)
        self.assertEqual(result.returncode, 1, result.stdout + result.stderr)
        self.assertIn("File too large", result.stderr)
        self.assertRegex(result.stderr, r"cannot (write|make) \S+/out/\S+: File too large")
        self.assertNotIn("not a trajectory", result.stderr)

    def test_report_that_cannot_be_written(self):
        scene = self.write(sheet(outputs=[]))
        if not (Path(PROGRAM).parent.parent / "share" / "deform" / "report.html").exists():
            self.skipTest("the page of reports was not built")
        result = self.limited(100, "run", scene, "--out", self.out)
        self.assertEqual(result.returncode, 1, result.stdout + result.stderr)
        self.assertRegex(result.stderr, r"report\.html: File too large")
        self.assertEqual(self.load("summary.json")["status"], "done")


class Resumed(FilesTest):
    def test_left_over_variants_are_named(self):
        scene = self.write(sheet(variants={}))
        vary = ("compare", scene, "--out", self.out)
        self.assertEqual(self.deform(*vary, "--vary", "/material/density=0.1,0.2").returncode, 0)
        result = self.deform(*vary, "--resume", "--vary", "/material/density=0.2,0.3")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stderr, r"not of this comparison.*: density=0\.1\n")
        self.assertTrue((self.out / "density=0.1" / "summary.json").exists())

    def test_a_prolonged_run_keeps_its_interval(self):
        scene = self.write(sheet(outputs=[], variants={}, duration=5.0))
        self.run_part(scene, "--set", "/duration=1.0")  # 50 steps: a frame each
        self.run_part(scene, "--resume")                # 250 steps: a frame each 3, if begun anew
        self.assertIn("frames go on every 1 steps", (self.out / "log.txt").read_text())
        trajectory = (self.out / "trajectory.bin").read_bytes()
        header = 28 + int.from_bytes(trajectory[20:28], "little")
        said = json.loads(trajectory[28:header])
        start = header + 24 * said["nodes"] + 4 * (said["faces"] + 1 + said["corners"])
        frame = 16 + said["nodes"] * (24 + 4 * len(said["fields"]))
        steps = [int.from_bytes(trajectory[at:at + 8], "little")
                 for at in range(start, len(trajectory), frame)]
        self.assertEqual(steps, list(range(251)))


class Refusals(FilesTest):
    """What is wrong with the input is not the program's error."""

    def refuse(self, *arguments, words=(), cwd=None):
        result = subprocess.run([PROGRAM, *map(os.fsencode, arguments)], cwd=cwd or self.folder,
                                capture_output=True, timeout=TIMEOUT)
        said = result.stderr.decode(errors="replace")
        self.assertEqual(result.returncode, 2, said)
        self.assertNotIn("internal error", said)
        for word in words:
            self.assertIn(word, said)

    def test_hostile_json_of_a_run(self):
        for name, text in (("summary.json", '{"probes": 5}'), ("summary.json", '{"probes": {"a": 5}}'),
                           ("summary.json", '{"probes": {"a": {"unit": 5}}}'),
                           ("summary.json", '{"kind": 7, "status": 3, "probes": []}'),
                           ("manifest.json", '{"program": "deform", "status": [1], "plugins": 3}'),
                           ("manifest.json", '{"program": "deform", "results": [3], "seconds": 5}'),
                           ("manifest.json", '{"program": "deform", "results": {"file": 3}}'),
                           ("scene.json", "5")):
            with self.subTest(name=name, text=text):
                shutil.rmtree(self.out, ignore_errors=True)
                self.run_scene(sheet(outputs=[]))
                (self.out / name).write_text(text)
                result = self.deform("report", self.out)
                self.assertIn(result.returncode, (0, 2), result.stderr)
                result = self.deform("run", self.folder / "sheet.json", "--out", self.out, "--resume")
                self.assertEqual(result.returncode, 2, result.stderr)

    def test_json_that_nests_deep(self):
        deep = "[" * 200000 + "]" * 200000
        for name in ("scene.json", "manifest.json", "summary.json"):
            with self.subTest(name):
                shutil.rmtree(self.out, ignore_errors=True)
                self.run_scene(sheet(outputs=[]))
                (self.out / name).write_text('{"program": "deform", "a": ' + deep + "}")
                self.assertIn(self.deform("report", self.out).returncode, (0, 2))
                result = self.deform("run", self.folder / "sheet.json", "--out", self.out, "--resume")
                self.assertEqual(result.returncode, 2, result.stderr)

    def test_files_that_are_none(self):
        """To open a pipe takes for ever where nobody writes into it."""
        scene = self.write(sheet(outputs=[]))
        for name in ("manifest.json", "trajectory.bin", "summary.json", "scene.json", "checkpoint.bin", "probes.csv"):
            with self.subTest(name):
                shutil.rmtree(self.out, ignore_errors=True)
                self.run_scene(sheet(outputs=[]))
                (self.out / name).unlink()
                os.mkfifo(self.out / name)
                self.assertIn(self.deform("report", self.out).returncode, (0, 2))
                # What prolongs a run looks at its checkpoint, and not at its summary.
                result = self.deform("run", scene, "--out", self.out, "--resume", "--set", "/duration=0.4")
                self.assertEqual(result.returncode, 0 if name == "summary.json" else 2, result.stderr)
                self.assertNotIn("internal error", result.stderr)
                result = self.deform("run", scene, "--out", self.out, "--force")
                self.assertEqual(result.returncode, 2 if name == "manifest.json" else 0, result.stderr)

    def test_files_that_no_memory_holds(self):
        scene = self.write(sheet(outputs=[]))
        for name in ("checkpoint.bin", "scene.json", "manifest.json"):
            with self.subTest(name):
                shutil.rmtree(self.out, ignore_errors=True)
                self.run_scene(sheet(outputs=[]))
                os.truncate(self.out / name, 10 << 40)
                self.refuse("run", scene, "--out", self.out, "--resume", "--set", "/duration=100", words=[name])

    def test_hostile_json_of_a_comparison(self):
        scene = self.write(sheet(outputs=[]))
        for name, text in (("base/summary.json", '{"status": 5}'), ("base/manifest.json", "[]"),
                           ("base/manifest.json", '{"program": "deform", "status": 5, "plugins": [3]}'),
                           ("summary.json", '{"kind": "comparison", "variants": [5, {"name": 3}]}')):
            with self.subTest(name=name, text=text):
                shutil.rmtree(self.out, ignore_errors=True)
                self.assertEqual(self.deform("compare", scene, "--out", self.out).returncode, 0)
                (self.out / name).write_text(text)
                self.assertIn(self.deform("report", self.out).returncode, (0, 2))
                result = self.deform("compare", scene, "--out", self.out, "--resume")
                self.assertEqual(result.returncode, 0, result.stderr)
        (self.out / "manifest.json").write_text('{"kind": "comparison", "program": 5}')
        self.refuse("compare", scene, "--out", self.out, "--resume")
        (self.out / "manifest.json").write_text("{ broken")
        self.refuse("compare", scene, "--out", self.out, "--resume", words=["comparison"])

    def test_a_report_reads_nothing_outside_of_its_folder(self):
        scene = self.write(sheet(outputs=[], title="of somebody else"))
        self.run_part(scene)
        comparison = self.out / "c"
        scene = self.write(sheet(outputs=[], variants={}))
        self.assertEqual(self.deform("compare", scene, "--out", comparison).returncode, 0)
        good = (comparison / "summary.json").read_text()
        shutil.move(comparison / "base", self.folder / "elsewhere")
        (comparison / "link").symlink_to(self.folder / "elsewhere")
        for name in ("..", ".", "", "../../out", "link", "/"):
            with self.subTest(name=name):
                summary = json.loads(good)
                summary["variants"][0]["folder"] = name
                (comparison / "summary.json").write_text(json.dumps(summary))
                data, said = self.shown(comparison)
                self.assertIn("warning: nothing is shown of ", said)
                self.assertIsNone(data["variants"][0]["manifest"])

    def test_names(self):
        scene = self.write(sheet())
        self.refuse("run", "", words=["names no file"])
        self.refuse("validate", "", words=["names no file"])
        self.refuse("run", scene, "--out", "", words=["--out"])
        self.refuse("compare", scene, "--out", "", words=["--out"])
        self.refuse("report", "")
        self.refuse("report", scene, words=["not a folder"])
        self.refuse("report", self.folder / "absent", words=["not there"])
        long = "x" * 300
        self.refuse("run", scene, "--out", long, words=["too long"])
        self.refuse("run", scene, "--out", long, "--resume", words=["too long"])
        self.refuse("compare", scene, "--out", long)
        self.refuse("compare", scene, "--out", long, "--resume")
        self.refuse("report", long)
        self.refuse("run", long)

    def test_a_working_directory_that_is_gone(self):
        gone = self.folder / "gone"
        gone.mkdir()
        scene = self.write(sheet())
        for command in (["run", scene], ["run", "sheet.json"], ["compare", scene], ["report", "out"],
                        ["validate", "sheet.json"]):
            gone.mkdir(exist_ok=True)
            result = subprocess.run(["sh", "-c", 'rmdir "$PWD"; exec "$@"', "sh", PROGRAM,
                                     *map(str, command)], cwd=gone, capture_output=True, text=True,
                                    timeout=TIMEOUT)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn("working directory", result.stderr)

    def test_a_folder_whose_name_is_not_utf8(self):
        folder = os.fsencode(self.folder) + b"/not\xff"
        os.mkdir(folder)
        scene = self.write(sheet(variants={}, outputs=["vtk"]))
        for arguments in ((b"run", os.fsencode(scene), b"--out", folder + b"/out"),
                          (b"report", folder + b"/out"),
                          (b"compare", os.fsencode(scene), b"--out", folder + b"/c")):
            result = subprocess.run([os.fsencode(PROGRAM), *arguments], capture_output=True,
                                    timeout=TIMEOUT)
            self.assertEqual(result.returncode, 0, result.stderr)
        self.scene_with_files()
        for name in FILES + ("sheet.json",):
            shutil.copy(os.fsencode(self.folder / name), folder)
        self.refuse("run", folder + b"/sheet.json", "--out", "o", words=["not UTF-8"])


if __name__ == "__main__":
    unittest.main()
