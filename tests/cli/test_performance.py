"""bench_sheet on a small sheet, and the page that is made from what it measures."""

import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

BENCH = os.environ["DEFORM_BENCH_SHEET"]
PERFORMANCE = Path(os.environ["DEFORM_SOURCE"]) / "scripts" / "performance"
TIMEOUT = 60  # seconds


def measured(file, *arguments):
    subprocess.run([BENCH, "--threads", "1", "--solver", "automatic", "--out", file, *arguments],
                   check=True, stderr=subprocess.DEVNULL, timeout=TIMEOUT)
    return json.loads(file.read_text())


class Performance(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="deform_performance_")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.file = self.folder / "sheet.json"

    def test_every_case_is_measured_and_shown(self):
        cases = measured(self.file, "--nodes", "9", "--steps", "3")
        self.assertEqual(len(cases), 8)  # three implicit integrators, two ways each; sheet P, two xi
        for case in cases:
            with self.subTest(case=case["integrator"]):
                self.assertEqual(case["status"], "done")
                self.assertEqual(case["steps"], 2)  # the first is counted by itself
                # A step is its parts and little else.
                self.assertLess(sum(case["parts_ms"].values()), 1.1 * case["ms"]["upper_quartile"])
                self.assertLessEqual(case["allocations"]["own"], case["allocations"]["total"])

    def test_steady_steps_allocate_nothing(self):
        cases = measured(self.file, "--nodes", "33", "--steps", "12", "--newton-error", "1e-4",
                         "--integrator", "backward_euler,bdf2")
        for case in cases:
            with self.subTest(case=case):
                self.assertEqual(case["allocations"]["own"], 0)  # the median: steps that fail may

    def kernels(self):
        """What bench_kernels writes, of one kernel."""
        run = {"run_type": "iteration", "real_time": 2.0, "time_unit": "ms"}
        return {"benchmarks": [
            {**run, "run_name": "triad/threads:1/real_time", "bytes": 8e7},
            {**run, "run_name": "arithmetic/threads:1/real_time", "flops": 2e8},
            {**run, "run_name": "tangent/n:9/threads:1/real_time", "bytes": 2e7, "flops": 1e7}]}
        page = self.folder / "performance.md"
        kernels = self.folder / "kernels.json"
        kernels.write_text(json.dumps(self.kernels()))
        subprocess.run([sys.executable, PERFORMANCE, "--program", BENCH, "--measured", self.file,
                        "--kernels", kernels,
                        "--out", self.folder, "--page", page], check=True, timeout=TIMEOUT)
        text = page.read_text()
        self.assertNotIn("[[", text)
        self.assertIn("| backward_euler | 1 |", text)
        # A quarter of the time that the triad's bandwidth allows.
        self.assertIn("| tangent | 9² | 1 | 2 | 20 | 10 | 0.5 | 25 % |", text)

    def test_a_case_that_fails_says_why(self):
        case = measured(self.file, "--nodes", "9", "--steps", "1", "--scene", "hanging",
                        "--integrator", "no_such")[0]
        self.assertIn("no_such", case["status"])

    def test_a_case_that_takes_too_long_is_ended(self):
        case = measured(self.file, "--nodes", "1025", "--scene", "hanging", "--integrator", "bdf2",
                        "--seconds", "1")[0]
        self.assertEqual(case["status"], "not done after 1 s")


if __name__ == "__main__":
    unittest.main()
