"""Every bad scene ends with code 2, at once, says where and what is wrong, and leaves no trace."""

import concurrent.futures
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "bad_scenes"))
import cases  # noqa: E402

PROGRAM = os.environ["DEFORM_PROGRAM"]
TIMEOUT = 10  # seconds; what a scene takes is printed, and far below one without sanitizers
MOST_MEMORY = 1 << 30  # bytes of address space beyond what the program has for itself


def limit_memory():
    """A scene that makes the program allocate without bound is to fail here, not to be noticed."""
    if not os.environ.get("ASAN_OPTIONS"):  # the shadow memory of the sanitizers is terabytes large
        resource.setrlimit(resource.RLIMIT_AS, (4 * MOST_MEMORY, 4 * MOST_MEMORY))


def deform(folder, *arguments):
    start = time.monotonic()
    result = subprocess.run([PROGRAM, *arguments], cwd=folder, capture_output=True, text=True,
                            encoding="utf-8", timeout=TIMEOUT, stdin=subprocess.DEVNULL,
                            preexec_fn=limit_memory)
    return result, time.monotonic() - start


def listing(folder):
    return sorted((path.relative_to(folder), path.stat().st_mtime_ns)
                  for path in folder.rglob("*"))


class BadScenes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory(prefix="deform_bad_scenes_")
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = Path(temporary.name)
        cases.write_all(cls.folder)

    def check_messages(self, case, stderr):
        """One line of stderr names the place, the rule and the nearest name."""
        where = case.place + ":" if case.place.startswith("at ") else case.place
        for line in stderr.splitlines():
            self.assertLess(len(line), 6000, "a message that nobody can read")
            starts = line.startswith("deform: scene.json:")
            if not (starts and where in line and case.rule in line):
                continue
            self.assertRegex(line, r"^deform: scene\.json:\d+:\d+: ")
            if case.near:
                self.assertIn(f'did you mean "{case.near}"?', line)
            return
        self.fail(f"no line with {case.place!r} and {case.rule!r} in:\n{stderr[:2000]}")

    def check(self, case):
        folder = self.folder / case.name
        before = listing(folder)
        validated, seconds = deform(folder, "validate", "scene.json")
        self.assertEqual(validated.returncode, 2, validated.stderr[:2000])
        self.assertEqual(validated.stdout, "")
        self.check_messages(case, validated.stderr)
        if not case.runs:
            run, seconds_of_run = deform(folder, "run", "scene.json", "--out", "out")
            self.assertEqual(run.returncode, 2, run.stderr[:2000])
            self.assertEqual(run.stderr, validated.stderr, "run and validate differ")
            seconds = max(seconds, seconds_of_run)
        self.assertEqual(listing(folder), before, "something was written")
        return seconds

    def test_each_case(self):
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            results = {case.name: pool.submit(self.check, case) for case in cases.CASES}
            seconds = {}
            for name, result in results.items():
                with self.subTest(name):
                    seconds[name] = result.result()
        slowest = max(seconds, key=seconds.get)
        print(f"{len(seconds)} bad scenes; the slowest, {slowest}, took {seconds[slowest]:.2f} s",
              file=sys.stderr)

    def test_good_scenes(self):
        for name in cases.GOOD:
            with self.subTest(name):
                result, _ = deform(self.folder / f"good_{name}", "validate", "scene.json")
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertRegex(result.stdout, r"^scene\.json: ok \(\d+ variants?\)\n$")


class AllAtOnce(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="deform_bad_scenes_")
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def write(self, changes, name="scene.json"):
        (self.folder / name).write_text(cases.text_of(changes), encoding="utf-8")

    def test_ten_problems(self):
        """Of the reader and of the parts that it found nothing wrong with, base and variants."""
        self.write({
            "/materal": {},
            "/material/density": -1,
            "/energies/1/form": "expandet",
            "/forces/0/where/centre": [5, 5],
            "/constraints/0/where": {"boundary": "lift"},
            "/integrator/plugin": "semi_implicit ",
            "/duration": "2",
            "/outputs/0/every": 0,
            "/probes/1": "lowst",
            "/variants": {"v": {"/energies/7": 1}, "w": {"/forces/0/where": {"node": 81}}},
        })
        result, _ = deform(self.folder, "validate", "scene.json")
        self.assertEqual(result.returncode, 2)
        found = re.findall(r"at (/\S+): ", result.stderr)
        self.assertEqual(sorted(found), sorted([
            "/materal", "/material/density", "/energies/1/form", "/forces/0/where",
            "/constraints/0/where", "/integrator/plugin", "/duration", "/outputs/0/every",
            "/probes/1", "/variants/v/~1energies~17", "/forces/0/where"]), result.stderr)
        self.assertEqual(result.stderr.count("\n"), 11)

    def test_a_hundred_problems_are_said_and_the_others_counted(self):
        for count in (100, 101, 5000):
            self.write({f"/x{i}": i for i in range(count)})
            result, _ = deform(self.folder, "validate", "scene.json")
            self.assertEqual(result.stderr.count("a scene has no"), 100)
            more = re.findall(r"and (\d+) more problems", result.stderr)
            self.assertEqual(more, [str(count - 100)] if count > 100 else [])

    def test_problems_that_variants_share_are_said_once(self):
        self.write({"/forces/0/where/centre": [5, 5],
                    "/variants": {"a": {"/duration": 1}, "b": {"/duration": 2},
                                  "c": {"/forces/0/where/centre": [6, 6]}}})
        result, _ = deform(self.folder, "validate", "scene.json")
        lines = result.stderr.splitlines()
        self.assertEqual(len(lines), 2, result.stderr)
        self.assertNotIn("variant", lines[0])
        self.assertIn('variant "c": at /forces/0/where: selects no node', lines[1])

    def test_several_scenes(self):
        self.write({"/duration": -1}, "bad.json")
        self.write({"/variants": {"a": {}}}, "good.json")
        result, _ = deform(self.folder, "validate", "good.json", "bad.json", "missing.json",
                           "good.json")
        self.assertEqual(result.returncode, 2)
        self.assertEqual(result.stdout, "good.json: ok (1 variant)\n" * 2)
        self.assertIn("bad.json:", result.stderr)
        self.assertIn("missing.json: the file does not exist", result.stderr)

    def test_places_of_replacements(self):
        self.write({})
        result, _ = deform(self.folder, "run", "scene.json", "--set",
                           "/forces/0/where/centre=[5,5]", "--out", "out")
        self.assertEqual(result.returncode, 2)
        self.assertIn("at /forces/0/where: selects no node", result.stderr)
        self.assertFalse((self.folder / "out").exists())


if __name__ == "__main__":
    unittest.main(verbosity=2)
