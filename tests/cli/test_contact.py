"""What runs say of contact: the probe contact_force, fields of trajectories, work, advice."""

import csv
import json
import struct
import unittest

from test_run_command import RunCommand

WEIGHT = 0.2 * 9.81 * 1.0 * 0.5  # of the sheet below [N]
MU = 0.4


def lying(collider, **changes):
    """A sheet of 1 m × 0.5 m on a plane, which may move."""
    return {"surface": {"plugin": "grid", "nodes": [5, 4], "size": [1, 0.5]}, "material": {"density": 0.2},
            "energies": [{"plugin": "koiter", "young": 1e5, "poisson": 0.3, "thickness": 1e-3}],
            "forces": ["gravity"], "colliders": [{"plugin": "plane", "friction": MU, **collider}],
            "integrator": {"plugin": "bdf2", "step": 0.01}, "duration": 0.3,
            "probes": ["contact_force", "energy_balance", "momentum", "lowest"], **changes}


def moving(to):
    """With a velocity `to` [m/s]."""
    return {"times": [0, 10], "displacements": [[0, 0, 0], [10 * x for x in to]]}


class Trajectory:
    """The fields of the last frame of trajectory.bin, by name."""

    MAGIC = b"deform trajectory 1\n"

    def __init__(self, path):
        content = path.read_bytes()
        assert content.startswith(self.MAGIC)
        at = len(self.MAGIC)
        (length,) = struct.unpack_from("<Q", content, at)
        self.header = json.loads(content[at + 8:at + 8 + length])
        nodes, names = self.header["nodes"], [f["name"] for f in self.header["fields"]]
        begin = len(content) - 4 * nodes * len(names) - 8 * self.header.get("scalars", 0)
        self.last = {name: struct.unpack_from(f"<{nodes}f", content, begin + 4 * nodes * i)
                     for i, name in enumerate(names)}


class Contact(RunCommand):
    def figures(self, scene):
        self.run_scene(scene)
        with open(self.out / "probes.csv", newline="") as file:
            return [{key.split(" [")[0]: float(value or "nan") for key, value in row.items()}
                    for row in csv.DictReader(file)]

    def test_a_resting_sheet_is_borne(self):
        rows = self.figures(lying({}))
        self.assertTrue(all(rows[0][c] != rows[0][c] for c in rows[0] if c.startswith("contact_force")),
                        "before the first step nothing is known")
        last = rows[-1]
        self.assertAlmostEqual(last["contact_force.z"], WEIGHT, delta=1e-8 * WEIGHT)
        self.assertAlmostEqual(last["contact_force.normal"], WEIGHT, delta=1e-8 * WEIGHT)
        for name in "contact_force.x", "contact_force.y", "contact_force.friction":
            self.assertAlmostEqual(last[name], 0, delta=1e-8 * WEIGHT)
        self.assertGreaterEqual(last["contact_force.largest_pressure"], 0.2 * 9.81 * (1 - 1e-6))

    def test_fields_are_pressures(self):
        self.figures(lying(moving([1, 0, 0]), duration=0.1))
        fields = Trajectory(self.out / "trajectory.bin").last
        for normal, friction in zip(fields["contact pressure"], fields["friction"]):
            self.assertAlmostEqual(friction, MU * normal, delta=1e-4 * 0.2 * 9.81)
        mean = sum(fields["contact pressure"]) / len(fields["contact pressure"])
        self.assertAlmostEqual(mean, 0.2 * 9.81, delta=0.05 * 0.2 * 9.81)

    def test_a_belt_drags(self):
        """Until the sheet goes along, friction is μ times the weight, and its work what the sheet gains."""
        last = self.figures(lying(moving([2, 0, 0])))[-1]
        self.assertAlmostEqual(last["contact_force.x"], MU * WEIGHT, delta=1e-6 * WEIGHT)
        self.assertAlmostEqual(last["contact_force.friction"], MU * WEIGHT, delta=1e-6 * WEIGHT)
        speed = MU * 9.81 * 0.3
        kinetic = 0.5 * 0.1 * speed**2
        self.assertAlmostEqual(last["energy_balance.friction"], kinetic, delta=1e-6 * kinetic)
        self.assertAlmostEqual(last["energy_balance.contact"], 0, delta=1e-9)

    def test_a_floor_that_rises_works(self):
        """By what it gives of speed and of height."""
        last = self.figures(lying(moving([0, 0, 0.5])))[-1]
        work = 0.5 * 0.1 * 0.5**2 + WEIGHT * 0.5 * 0.3
        self.assertAlmostEqual(last["energy_balance.contact"], work, delta=0.02 * work)
        self.assertAlmostEqual(last["energy_balance.friction"], 0, delta=1e-9)

    def test_nodes_between_bodies_that_close_are_told(self):
        scene = lying({})
        scene["colliders"].append({"plugin": "plane", "point": [0, 0, 0.1], "normal": [0, 0, -1],
                                   **moving([0, 0, -1])})
        result = self.deform("run", self.write(scene), "--out", self.out)
        log = (self.out / "log.txt").read_text()
        self.assertIn("it has nowhere to go between bodies that close on it", log + result.stderr)
        self.assertEqual(log.count("nowhere to go"), 1)

    def test_a_hard_step_says_why_once(self):
        """A thin sheet that is pushed together buckles, and folds between nodes."""
        scene = lying({}, colliders=[], probes=["newton"], duration=0.1)
        scene["surface"] = {"plugin": "grid", "nodes": [15, 15], "size": [1, 1]}
        scene["velocity"] = ["6*(0.5-a1)", "6*(0.5-a2)", "0.1*sin(20*a1)*cos(17*a2)"]
        scene["integrator"] = {"plugin": "backward_euler", "step": 0.05, "tolerance": 1e-9}
        self.deform("run", self.write(scene), "--out", self.out)
        said = [line for line in (self.out / "log.txt").read_text().splitlines() if "was hard" in line]
        self.assertTrue(any("buckling" in line for line in said), said)
        folded = [line for line in said if "folded more sharply" in line]
        self.assertEqual(len(folded), 1, said)
        self.assertIn('"bending": "isometric"', folded[0])
        causes = [line.split("given up): ")[1].split(" (in")[0] for line in said if line not in folded]
        self.assertEqual(len(causes), len(set(causes)), said)


if __name__ == "__main__":
    unittest.main()
