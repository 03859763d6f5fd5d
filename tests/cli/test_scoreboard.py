"""The scoreboard at two of its resolutions: what the right methods promise, and that what is
wrong shows."""

import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

PROGRAM = os.environ["DEFORM_PROGRAM"]
SCOREBOARD = Path(os.environ["DEFORM_SCENES"]).parent / "scripts" / "scoreboard"
TIMEOUT = 240  # seconds


def measured(*arguments):
    with tempfile.TemporaryDirectory(prefix="deform_scoreboard_") as folder:
        figures = Path(folder) / "figures.json"
        subprocess.run([sys.executable, SCOREBOARD, "--program", PROGRAM, "--out", folder,
                        "--json", figures, "--fast", *arguments],
                       check=True, stdout=subprocess.DEVNULL, timeout=TIMEOUT)
        return json.loads(figures.read_text())


class Scoreboard(unittest.TestCase):
    def test_koiter_and_the_variational_form_converge_at_second_order(self):
        # At 129 nodes along the strip, 65 × 65 on plates and shells.
        strips = {"tip load 1": 2e-5, "tip load 5": 6e-5, "tip load 10": 8e-5,
                  "self-weight 1": 2e-5, "self-weight 5": 6e-5, "self-weight 20": 1.2e-4,
                  "roll-up": 6e-4}
        plates = {"supported plate": 1e-3, "supported plate, point load": 4e-3,
                  "clamped plate": 4e-3, "Scordelis-Lo roof": 4e-3}
        shells = {"pinched cylinder": 4e-3, "pinched hemisphere": 3e-3}
        for method in ("koiter, symmetric", "variational, symmetric"):
            found = measured("--methods", method)
            limits = strips | plates | (shells if method.startswith("koiter") else {})
            for problem, limit in limits.items():
                with self.subTest(method=method, problem=problem):
                    result = found[problem][method]
                    self.assertIsNone(result["reason"])
                    self.assertLess(result["errors"][-1], limit)
                    self.assertGreater(result["order"], 1.9 if problem in strips else 1.7)
            self.assertLess(found["lateral buckling"][method]["errors"][-1], 0.01)
            for width in (0.1, 0.3, 0.5, 0.7, 0.9) if method.startswith("koiter") else ():
                with self.subTest(width=width):  # at 33 × 17 nodes
                    wide = found[f"lateral buckling, width {width}"][method]
                    self.assertIsNone(wide["reason"])
                    self.assertLess(wide["errors"][-1], 0.02)

    def test_any_estimator_along_the_exact_normal_finds_the_elastica(self):
        found = measured("--methods", "divergence, symmetric", "--problems", "tip load 5")
        for method, result in found["tip load 5"].items():
            with self.subTest(method=method):
                self.assertIsNone(result["reason"])
                self.assertLess(result["errors"][-1], 1e-4)

    def test_the_paper_s_estimators_fall_short(self):
        found = measured("--methods", "paper", "--problems", "tip load 5")["tip load 5"]
        for method, result in found.items():
            with self.subTest(method=method):
                error = result["errors"][-1]
                if error is None:
                    self.assertIn(result["reason"], ("no equilibrium found", "singular tangent"))
                else:
                    self.assertIsNone(result["reason"])
                    self.assertTrue(0.05 < error < 1, error)
        self.assertIsNone(found["Terzopoulos, divergence, paper's grid"]["errors"][-1])
        self.assertIsNotNone(found["variational, paper's grid"]["errors"][-1])


class PressedFlat(unittest.TestCase):
    """A curved strip that is let go flat."""

    def compare(self, change):
        file = Path(os.environ["DEFORM_SCENES"]) / "benchmarks" / "pressed_flat_strip.json"
        scene = json.loads(re.sub(r"^\s*//.*$", "", file.read_text(), flags=re.MULTILINE))
        change(scene["variants"])
        with tempfile.TemporaryDirectory(prefix="deform_scoreboard_") as folder:
            changed = Path(folder) / "scene.json"
            changed.write_text(json.dumps(scene))
            return subprocess.run(
                [PROGRAM, "compare", changed, "--expect", file.with_suffix(".expect.json"),
                 "--out", Path(folder) / "c", "--quiet"], capture_output=True, timeout=TIMEOUT,
                env={**os.environ, "OPENBLAS_NUM_THREADS": "1"}).returncode

    def test_it_springs_back_but_under_the_fallback(self):
        self.assertEqual(self.compare(lambda variants: None), 0)

    def test_the_claims_can_fail(self):
        for of, rival in (("koiter", "fallback"), ("fallback", "exact"), ("exact", "fallback")):
            with self.subTest(of=of, rival=rival):
                self.assertEqual(
                    self.compare(lambda v, o=of, r=rival: v.update({o: v[r]})), 5)


class LateralBuckling(unittest.TestCase):
    def test_a_nudged_strip_leaves_its_plane_above_the_critical_load_only(self):
        scene = Path(os.environ["DEFORM_SCENES"]) / "benchmarks" / "lateral_buckling.json"
        nudge = {"plugin": "edge_load", "where": {"boundary": "right"}, "force": [0, 2e-9, 0]}
        with tempfile.TemporaryDirectory(prefix="deform_scoreboard_") as folder:
            out = Path(folder) / "run"
            subprocess.run([PROGRAM, "run", scene, "--set", f"/forces/-={json.dumps(nudge)}",
                            "--out", out, "--quiet"], check=True, timeout=TIMEOUT,
                           env={**os.environ, "OPENBLAS_NUM_THREADS": "1"})
            lines = (out / "probes.csv").read_text().splitlines()
        names = [re.sub(r" \[.*", "", name) for name in lines[0].split(",")]
        rows = [dict(zip(names, map(float, line.split(",")))) for line in lines[1:]]
        self.assertLess(rows[1]["tip.dy"], 1e-4)  # 0.95 of the critical load
        self.assertGreater(rows[3]["tip.dy"], 0.05)  # 1.05
        self.assertGreater(rows[4]["tip.dy"], rows[3]["tip.dy"])
        self.assertTrue(all(row["stability.lowest"] > 0 for row in rows))


if __name__ == "__main__":
    unittest.main()
