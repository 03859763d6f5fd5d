"""Meshes as their user sees them: `deform mesh`, runs with all that a run writes, comparisons, wild files."""

import csv
import json
import math
import os
import random
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

PROGRAM = os.environ["DEFORM_PROGRAM"]
SOURCE = Path(os.environ["DEFORM_SOURCE"])
MESHES = SOURCE / "scenes" / "meshes"
TIMEOUT = 120  # seconds
BAD_INPUT = 2
TRIALS = int(os.environ.get("DEFORM_MESH_TRIALS", "60"))

# A piece of the plane, six by six vertices.
SHEET = "".join(f"v {i / 5} {j / 5} 0\n" for j in range(6) for i in range(6))
SHEET += "".join(f"f {a} {a + 1} {a + 7} {a + 6}\n" for j in range(5) for a in range(6 * j + 1, 6 * j + 6))

# Files of the kind that scans, CAD programs and games make: text, what is said, whether --repair mends it.
WILD = {
    "negative.obj": (SHEET + "f -1 -2 -8\n", "upon others|more than two", None),
    "crlf.obj": (SHEET.replace("\n", "\r\n"), "", True),
    "comments.obj": ("# a\no sheet\ng left\nusemtl red\ns off\n" + SHEET, "", True),
    "normals.obj": (SHEET.replace("f ", "vn 0 0 1\nf "), "", True),
    "polygons.obj": (SHEET.replace("f 1 2 8 7\nf 2 3 9 8\n", "f 1 2 3 9 8 7\n"), "", True),
    "millimetres.obj": ("".join(f"v {100 * (k % 6)} {100 * (k // 6)} 0\n" for k in range(36))
                        + SHEET[SHEET.index("f"):], "", True),
    "far.obj": ("".join(f"v {4e6 + k % 6} {5e6 + k // 6} 0\n" for k in range(36))
                + SHEET[SHEET.index("f"):], "", True),
    "hole.obj": (SHEET.replace("f 15 16 22 21\n", ""), "", True),
    "flipped.obj": (SHEET.replace("f 1 2 8 7", "f 7 8 2 1"), "the other way round", True),
    "doubled.obj": (SHEET + "v 0 0 0\n", "vertices", True),
    "unused.obj": (SHEET + "v 9 9 9\n", "vertices that no polygon has: 36", True),
    "flat.obj": (SHEET + "f 1 2 3\n", "without area", True),
    "line.obj": (SHEET + "f 1 2 2\n", "twice", True),
    "missing.obj": (SHEET + "f 1 2 99\n", "not there|vertex", False),
    "empty.obj": ("", "", False),
    "text.obj": ("hello\n", "no polygons", False),
    "points.obj": (SHEET[:SHEET.index("f")], "no polygons", False),
    "truncated.off": ("OFF\n4 2 0\n0 0 0\n1 0 0\n", "", False),
    "no.off": ("nonsense", "", False),
    "truncated.ply": ("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n", "", False),
    "no.stl": ("solid x\nfacet", "", False),
    "no.glb": ("glTF\x02", "", False),
    "no.gltf": ("{}", "", False),
    "huge.obj": (SHEET.replace("v 0.2 0.2 0\n", "v 1e300 0.2 0\n"), "", None),
}


class Mesh(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="deform_mesh_")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def deform(self, *arguments, code=0):
        result = subprocess.run([PROGRAM, *map(str, arguments)], text=True, capture_output=True,
                                timeout=TIMEOUT)
        if code is not None:
            self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        return result

    def test_tells_what_it_sees(self):
        found = self.deform("mesh", MESHES / "torus.obj", MESHES / "disc.obj").stdout
        self.assertIn("960 vertices, 2880 edges, 1920 triangles (Euler characteristic 0), closed, as a torus",
                      found)
        self.assertIn("border_1: 108 vertices", found)
        self.assertIn("in a plane", found)
        area = float(found.split("area")[1].split()[0])
        self.assertAlmostEqual(area / (4 * math.pi**2 * 0.3 * 0.1), 1, delta=0.02)

    def test_wild_files_are_read_or_mended_or_refused_with_a_reason(self):
        for name, (text, says, mends) in WILD.items():
            with self.subTest(file=name):
                file = self.folder / name
                file.write_text(text, encoding="latin-1", newline="")
                result = self.deform("mesh", file, code=None)
                if not says and mends:
                    self.assertEqual(result.returncode, 0, result.stderr)
                else:
                    self.assertEqual(result.returncode, BAD_INPUT, result.stdout + result.stderr)
                    self.assertTrue(any(part in result.stderr for part in says.split("|")), result.stderr)
                    self.assertIn(name, result.stderr)
                if mends is not None:
                    self.deform("mesh", "--repair", file, code=0 if mends else BAD_INPUT)

    def test_damaged_files_crash_nothing(self):
        chance = random.Random(11)
        sources = {".obj": SHEET, ".off": "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n"}
        for trial in range(TRIALS):
            ending, text = chance.choice(list(sources.items()))
            data = bytearray(text.encode())
            for _ in range(chance.randint(1, 12)):
                data[chance.randrange(len(data))] = chance.randrange(256)
            file = self.folder / f"trial{ending}"
            file.write_bytes(bytes(data))
            with self.subTest(trial=trial):
                result = self.deform("mesh", "--repair", file, code=None)
                self.assertIn(result.returncode, (0, BAD_INPUT), result.stderr)

    def test_runs_write_all_that_runs_write(self):
        out = self.folder / "run"
        self.deform("run", MESHES / "tube.json", "--out", out, "--quiet", "--set", "/duration=0.05",
                    "--set", '/outputs=["vtk", "obj"]')
        with open(out / "probes.csv", newline="", encoding="utf-8") as table:
            rows = list(csv.DictReader(table))
        self.assertEqual(len(rows), 11)
        for name in ("trajectory.bin", "report.html", "summary.json", "vtk", "obj"):
            self.assertTrue((out / name).exists(), name)
        again = self.folder / "again"  # the scene as the run kept it
        self.deform("run", MESHES / "tube.json", "--out", again, "--quiet", "--threads", "2", "--set",
                    "/duration=0.05", "--set", '/outputs=["vtk", "obj"]')
        self.assertEqual((out / "trajectory.bin").read_bytes(), (again / "trajectory.bin").read_bytes())

    def test_runs_resume_with_the_same_bits(self):
        arguments = ["run", MESHES / "tube.json", "--quiet", "--set", "/duration=0.05", "--set",
                     '/checkpoint={"every": 4}', "--set", "/outputs=[]"]
        whole, part = self.folder / "whole", self.folder / "part"
        self.deform(*arguments, "--out", whole)
        self.deform(*arguments, "--out", part)
        self.deform("run", MESHES / "tube.json", "--quiet", "--set", "/duration=0.05", "--set",
                    '/checkpoint={"every": 4}', "--set", "/outputs=[]", "--out", part, "--resume", code=None)
        self.assertEqual((whole / "trajectory.bin").read_bytes(), (part / "trajectory.bin").read_bytes())

    def test_cloth_hangs_over_the_table(self):
        out = self.folder / "drape"
        self.deform("run", MESHES / "drape.json", "--out", out, "--quiet", "--set", "/duration=0.2")
        with open(out / "probes.csv", newline="", encoding="utf-8") as table:
            rows = list(csv.DictReader(table))
        self.assertLess(float(rows[-1]["lowest [m]"]), -0.02)
        self.assertLess(float(rows[-1]["contact.node_depth [m]"]), 1e-9)

    def test_surfaces_without_parameters_are_compared_node_by_node(self):
        scene = json.loads("".join(line for line in (MESHES / "tube.json").read_text().splitlines(True)
                                   if not line.startswith("//")))
        scene["surface"]["path"] = str(MESHES / "torus.obj")
        scene["duration"] = 0.02
        scene["variants"] = {"soft": {"/energies/0/young": 5e5}}
        file = self.folder / "scene.json"
        file.write_text(json.dumps(scene))
        out = self.folder / "compared"
        self.deform("compare", file, "--out", out, "--quiet")
        with open(out / "comparison.csv", newline="", encoding="utf-8") as table:
            self.assertGreater(len(list(csv.reader(table))), 1)

    def test_the_meshes_are_what_their_script_makes(self):
        subprocess.run([sys.executable, SOURCE / "scripts" / "meshes", "--out", self.folder], check=True,
                       timeout=TIMEOUT)
        for name in ("disc.obj", "torus.obj"):
            self.assertEqual((self.folder / name).read_text(), (MESHES / name).read_text(), name)


if __name__ == "__main__":
    unittest.main()
