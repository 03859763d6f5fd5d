"""How `deform` ends, and what it says on the way: signals, plugins that end the process, streams that cannot
be written, texts that terminals take for orders."""

import copy
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import time
import unittest
from pathlib import Path

from test_broken_plugins import BrokenPlugins, FIXTURES, PROGRAM, SHEET, TIMEOUT, sheet

DONE, INTERNAL, BAD_INPUT, PLUGIN_FAILED, INTERRUPTED = 0, 1, 2, 4, 130

# With AddressSanitizer signals are its own.
HAS_SANITIZER = b"__asan_init" in Path(PROGRAM).read_bytes()

INTEGRATORS = [{"plugin": name} for name in ("semi_implicit", "symplectic_euler", "runge_kutta", "backward_euler",
                                             "implicit_midpoint", "bdf2", "static")]
INTEGRATORS.append({"plugin": "backward_euler", "error": 1e-3, "largest_step": 0.005})


def held_sheet(**changes):
    """What every integrator can do: soft enough for explicit steps, held all round for statics."""
    scene = copy.deepcopy(SHEET)
    scene["energies"][0]["eta"] = 1.0
    scene["forces"] = [{"plugin": "gravity", "acceleration": [0, 0, -0.1]}]
    scene["constraints"] = [{"plugin": "pin", "where": {"boundary": "all"}}]
    scene.update(changes)
    return scene


def slow_sheet(integrator, **changes):
    """Each evaluation from the third step on (explicit steps: the fourth) takes as many seconds as
    DEFORM_FIXTURE_SECONDS says; none where it says nothing."""
    scene = held_sheet(integrator={**integrator, "step": 0.02}, checkpoint={"every": 1})
    scene["energies"][1] = {"plugin": "bending_variational", "xi": 1e-6}
    scene["forces"][0]["time"] = {"ramp": [0, 1]}  # so that statics has something to do in every step
    scene["forces"].append({"plugin": "slow", "from": 0.047})
    scene.update(changes)
    return scene


class Interrupted(BrokenPlugins):
    def start(self, *arguments, seconds, **how):
        process = subprocess.Popen([PROGRAM, *map(str, arguments)], text=True, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, stdin=subprocess.DEVNULL,
                                   env={**os.environ, "DEFORM_FIXTURE_SECONDS": str(seconds)}, **how)
        self.addCleanup(process.kill)
        return process

    def wait_for_second_step(self, process, folder):
        """Until its row is there: the third is being taken then."""
        deadline = time.monotonic() + TIMEOUT
        table = folder / "probes.csv"
        while not (table.exists() and table.read_text().count("\n") >= 4):
            self.assertIsNone(process.poll(), "ended by itself")
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.02)

    def stop_in_a_long_step(self, process, *folders):
        for folder in folders:
            self.wait_for_second_step(process, folder)
        time.sleep(0.3)  # explicit steps have one more to go
        process.send_signal(signal.SIGTERM)
        # The step would take minutes. No test is timed: on a machine at work two seconds become more.
        _, said = process.communicate(timeout=60)
        self.assertEqual(process.returncode, INTERRUPTED, said)
        return said

    def resumes_to_the_same_bits(self, scene, *arguments):
        whole = self.folder / "whole"
        self.assertEqual(self.deform("run", scene, "--out", whole, "--force", *arguments).returncode, DONE)
        result = self.deform("run", scene, "--out", self.out, "--resume", *arguments)
        self.assertEqual(result.returncode, DONE, result.stderr)
        for name in ("probes.csv", "trajectory.bin"):
            self.assertEqual((self.out / name).read_bytes(), (whole / name).read_bytes(), name)

    def stops_and_resumes(self, integrator, seconds):
        scene = self.write(slow_sheet(integrator))
        arguments = ("--plugin-path", FIXTURES)
        shutil.rmtree(self.out, ignore_errors=True)
        process = self.start("run", scene, "--out", self.out, *arguments, seconds=seconds)
        said = self.stop_in_a_long_step(process, self.out)
        self.assertRegex(said, "interrupted within step [34] of 5.*--resume goes on after step [23]")
        for name in ("summary.json", "manifest.json"):
            found = json.loads((self.out / name).read_text())
            self.assertEqual(found["status"], "interrupted")
            self.assertIn(found["steps"], (2, 3))
        self.resumes_to_the_same_bits(scene, *arguments)

    def test_where_nobody_asks(self):
        """A single evaluation takes minutes, as a factorisation may."""
        for integrator in INTEGRATORS:
            with self.subTest(integrator=integrator):
                self.stops_and_resumes(integrator, 120)

    def test_between_evaluations(self):
        """A step takes minutes, with hundreds of evaluations for its Jacobian's differences."""
        for name in ("backward_euler", "static"):
            with self.subTest(integrator=name):
                self.stops_and_resumes({"plugin": name}, 0.4)

    def test_the_second_signal_ends_it_at_once(self):
        scene = self.write(slow_sheet({"plugin": "static"}))
        process = self.start("run", scene, "--out", self.out, "--plugin-path", FIXTURES, seconds=120)
        self.wait_for_second_step(process, self.out)
        process.send_signal(signal.SIGTERM)
        time.sleep(0.5)  # less, and it may be the same request
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, INTERRUPTED)
        # Nothing was written any more, not even how it ended.
        self.assertEqual(json.loads((self.out / "manifest.json").read_text())["status"], "running")
        self.resumes_to_the_same_bits(scene, "--plugin-path", FIXTURES)

    def test_one_request_in_two_signals(self):
        """What `timeout` sends to the process, and to its group."""
        scene = self.write(slow_sheet({"plugin": "semi_implicit"}))
        process = self.start("run", scene, "--out", self.out, "--plugin-path", FIXTURES, seconds=120)
        self.wait_for_second_step(process, self.out)
        process.send_signal(signal.SIGTERM)
        time.sleep(0.05)
        process.send_signal(signal.SIGTERM)
        _, said = process.communicate(timeout=60)
        self.assertEqual(process.returncode, INTERRUPTED, said)
        self.assertIn("interrupted within step 3 of 5", said)
        self.assertEqual(json.loads((self.out / "manifest.json").read_text())["status"], "interrupted")

    def test_what_is_ignored_stays_ignored(self):
        for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM):
            with self.subTest(number):
                scene = self.write(slow_sheet({"plugin": "semi_implicit"}))
                process = self.start("run", scene, "--out", self.out, "--force", "--plugin-path", FIXTURES, seconds=0.4,
                                     preexec_fn=lambda: signal.signal(number, signal.SIG_IGN))
                self.wait_for_second_step(process, self.out)
                process.send_signal(number)
                _, said = process.communicate(timeout=60)
                self.assertEqual(process.returncode, DONE, said)
                shutil.rmtree(self.out)

    def test_while_a_comparison_makes_plugins(self):
        """Ctrl-C goes to the whole group, also to the process that makes them."""
        scene = self.write(slow_sheet({"plugin": "semi_implicit"}))
        scene_of_one = json.loads(scene.read_text())
        scene_of_one["forces"][1]["being_made"] = True
        scene.write_text(json.dumps(scene_of_one))
        process = self.start("compare", scene, "--out", self.out, "--plugin-path", FIXTURES, "--reference", "refined",
                             seconds=120, start_new_session=True)
        deadline = time.monotonic() + TIMEOUT
        while not Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text():
            self.assertIsNone(process.poll())
            self.assertLess(time.monotonic(), deadline)
        time.sleep(0.2)
        os.killpg(process.pid, signal.SIGINT)
        _, said = process.communicate(timeout=60)
        self.assertEqual(process.returncode, INTERRUPTED, said)
        self.assertNotIn("plugin", said)

    def test_a_comparison(self):
        scene = slow_sheet({"plugin": "static"}, variants={"stiff": {"/energies/0/eta": 2.0}})
        process = self.start("compare", self.write(scene), "--out", self.out, "--jobs", "2", "--plugin-path", FIXTURES,
                             seconds=120)
        said = self.stop_in_a_long_step(process, self.out / "base", self.out / "stiff")
        self.assertIn("--resume", said)
        for run in ("base", "stiff"):
            manifest = json.loads((self.out / run / "manifest.json").read_text())
            self.assertEqual(manifest["status"], "interrupted")

    def stops_outside_of_the_model(self, told, steps, **changes):
        """A step, all that is recorded, and what begins and ends it are given up alike."""
        scene = slow_sheet({"plugin": "semi_implicit"}, **changes)
        del scene["forces"][1]
        scene = self.write(scene)
        shutil.rmtree(self.out, ignore_errors=True)
        process = self.start("run", scene, "--out", self.out, "--plugin-path", FIXTURES, seconds=120)
        said = self.stop_in_a_long_step(process, *([self.out] if steps else []))
        self.assertRegex(said, told)
        for name in ("summary.json", "manifest.json"):
            found = json.loads((self.out / name).read_text())
            self.assertEqual((found["status"], found["steps"]), ("interrupted", steps))
        self.resumes_to_the_same_bits(scene, "--plugin-path", FIXTURES)

    def test_while_a_step_is_recorded(self):
        for what, told, steps in (
                ({"probes": ["lowest", {"plugin": "slow", "from": 2}]},
                 "interrupted after 3 of 5 steps, before all was recorded; --resume goes on after step 3", 3),
                ({"outputs": [{"plugin": "slow", "from": 2}]},
                 "interrupted after 3 of 5 steps, before all was recorded; --resume goes on after step 3", 3),
                # The checkpoint after step 4 waits for the third step's files.
                ({"outputs": [{"plugin": "slow", "from": 2, "while": "behind"}]},
                 "interrupted after 4 of 5 steps, before all was recorded; --resume goes on after step 3", 4),
                ({"outputs": [{"plugin": "slow", "while": "ending"}]},
                 "interrupted after 5 of 5 steps, before all was recorded; --resume goes on after step 5", 5)):
            with self.subTest(what):
                self.stops_outside_of_the_model(told, steps, **what)

    def test_while_a_probe_follows_a_step(self):
        """The step is done then, and thrown away all the same."""
        self.stops_outside_of_the_model("interrupted within step 3 of 5.*--resume goes on after step 2$", 2,
                                        probes=["lowest", {"plugin": "slow", "from": 2, "while": "following"}])

    def test_before_the_first_step(self):
        scene = slow_sheet({"plugin": "semi_implicit"}, outputs=[{"plugin": "slow", "while": "beginning"}])
        process = self.start("run", self.write(scene), "--out", self.out, "--plugin-path", FIXTURES, seconds=120)
        while not (self.out / "probes.csv").exists():
            self.assertIsNone(process.poll())
            time.sleep(0.02)
        process.send_signal(signal.SIGTERM)
        _, said = process.communicate(timeout=60)
        self.assertEqual(process.returncode, INTERRUPTED, said)
        self.assertIn("interrupted after 0 of 5 steps, before all was recorded; there is no checkpoint yet", said)

    def test_long_steps_are_kept_though_no_checkpoint_is_due(self):
        scene = slow_sheet({"plugin": "semi_implicit"}, checkpoint={"seconds": 0})
        scene["forces"][1]["from"] = -1.0
        scene = self.write(scene)
        process = self.start("run", scene, "--out", self.out, "--plugin-path", FIXTURES, seconds=3)
        self.wait_for_second_step(process, self.out)
        self.assertFalse((self.out / "checkpoint.bin").exists())
        said = self.stop_in_a_long_step(process, self.out)
        self.assertIn("--resume goes on after step 2", said)
        self.resumes_to_the_same_bits(scene, "--plugin-path", FIXTURES)


@unittest.skipIf(HAS_SANITIZER, "signals are the sanitizer's")
class EndedByAPlugin(BrokenPlugins):
    """exit(0) is no success, and a crash tells whose it was."""

    CAUSES = {"exit": "exit()", "quick_exit": "exit()", "_exit": "_exit()", "abort": "abort()",
              "segfault": "segmentation fault", "overflow": "stack overflow", "division": "arithmetic exception"}
    ORIGIN = f"force/ends ({FIXTURES}/force-ends.so)"

    def test_in_a_step(self):
        for how, cause in self.CAUSES.items():
            self.ends_with(PLUGIN_FAILED, "force", {"plugin": "ends", "how": how}, self.ORIGIN,
                           "computing its force", cause)
            manifest = json.loads((self.out / "manifest.json").read_text())
            self.assertEqual((manifest["status"], manifest["exit_code"]), ("plugin failed", 4))
            self.assertIn(self.ORIGIN, manifest["reason"])
            self.assertIn(cause, manifest["reason"])

    def test_its_children_end_as_they_like(self):
        scene = self.write(sheet("force", {"plugin": "ends", "how": "child"}))
        result = self.deform("run", scene, "--out", self.out, "--plugin-path", FIXTURES)
        self.assertEqual((result.returncode, result.stderr), (DONE, ""))

    def test_in_a_constructor(self):
        for how, cause in self.CAUSES.items():
            use = {"plugin": "ends", "how": how, "when": "constructor"}
            said = self.ends_with(PLUGIN_FAILED, "force", use, self.ORIGIN, "being made", cause)
            self.assertEqual(len(said.splitlines()), 1, said)
            scene = self.write(sheet("force", use))
            result = self.deform("validate", scene, "--plugin-path", FIXTURES)
            self.assertEqual(result.returncode, PLUGIN_FAILED, result.stderr)
            self.assertIn(self.ORIGIN, result.stderr)

    def test_while_it_is_checked(self):
        for when in ("constructor", "step"):
            result = self.deform("plugin", "check", FIXTURES / "force-ends.so", "--parameters",
                                 json.dumps({"how": "segfault", "when": when}))
            self.assertEqual(result.returncode, PLUGIN_FAILED, result.stderr)
            self.assertIn(self.ORIGIN, result.stderr)

    def test_a_plugin_whose_path_is_no_text(self):
        plugins = os.fsencode(self.folder) + b"/p\xff\x9b31m"
        os.mkdir(plugins)
        shutil.copy(os.fsencode(FIXTURES / "force-ends.so"), plugins)
        scene = self.write(sheet("force", {"plugin": "ends", "how": "exit", "when": "step"}))
        result = subprocess.run([os.fsencode(PROGRAM), b"run", os.fsencode(scene), b"--out",
                                 os.fsencode(self.out), b"--plugin-path", plugins], capture_output=True,
                                timeout=TIMEOUT, cwd=self.folder)
        self.assertEqual(result.returncode, PLUGIN_FAILED, result.stderr)
        self.assertIn(b"/p??31m/force-ends.so", result.stderr)
        self.assertTrue(result.stderr.isascii())
        manifest = json.loads((self.out / "manifest.json").read_bytes().decode())
        self.assertEqual(manifest["status"], "plugin failed")
        self.assertIn("/p??31m/force-ends.so", manifest["reason"])

    def test_a_comparison_goes_on(self):
        scene = sheet("force", {"plugin": "ends", "how": "exit", "when": "constructor"})
        good = scene["forces"][:1]
        scene["variants"] = {"fine": {"/forces": good}, "refused": {"/forces/1/how": "segfault"},
                             "crashed": {"/forces/1/how": "overflow", "/forces/1/when": "step"},
                             "left": {"/forces/1/how": "_exit", "/forces/1/when": "step"}}
        result = self.deform("compare", self.write(scene), "--out", self.out, "--plugin-path", FIXTURES,
                             "--reference", "fine")
        self.assertEqual(result.returncode, DONE, result.stderr)
        runs = {run["name"]: run for run in json.loads((self.out / "summary.json").read_text())["variants"]}
        self.assertEqual(runs["fine"]["status"], "done")
        for name, cause in (("base", "exit()"), ("refused", "segmentation fault"), ("crashed", "stack overflow"),
                            ("left", "_exit()")):
            self.assertEqual(runs[name]["status"], "plugin failed", runs[name])
            self.assertIn(self.ORIGIN, runs[name]["reason"])
            self.assertIn(cause, runs[name]["reason"])


class Inherited(BrokenPlugins):
    """What whoever began the program left it with."""

    def program(self, *arguments, prepare, **how):
        return subprocess.run([PROGRAM, *map(str, arguments)], text=True, stderr=subprocess.PIPE, timeout=TIMEOUT,
                              cwd=self.folder, preexec_fn=prepare, **how)

    def test_ends_of_children_that_are_ignored(self):
        scene = self.write({**SHEET, "variants": {"heavy": {"/material/density": 0.2}}})
        result = self.program("compare", scene, "--out", self.out, "--quiet",
                              prepare=lambda: signal.signal(signal.SIGCHLD, signal.SIG_IGN))
        self.assertEqual(result.returncode, DONE, result.stderr)

    def test_files_that_may_not_grow(self):
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000))
        self.assertEqual(self.deform("run", self.write(SHEET), "--out", self.out).returncode, DONE)
        for arguments in (("schema",), ("schema", "--out", self.folder / "schemas"), ("report", self.out)):
            with self.subTest(arguments), open(self.folder / "said", "w") as said:
                result = self.program(*arguments, prepare=limit, stdout=said)
                self.assertEqual(result.returncode, INTERNAL, result.stderr)
                self.assertIn("cannot write", result.stderr)


class Streams(BrokenPlugins):
    """What cannot be said does not change what is done."""

    def shell(self, line, *arguments):
        return subprocess.run(["sh", "-c", f'exec "$@" {line}', "sh", PROGRAM, *map(str, arguments)], text=True,
                              capture_output=True, timeout=TIMEOUT, cwd=self.folder)

    def test_messages_that_cannot_be_written(self):
        bad = self.folder / "none.json"
        warns = self.write({**SHEET, "duration": 0.11})  # no whole number of steps: a warning
        for line in ("2>/dev/full", "2>&-"):
            with self.subTest(line):
                self.assertEqual(self.shell(line, "run", bad).returncode, BAD_INPUT)
                result = self.shell(line, "run", warns, "--out", self.out, "--force")
                self.assertEqual(result.returncode, DONE)
                self.assertIn("wall time", result.stdout)
                self.assertEqual(json.loads((self.out / "summary.json").read_text())["status"], "done")

    def test_results_that_cannot_be_written(self):
        for line in (">/dev/full", ">&-"):
            for arguments in (("plugins",), ("schema",), ("--help",), ("validate", self.write(SHEET)),
                              ("run", self.write(SHEET), "--out", self.out, "--force")):
                with self.subTest(line, arguments=arguments):
                    result = self.shell(line, *arguments)
                    self.assertEqual(result.returncode, INTERNAL, result.stderr)
                    self.assertIn("cannot write to standard output", result.stderr)
        self.assertTrue((self.out / "report.html").exists())  # the run is whole

    def test_no_file_takes_a_closed_streams_place(self):
        scene = self.write({**SHEET, "duration": 0.11})
        self.assertEqual(self.shell("<&- >&- 2>&-", "run", scene, "--out", self.out).returncode, INTERNAL)
        for file in self.out.rglob("*"):
            if file.is_file() and file.name not in ("log.txt", "report.html"):
                self.assertNotIn(b"whole number of steps", file.read_bytes(), file.name)


class Texts(BrokenPlugins):
    """Titles and paths are written by others."""

    # CSI, DEL, C1's CSI, a new line that forges a message, right-to-left override, isolate.
    ORDERS = "a\x1b[2Jb\x7fc\x9b31md\ndeform: forged\u202ee\u2066f"
    UNSAFE = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")

    def assert_safe(self, text):
        self.assertIsNone(self.UNSAFE.search(text), repr(text))
        for line in text.splitlines():
            self.assertFalse(line.startswith("deform: forged"), text)

    def assert_all_safe(self, result):
        self.assert_safe(result.stdout)
        self.assert_safe(result.stderr)

    def test_in_titles_labels_and_names(self):
        scene = held_sheet(title=self.ORDERS, duration=0.11)
        scene["probes"] = [{"plugin": "point", "where": {"boundary": "left"}, "label": self.ORDERS}, {"plugin": "lowest"}]
        scene["variants"] = {"heavy": {"/material/density": 0.2}}
        path = self.write(scene)
        named = self.folder / "named.json"
        named.write_text(json.dumps({**scene, "variants": {self.ORDERS: {"/material/density": 0.2}}}))
        for code, *arguments in ((DONE, "run", path, "--out", self.out, "--force"), (DONE, "validate", path),
                                 (DONE, "compare", path, "--out", self.folder / "c"),
                                 (BAD_INPUT, "run", path, "--variant", self.ORDERS), (BAD_INPUT, "run", self.ORDERS),
                                 (BAD_INPUT, "validate", named)):
            result = self.deform(*arguments)
            self.assertEqual(result.returncode, code, result.stderr)
            self.assert_all_safe(result)
        logs = list(self.folder.rglob("log.txt"))
        self.assertEqual(len(logs), 3)  # of the run, and of the two that were compared
        for log in logs:
            self.assert_safe(log.read_text())
            self.assertIn("\\u001b[2J", log.read_text())

    def test_in_paths(self):
        out = self.folder / "a\x1b[31m\u202eb"
        scene = self.write(SHEET)
        for code, *arguments in ((DONE, "run", scene, "--out", out), (BAD_INPUT, "run", scene, "--out", out),
                                 (BAD_INPUT, "report", self.folder / self.ORDERS), (BAD_INPUT, self.ORDERS),
                                 (BAD_INPUT, "plugins", "--plugin-path", self.folder / self.ORDERS)):
            result = self.deform(*arguments)
            self.assertEqual(result.returncode, code, result.stderr)
            self.assert_all_safe(result)
            self.assertTrue(out.is_dir())


class Words(BrokenPlugins):
    """What is wrong with a command line is named, once."""

    def says(self, *arguments):
        result = self.deform(*arguments)
        self.assertEqual(result.returncode, BAD_INPUT, result.stderr)
        return result.stderr

    def test_words_that_are_no_commands(self):
        self.assertRegex(self.says("bogus"), '^deform: found "bogus", expected a command: run, compare, ')
        self.assertRegex(self.says("plugin", "bogus"), '^deform: found "bogus", expected a command: new, check')

    def test_replacements_without_a_value(self):
        scene = self.write(SHEET)
        for option, *command in (("--set", "run"), ("--set", "compare"), ("--vary", "compare")):
            said = self.says(*command, scene, option, "density")
            self.assertEqual(said.count(option), 1, said)
            self.assertIn("'density' is not of the form", said)


class Times(BrokenPlugins):
    def test_parts_are_no_more_than_the_whole(self):
        # A Jacobian by differences evaluates forces, whose time is its own.
        scene = held_sheet(duration=0.06)
        for integrator in ("semi_implicit", "backward_euler", "static", "runge_kutta"):
            scene["integrator"] = {"plugin": integrator, "step": 0.02}
            scene["energies"][1] = {"plugin": "bending", "xi": 1e-6, "normal": {"plugin": "exact"}}
            result = self.deform("run", self.write(scene), "--out", self.out, "--force")
            self.assertEqual(result.returncode, DONE, result.stderr)
            seconds = json.loads((self.out / "manifest.json").read_text())["seconds"]
            whole = seconds.pop("all_steps")
            self.assertLessEqual(sum(seconds.values()), whole, integrator)
            self.assertGreaterEqual(min(seconds.values()), 0)


class Files(BrokenPlugins):
    """What a scene names may be anything that the system calls a file."""

    def test_maps_that_cannot_be_read(self):
        fifo = self.folder / "fifo"
        os.mkfifo(fifo)
        for path, why in (("/proc/self/mem", "cannot be read to its end"), ("/dev/zero", "not a regular file"),
                          (str(fifo), "not a regular file"), (str(self.folder), "is a folder")):
            scene = held_sheet(energies=[{"plugin": "koiter", "thickness": {"map": path}, "young": 1e6}])
            result = self.deform("run", self.write(scene), "--out", self.out)
            self.assertEqual(result.returncode, BAD_INPUT, result.stderr)
            self.assertIn(why, result.stderr)

    def test_many_constants(self):
        scene = held_sheet(duration=0.02)
        scene["surface"]["rest"] = {"plugin": "formula", "z": "k7*a1",
                                    "constants": {f"k{i}": i * 1e-6 for i in range(20000)}}
        self.assertEqual(self.deform("validate", self.write(scene)).returncode, DONE)


if __name__ == "__main__":
    unittest.main()
