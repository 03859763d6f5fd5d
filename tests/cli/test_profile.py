"""What `deform run --profile` leaves: a trace whose spans nest, a table that adds up, no other bits."""

import json
import re
import signal
import subprocess
import time
import unittest

from test_checkpoints import Checkpoints, results, scene
from test_run_command import PROGRAM, TIMEOUT

FILES = {"profile.txt", "trace.json"}
ROW = re.compile(r"^( *)(\S.*?) +(\d+) +([\d.]+) +([\d.]+) % +(-?[\d.]+) +([\d.]+) +([\d.]+)$")
ROUNDING = 0.002  # of a figure of the table [ms]


def implicit_scene(**changes):
    """Newton's method, so that spans nest deeply."""
    return scene(integrator={"plugin": "backward_euler", "step": 0.02},
                 energies=[{"plugin": "stretching", "eta": 0.01},
                           {"plugin": "bending_variational", "xi": 1e-6}], **changes)


class Profile(Checkpoints):
    def run_profiled(self, scene_file, *arguments):
        result = self.deform("run", scene_file, "--out", self.out, "--profile", *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def events(self):
        """Complete events of the trace, in the order in which they began: parents first."""
        trace = json.loads((self.out / "trace.json").read_text())
        events = [e for e in trace["traceEvents"] if e["ph"] == "X"]
        for event in events:
            self.assertTrue({"name", "ts", "dur", "pid", "tid"} <= event.keys())
            self.assertGreaterEqual(event["dur"], 0)
        return sorted(events, key=lambda e: (e["ts"], -e["dur"]))

    def assert_nested(self, events):
        """Returns the path of names of every event."""
        paths, around = [], []
        for event in events:
            begin, end = event["ts"], event["ts"] + event["dur"]
            while around and begin >= around[-1][1] - 5e-4:  # half a nanosecond
                around.pop()
            if around:
                self.assertLessEqual(end, around[-1][1] + 5e-4, f"{event} leaves {around[-1]}")
            around.append((event["name"], end))
            paths.append(tuple(name for name, _ in around))
        return paths

    def table_rows(self):
        """(depth, name, calls, total, self) of each row of the table [ms]."""
        found = [ROW.match(line) for line in (self.out / "profile.txt").read_text().splitlines()]
        return [(len(m[1]) // 2, m[2], int(m[3]), float(m[4]), float(m[6])) for m in found if m]

    def test_changes_no_result(self):
        scene_file = self.write(implicit_scene())
        expected = self.run_whole(scene_file)
        self.run_profiled(scene_file)
        found = results(self.out)
        self.assertEqual(found.keys() - expected.keys(), FILES)
        for name, content in expected.items():
            self.assertTrue(found[name] == content, f"{name} differs")

    def test_spans_nest(self):
        self.run_profiled(self.write(implicit_scene()))
        paths = set(self.assert_nested(self.events()))
        newton = ("run", "step", "backward_euler", "stage", "Newton iteration")
        for path in [newton + ("tangent",), newton + ("geometry, stress and force",), newton + ("solve",),
                     newton + ("preparing the solver", "matrix filling"), ("run", "outputs", "vtk"),
                     ("run", "probes", "energy"), ("run", "trajectory"), ("run", "checkpoint")]:
            self.assertIn(path, paths)

    def test_table_adds_up(self):
        result = self.run_profiled(self.write(implicit_scene()))
        self.assertIn((self.out / "profile.txt").read_text(), result.stdout)
        rows = self.table_rows()
        self.assertEqual([row[1] for row in rows if row[0] == 0], ["run"])
        for i, (depth, name, _, total, own) in enumerate(rows):
            within = 0.0
            for row in rows[i + 1:]:
                if row[0] <= depth:
                    break
                within += row[3] if row[0] == depth + 1 else 0
            self.assertGreaterEqual(own, -ROUNDING, name)
            self.assertAlmostEqual(total, own + within, delta=20 * ROUNDING, msg=name)
        steps = [row for row in rows if row[:2] == (1, "step")]
        self.assertEqual([row[2] for row in steps], [60])
        seconds = json.loads((self.out / "manifest.json").read_text())["seconds"]["all_steps"]
        self.assertAlmostEqual(rows[0][3], 1e3 * seconds, delta=0.02 * 1e3 * seconds + 1)

    def test_table_and_trace_agree(self):
        self.run_profiled(self.write(implicit_scene()))
        events = self.events()
        for name in ["run", "step", "Newton iteration"]:
            of_name = [row for row in self.table_rows() if row[1] == name]
            self.assertEqual(sum(e["name"] == name for e in events), sum(r[2] for r in of_name))
            self.assertAlmostEqual(sum(e["dur"] for e in events if e["name"] == name) / 1e3,
                                   sum(r[3] for r in of_name), delta=ROUNDING)

    def test_quiet(self):
        result = self.run_profiled(self.write(implicit_scene()), "--quiet")
        self.assertEqual(result.stdout, "")
        self.assertTrue(FILES <= results(self.out).keys())

    def test_off(self):
        self.assertFalse(FILES & self.run_whole(self.write(implicit_scene())).keys())

    def test_interrupted(self):
        scene_file = self.write(implicit_scene(duration=2000, outputs=[]))
        process = self.start(scene_file, "--profile", "--quiet")
        try:
            self.wait_for_checkpoint(process)
            process.send_signal(signal.SIGTERM)
            process.communicate(timeout=TIMEOUT)
        finally:
            if process.poll() is None:
                process.kill()
                process.communicate()
        self.assertEqual(process.returncode, 130)
        paths = self.assert_nested(self.events())
        done = json.loads((self.out / "manifest.json").read_text())["steps"]
        self.assertEqual(paths.count(("run", "step")), done)

    def test_resumed(self):
        scene_file = self.write(implicit_scene())
        expected = self.run_whole(scene_file)
        half = self.deform("run", self.write(implicit_scene(duration=0.6)), "--out", self.out)
        self.assertEqual(half.returncode, 0, half.stderr)
        scene_file = self.write(implicit_scene())
        self.resume(scene_file, "--profile")
        found = results(self.out)
        for name in ["probes.csv", "trajectory.bin"]:
            self.assertTrue(found[name] == expected[name], f"{name} differs")
        steps = [row[2] for row in self.table_rows() if row[:2] == (1, "step")]
        self.assertEqual(steps, [30])  # of the resumed part alone


if __name__ == "__main__":
    unittest.main()
