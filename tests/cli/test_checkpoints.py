"""Whatever stops a run, it can be resumed, and ends with the same bits; what is no checkpoint is refused.

DEFORM_KILLS: how often a run is killed at a random moment (default 10).
DEFORM_KILLED_SECONDS: about how long the run that is killed takes (default 0.5).
"""

import json
import os
import random
import resource
import shutil
import signal
import subprocess
import time
import unittest
from pathlib import Path

from test_run_command import PROGRAM, TIMEOUT, RunCommand, sheet

KILLS = int(os.environ.get("DEFORM_KILLS", "10"))
KILLED_SECONDS = float(os.environ.get("DEFORM_KILLED_SECONDS", "0.5"))
# Of the run itself, not of what it computed; the table and the files of the outputs are all compared.
ABOUT_THE_RUN = {"log.txt", "manifest.json", "report.html"}


def scene(**changes):
    """60 steps of a sheet with all that has a memory: mirror image, series of files, running extremes."""
    changes.setdefault("duration", 1.2)
    changes.setdefault("checkpoint", {"every": 4, "seconds": 0})
    changes.setdefault("probes", ["energy", {"plugin": "lowest", "every": 4},
                                  {"plugin": "mirror_asymmetry", "every": 3}])
    changes.setdefault("outputs", [{"plugin": "vtk", "every": 3}, {"plugin": "obj", "every": 7}])
    return sheet(variants={}, **changes)


def results(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in Path(folder).rglob("*")
            if path.is_file() and path.name not in ABOUT_THE_RUN}


class Checkpoints(RunCommand):
    def start(self, scene_file, *arguments, out=None, **options):
        return subprocess.Popen(
            [PROGRAM, "run", str(scene_file), "--out", str(out or self.out), *arguments],
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, **options)

    def run_whole(self, scene_file):
        whole = self.folder / "whole"
        result = self.deform("run", scene_file, "--out", whole)
        self.assertEqual(result.returncode, 0, result.stderr)
        return results(whole)

    def resume(self, scene_file, *arguments, expect=0, out=None):
        result = self.deform("run", scene_file, "--out", out or self.out, "--resume", *arguments)
        self.assertEqual(result.returncode, expect, result.stderr)
        return result

    def assert_same_results(self, expected, folder=None):
        found = results(folder or self.out)
        self.assertEqual(sorted(found), sorted(expected))
        for name, content in expected.items():
            self.assertTrue(found[name] == content, f"{name} differs")

    def run_limited(self, megabytes, *arguments):
        """With a limit on the size of files, which stands in for a full disk."""
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (int(megabytes * 2**20),) * 2)
        # Python ignores SIGXFSZ, and so does what it starts this way.
        return subprocess.run([PROGRAM, "run", *map(str, arguments)], capture_output=True, text=True,
                              timeout=TIMEOUT, restore_signals=False, preexec_fn=limit)

    def wait_for_checkpoint(self, process):
        deadline = time.monotonic() + TIMEOUT
        while not (self.out / "checkpoint.bin").exists():
            self.assertIsNone(process.poll(), "the run ended by itself")
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.005)


class Stopped(Checkpoints):
    def whole_run_to_kill(self):
        """A scene that runs for about KILLED_SECONDS, its results and its time."""
        duration = 1.2
        for _ in range(4):
            path = self.write(scene(duration=duration))
            shutil.rmtree(self.folder / "whole", ignore_errors=True)
            started = time.monotonic()
            expected = self.run_whole(path)
            taken = time.monotonic() - started
            if taken > 0.8 * KILLED_SECONDS:
                break
            duration = 0.02 * round(duration / 0.02 * min(20, KILLED_SECONDS / taken))
        return path, expected, taken

    def kill_once(self, path, seconds):
        """Returns whether the run was still there to be killed."""
        had_checkpoint = (self.out / "checkpoint.bin").exists()
        process = self.start(path, "--resume")
        time.sleep(seconds)
        process.kill()
        _, said = process.communicate(timeout=TIMEOUT)
        self.assertIn(process.returncode, (0, -signal.SIGKILL), said)
        if had_checkpoint or len(list(self.out.glob("vtk/*.vtp"))) > 1:
            self.assertTrue((self.out / "checkpoint.bin").exists(), "the checkpoint is lost")
        return process.returncode == -signal.SIGKILL

    def test_killed_at_random_moments(self):
        path, expected, whole_time = self.whole_run_to_kill()
        moment = random.Random(1)
        outcomes = {"before its first checkpoint": 0, "after one": 0, "twice": 0, "not at all": 0}
        kills = 0
        while kills < KILLS:
            with self.subTest(kill=kills):
                shutil.rmtree(self.out, ignore_errors=True)
                killed = self.kill_once(path, moment.uniform(0, 0.95 * whole_time))
                if killed and moment.random() < 0.3:  # some again, when they were resumed
                    outcomes["twice"] += self.kill_once(path, moment.uniform(0, 0.5 * whole_time))
                kills += killed  # only those that were killed count
                if not killed:  # it is faster than when it was measured
                    whole_time *= 0.95
                has_checkpoint = (self.out / "checkpoint.bin").exists()
                outcomes["not at all" if not killed else "after one" if has_checkpoint
                         else "before its first checkpoint"] += 1
                said = self.resume(path).stderr
                self.assertEqual("starts anew" in said, not has_checkpoint, said)
                self.assert_same_results(expected)
        print(f"{kills} runs of {whole_time:.2f} s killed: {outcomes}")

    def test_interrupted(self):
        path = self.write(scene(duration=8.0, outputs=[{"plugin": "vtk", "every": 40}]))
        expected = self.run_whole(path)
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(signal=number.name):
                shutil.rmtree(self.out, ignore_errors=True)
                process = self.start(path)
                self.wait_for_checkpoint(process)
                process.send_signal(number)
                _, said = process.communicate(timeout=TIMEOUT)
                self.assertEqual(process.returncode, 130, said)
                self.assertIn("--resume", said)
                steps = self.load("summary.json")["steps"]
                self.assertLess(steps, 400)
                self.resume(path)
                self.assertEqual(self.load("manifest.json")["resumed_after_step"], steps)
                self.assert_same_results(expected)

    def test_prolonged_from_a_few_steps(self):
        path = self.write(scene())
        expected = self.run_whole(path)
        for step in (1, 21, 42):  # at 21 and 42 both outputs are due, at 1 neither is in the long run
            with self.subTest(step=step):
                shutil.rmtree(self.out, ignore_errors=True)
                self.run_scene(json.loads(path.read_text()), "--set", f"/duration={step * 0.02}")
                self.resume(path)
                self.assert_same_results(expected)

    def test_finished_run_says_so(self):
        path = self.write(scene())
        self.run_scene(scene())
        before = results(self.out)
        result = self.resume(path)
        self.assertIn("finished", result.stderr)
        self.assertEqual(results(self.out), before)

    def test_without_a_checkpoint_it_says_that_it_starts_anew(self):
        path = self.write(scene())
        expected = self.run_whole(path)
        self.assertIn("starts anew", self.resume(path).stderr)
        self.assert_same_results(expected)

    def test_turned_off_there_is_one_at_the_end_only(self):
        path = self.write(scene(duration=1e5, outputs=[], checkpoint={"seconds": 0}))
        process = self.start(path)
        while not (self.out / "probes.csv").exists() or (
                (self.out / "probes.csv").read_text().count("\n") < 50):
            time.sleep(0.01)
        self.assertFalse((self.out / "checkpoint.bin").exists())
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=TIMEOUT)
        self.assertTrue((self.out / "checkpoint.bin").exists())

    def test_seconds(self):
        path = self.write(scene(duration=1e5, outputs=[], checkpoint={"seconds": 0.05}))
        process = self.start(path)
        self.wait_for_checkpoint(process)
        process.kill()
        process.communicate(timeout=TIMEOUT)


class Refused(Checkpoints):
    def setUp(self):
        super().setUp()
        self.path = self.write(scene(duration=0.2))
        self.run_scene(scene(duration=0.2), "--set", "/duration=0.16")  # 8 of the 10 steps
        self.file = self.out / "checkpoint.bin"
        self.good = self.file.read_bytes()

    def refuse(self, *arguments, scene_file=None):
        before = results(self.out)
        message = self.resume(scene_file or self.path, *arguments, expect=2).stderr
        self.assertEqual(results(self.out), before, "something was changed")
        return message

    def test_another_scene(self):
        message = self.refuse("--set", "/material/density=0.3")
        self.assertIn("another scene", message)
        self.assertIn("/material/density", message)

    def test_scene_that_ends_before(self):
        self.assertIn("ends with step 4", self.refuse("--set", "/duration=0.08"))

    def test_with_force(self):
        self.assertIn("--force", self.refuse("--force"))

    def test_cut_short(self):
        sizes = {0, 1, 17, 18, 21, 22, 64, 150, 182, len(self.good) - 65, len(self.good) - 1}
        for size in sizes | set(random.Random(1).sample(range(len(self.good)), 10)):
            with self.subTest(size=size):
                self.file.write_bytes(self.good[:size])
                self.assertIn(str(self.file), self.refuse())

    def test_flipped_bits(self):
        moment = random.Random(2)
        positions = moment.sample(range(len(self.good)), 200)
        for position in positions:
            with self.subTest(position=position):
                bad = bytearray(self.good)
                bad[position] ^= 1 << moment.randrange(8)
                self.file.write_bytes(bad)
                self.assertIn(str(self.file), self.refuse())
        self.file.write_bytes(self.good)
        self.resume(self.path)

    def test_no_file(self):
        self.file.unlink()
        self.file.mkdir()
        result = self.deform("run", self.path, "--out", self.out, "--resume")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn(str(self.file), result.stderr)


class FullDisk(Checkpoints):
    def test_file_system_without_space(self):
        disk = self.folder / "disk"
        disk.mkdir()
        mounted = shutil.which("mount") and subprocess.run(
            ["mount", "-t", "tmpfs", "-o", "size=512k", "tmpfs", str(disk)],
            capture_output=True).returncode == 0
        if not mounted:
            self.skipTest("mounting a small file system is not permitted")
        self.addCleanup(subprocess.run, ["umount", str(disk)], check=True)
        path = self.write(scene())
        expected = self.run_whole(path)
        self.assertGreater(sum(map(len, expected.values())), 2**19)
        result = self.deform("run", path, "--out", disk / "out")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("No space left on device", result.stderr)
        self.assertIn(str(disk / "out"), result.stderr)
        # With space, it goes on.
        shutil.copytree(disk / "out", self.out)
        self.resume(path)
        self.assert_same_results(expected)

    def test_table_that_cannot_grow(self):
        path = self.write(scene(outputs=[], duration=4.0, frames={"write": False}))
        expected = self.run_whole(path)
        result = self.run_limited(0.02, path, "--out", self.out)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("probes.csv: File too large", result.stderr)
        self.assertNotIn("starts anew", self.resume(path).stderr)
        self.assert_same_results(expected)

    def test_checkpoint_that_cannot_be_written_leaves_the_one_before(self):
        surface = {"plugin": "grid", "nodes": [33, 33], "size": [1.0, 1.0],
                   "differences": "forward"}
        path = self.write(scene(outputs=[], surface=surface, duration=0.4, probes=["lowest"],
                                frames={"write": False}))
        expected = self.run_whole(path)
        self.run_scene(json.loads(path.read_text()), "--set", "/duration=0.16")
        before = (self.out / "checkpoint.bin").read_bytes()
        result = self.run_limited(0.02, path, "--out", self.out, "--resume")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("checkpoint.bin: File too large", result.stderr)
        self.assertEqual((self.out / "checkpoint.bin").read_bytes(), before)
        self.assertEqual(list(self.out.rglob("*.part")), [])
        self.resume(path)
        self.assert_same_results(expected)

    def test_output_that_cannot_be_written(self):
        path = self.write(scene(checkpoint={"seconds": 0}))
        expected = self.run_whole(path)
        result = self.run_limited(0.01, path, "--out", self.out)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertRegex(result.stderr, r"cannot write .*\.(vtp|obj): File too large")
        self.resume(path)
        self.assert_same_results(expected)

    def test_folder_that_cannot_be_made(self):
        path = self.write(scene())
        (self.folder / "file").write_text("no folder")
        result = self.deform("run", path, "--out", self.folder / "file" / "run")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn(str(self.folder / "file" / "run"), result.stderr)
        self.assertIn("Not a directory", result.stderr)


if __name__ == "__main__":
    unittest.main()
