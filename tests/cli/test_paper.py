"""Each figure of the paper: the claims beside its scene hold, and fail with a rival in its place."""

import json
import os
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

PROGRAM = os.environ["DEFORM_PROGRAM"]
PAPER = Path(os.environ["DEFORM_SCENES"]) / "paper"
TIMEOUT = 240  # seconds

GAUSS = '{"plugin": "gauss", "delta": 0.5}'
TERZOPOULOS = '{"plugin": "terzopoulos"}'

# Of each scene: what is put in place of what, and the runs that suffice to see it.
RIVALS = {
    "fig01_melting_cheese": ('"eta": 1e-6', '"eta": 0.01', ["base"]),
    "fig02_table_cloth": ("[0, 0, -0.001]", "[0, 0, -0.01]", ["base"]),
    "fig03_rubber_sheet": ('"/energies/0/eta": 1.0', '"/energies/0/eta": 0.1',
                           ["eta_0.01", "eta_0.1", "eta_1"]),
    "fig04_cardboard_pressed": ('"xi": 1e-8', '"xi": 1e-6', ["base", "exact"]),
    "fig05_fig07": (TERZOPOULOS, '{"plugin": "exact"}',
                    ["exact", "terzopoulos_1e-7", "terzopoulos_1e-6"]),
    "fig06_fig08": ('"infinity"', "0.5", ["exact", "fig06", "fig08"]),
    "fig09_lifting_cardboard": (GAUSS, TERZOPOULOS, ["base", "exact"]),
    "fig10_fig11_curtains": (GAUSS, TERZOPOULOS, ["wool", "wool_variational"]),
    "fig12_table_cardboard": (GAUSS, TERZOPOULOS, ["base", "variational"]),
}


def content(file):
    """Of a JSON file with comments."""
    return json.loads(re.sub(r"^\s*//.*$", "", file.read_text(), flags=re.MULTILINE))


def about(claim, runs, others):
    """Whether a claim speaks of these runs and of no others."""
    return not any(re.search(rf"(?<![\w.]){re.escape(run)}\.[a-z]", claim)
                   for run in others if run not in runs)


class Paper(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="deform_paper_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def compare(self, scene, claims, *arguments):
        return subprocess.run(
            [PROGRAM, "compare", scene, "--expect", claims, "--out", self.folder / "c", "--force",
             "--quiet", *arguments],
            capture_output=True, text=True, timeout=TIMEOUT,
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1"})

    def test_every_file_of_claims_has_a_rival(self):
        found = {file.name.removesuffix(".expect.json") for file in PAPER.glob("*.expect.json")}
        self.assertEqual(found, set(RIVALS))

    def test_claims_hold(self):
        for name in RIVALS:
            with self.subTest(name):
                done = self.compare(PAPER / f"{name}.json", PAPER / f"{name}.expect.json")
                self.assertEqual(done.returncode, 0, done.stderr)

    def test_claims_fail_with_the_rival(self):
        for name, (old, new, runs) in RIVALS.items():
            with self.subTest(name):
                text = re.sub(r"(?m)^\s*//.*$", "", (PAPER / f"{name}.json").read_text())
                self.assertIn(old, text)
                scene = json.loads(text.replace(old, new))
                others = ["base", *scene["variants"]]
                claims = [claim for claim in content(PAPER / f"{name}.expect.json")["claims"]
                          if about(claim, runs, others)]
                (self.folder / "rival.json").write_text(json.dumps(scene))
                (self.folder / "claims.json").write_text(json.dumps({"claims": claims}))
                done = self.compare(self.folder / "rival.json", self.folder / "claims.json",
                                    "--variants", ",".join(runs))
                self.assertEqual(done.returncode, 5, done.stderr)
                self.assertIn("does not hold", done.stderr)


class Folds(unittest.TestCase):
    """The probe that the hems' figures come from, on a wave whose folds are known."""

    def folds_of(self, amplitude):
        scene = {
            "title": "A wave",
            "surface": {"plugin": "grid", "nodes": [41, 5], "differences": "forward",
                        "initial": {"plugin": "wave", "amplitude": amplitude, "wavelength": 0.25}},
            "energies": [{"plugin": "stretching", "eta": 1e-6}],
            "integrator": {"plugin": "semi_implicit", "step": 1e-6},
            "duration": 1e-6,
            "probes": [{"plugin": "folds", "where": {"boundary": "bottom"}, "prominence": 0.01}],
        }
        with tempfile.TemporaryDirectory(prefix="deform_folds_") as folder:
            file = Path(folder) / "wave.json"
            file.write_text(json.dumps(scene))
            subprocess.run([PROGRAM, "run", file, "--out", Path(folder) / "out"], check=True,
                           capture_output=True, timeout=TIMEOUT)
            return json.loads((Path(folder) / "out" / "summary.json").read_text())["probes"]

    def test_crests_and_troughs_of_a_wave(self):
        """Four waves over the hem: three crests and four troughs between its ends."""
        probes = self.folds_of(0.02)
        self.assertEqual(probes["folds.count"]["final"], 7)
        self.assertAlmostEqual(probes["folds.wavelength"]["final"], 0.25, places=3)

    def test_what_does_not_stand_out_is_no_fold(self):
        probes = self.folds_of(0.004)  # 0.008 from crest to trough, below 0.01
        self.assertEqual(probes["folds.count"]["final"], 0)


if __name__ == "__main__":
    unittest.main()
