"""The paper's open questions: the claims beside each scene hold, and fail with a rival's estimator
or form in place of the one that they speak of."""

import json
import os
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

PROGRAM = os.environ["DEFORM_PROGRAM"]
QUESTIONS = Path(os.environ["DEFORM_SCENES"]) / "questions"
TIMEOUT = 240  # seconds

# Of each scene: a variant, and the one whose values are put in its place.
RIVALS = {
    "pressed_sheet": [("gauss_0_twist_central", "terzopoulos_twist_central"),
                      ("terzopoulos_twist_central", "exact_twist_central"),
                      ("gauss_0", "terzopoulos")],
    "twisted_card": [("gauss_0", "gauss_0.5"), ("gauss_0.5", "gauss_0"),
                     ("variational", "exact_expanded"), ("terzopoulos", "variational"),
                     ("exact_expanded", "variational"), ("gauss_0.5_gap", "gauss_0_gap")],
    "lifted_sheet": [("gauss_0_twist", "exact_expanded_twist"),
                     ("exact_expanded_twist", "variational_twist"),
                     ("gauss_infinity_expanded_twist", "gauss_0.5_expanded_twist")],
    "delta": [("expanded_0", "divergence_0"), ("divergence_0", "expanded_0"),
              ("divergence_infinity", "divergence_0"),
              ("divergence_0.5_decimetres", "divergence_0_decimetres")],
}


def content(file):
    """Of a JSON file with comments."""
    return json.loads(re.sub(r"^\s*//.*$", "", file.read_text(), flags=re.MULTILINE))


def speaks_of(claim, run):
    return re.search(rf"(?<![\w.]){re.escape(run)}\.[a-z]", claim)


class Questions(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="deform_questions_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def compare(self, scene, claims, *arguments):
        return subprocess.run(
            [PROGRAM, "compare", scene, "--expect", claims, "--out", self.folder / "c", "--force",
             "--quiet", "--jobs", "2", *arguments],
            capture_output=True, text=True, timeout=TIMEOUT,
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1"})

    def test_every_file_of_claims_has_rivals(self):
        found = {file.name.removesuffix(".expect.json") for file in QUESTIONS.glob("*.expect.json")}
        self.assertEqual(found, set(RIVALS))

    def test_claims_hold(self):
        for name in RIVALS:
            with self.subTest(name):
                done = self.compare(QUESTIONS / f"{name}.json", QUESTIONS / f"{name}.expect.json")
                self.assertEqual(done.returncode, 0, done.stderr)

    def test_claims_fail_with_the_rival(self):
        """One variant with another's energy, and of the claims those that speak of it."""
        for name, pairs in RIVALS.items():
            scene = content(QUESTIONS / f"{name}.json")
            claims = content(QUESTIONS / f"{name}.expect.json")["claims"]
            for run, rival in pairs:
                with self.subTest(name, run=run, rival=rival):
                    mine = [claim for claim in claims if speaks_of(claim, run)]
                    self.assertTrue(mine)
                    changed = {**scene, "variants": {**scene["variants"]}}
                    changed["variants"][run] = {**scene["variants"][run],
                                                **scene["variants"][rival]}
                    needed = [v for v in scene["variants"]
                              if v in (run, "variational") or any(speaks_of(c, v) for c in mine)]
                    (self.folder / "rival.json").write_text(json.dumps(changed))
                    (self.folder / "claims.json").write_text(json.dumps({"claims": mine}))
                    done = self.compare(self.folder / "rival.json", self.folder / "claims.json",
                                        "--variants", ",".join(needed))
                    self.assertEqual(done.returncode, 5, done.stderr)
                    self.assertIn("does not hold", done.stderr)


if __name__ == "__main__":
    unittest.main()
