"""Reads back, with other people's readers, what the outputs vtk and obj wrote of one small run.

DEFORM_PROGRAM: the program `deform`. Needs NumPy and VTK's Python package.
"""

import csv
import json
import os
import pathlib
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

NODES = (7, 5)
STEP = 0.02
EVERY = 5
STEPS = 20

SCENE = {
    "title": "Small sheet under a load at its centre",
    "surface": {"plugin": "grid", "nodes": NODES, "size": [1.0, 0.8],
                "differences": "forward", "border": "paper", "weights": "equal"},
    "material": {"density": 0.1, "damping": 1.0},
    "energies": [
        {"plugin": "stretching", "eta": 0.01},
        {"plugin": "bending", "xi": 1e-6, "form": "divergence",
         "normal": {"plugin": "gauss", "delta": 0.5}},
    ],
    "forces": [{"plugin": "point_load", "force": [0.001, 0, -0.01],
                "where": {"centre": [0.5, 0.4], "radius": 0.21}}],
    "constraints": [{"plugin": "pin", "where": {"boundary": "all"}}],
    "integrator": {"plugin": "semi_implicit", "step": STEP},
    "duration": STEPS * STEP,
    "outputs": [{"plugin": "vtk", "every": EVERY}, {"plugin": "obj", "every": EVERY}],
    "probes": [{"plugin": "lowest", "every": EVERY}, {"plugin": "energy", "every": EVERY}],
}


def run(folder, scene):
    """Runs a scene in `folder`; returns the run directory."""
    file = folder / "scene.json"
    file.write_text(json.dumps(scene))
    command = [os.environ["DEFORM_PROGRAM"], "run", str(file), "--out", str(folder / "run"), "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise AssertionError(f"deform run ended with {done.returncode}: {done.stdout}{done.stderr}")
    return folder / "run"


def collection(pvd):
    """[(time, file)] of a .pvd file."""
    return [(float(entry.get("timestep")), pvd.parent / entry.get("file"))
            for entry in ElementTree.parse(pvd).iter("DataSet")]


def read_vtp(path):
    """The vtkPolyData in a file; fails on any complaint of the reader."""
    complaints = []
    reader = vtkXMLPolyDataReader()
    reader.AddObserver("ErrorEvent", lambda *_: complaints.append("error"))
    reader.AddObserver("WarningEvent", lambda *_: complaints.append("warning"))
    reader.SetFileName(str(path))
    reader.Update()
    if complaints:
        raise AssertionError(f"{path}: {complaints}")
    return reader.GetOutput()


def points(data):
    return vtk_to_numpy(data.GetPoints().GetData())


def field(data, name):
    array = data.GetPointData().GetArray(name)
    if array is None:
        raise AssertionError(f"there is no field {name}")
    return vtk_to_numpy(array)


def polygons(data):
    cells = data.GetPolys()
    nodes = vtk_to_numpy(cells.GetConnectivityArray())
    begin = vtk_to_numpy(cells.GetOffsetsArray())
    return [list(nodes[a:b]) for a, b in zip(begin[:-1], begin[1:])]


def read_obj(path):
    """Vertices, normals, and polygons by 0-based numbers."""
    vertices, normals, faces = [], [], []
    for line in path.read_text().splitlines():
        keyword, *words = line.split(" ")
        if keyword == "v":
            vertices.append([float(word) for word in words])
        elif keyword == "vn":
            normals.append([float(word) for word in words])
        elif keyword == "f":
            corners = [word.split("//") for word in words]
            assert all(vertex == normal for vertex, normal in corners)
            faces.append([int(vertex) - 1 for vertex, _ in corners])
        else:
            raise AssertionError(f"{path}: unknown keyword {keyword}")
    return np.array(vertices), np.array(normals), faces


class ReadBack(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.directory = run(pathlib.Path(cls.folder.name), SCENE)
        cls.series = collection(cls.directory / "vtk" / "surface.pvd")
        cls.frames = [read_vtp(file) for _, file in cls.series]
        cls.objs = [read_obj(cls.directory / "obj" / file.with_suffix(".obj").name)
                    for _, file in cls.series]

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_times(self):
        expected = [step * STEP for step in range(0, STEPS + 1, EVERY)]
        np.testing.assert_allclose([time for time, _ in self.series], expected, rtol=1e-12)
        for (time, _), data in zip(self.series, self.frames):
            self.assertEqual(data.GetFieldData().GetArray("TimeValue").GetTuple1(0), time)

    def test_series_lists_every_file_and_nothing_is_left_over(self):
        listed = {file.name for _, file in self.series} | {"surface.pvd"}
        self.assertEqual({file.name for file in (self.directory / "vtk").iterdir()}, listed)
        self.assertEqual(len(list((self.directory / "obj").iterdir())), len(self.series))

    def test_points_are_those_of_the_obj_files(self):
        # Both hold every bit: raw doubles here, shortest round-trip text there.
        for data, (vertices, _, _) in zip(self.frames, self.objs):
            self.assertEqual(data.GetNumberOfPoints(), NODES[0] * NODES[1])
            np.testing.assert_array_equal(points(data), vertices)

    def test_polygons_are_those_of_the_obj_files(self):
        for data, (_, _, faces) in zip(self.frames, self.objs):
            self.assertEqual(data.GetNumberOfPolys(), (NODES[0] - 1) * (NODES[1] - 1))
            self.assertEqual(polygons(data), faces)

    def test_sheet_bends(self):
        self.assertLess(points(self.frames[-1])[:, 2].min(), -0.01)

    def test_displacement(self):
        rest = points(self.frames[0])  # the scene starts at rest
        for data in self.frames:
            np.testing.assert_array_equal(field(data, "displacement"), points(data) - rest)

    def test_velocity_of_pinned_nodes(self):
        data = self.frames[-1]
        velocity = field(data, "velocity")
        moved = np.abs(field(data, "displacement")).max(axis=1) > 0
        self.assertEqual(moved.sum(), (NODES[0] - 2) * (NODES[1] - 2))
        np.testing.assert_array_equal(velocity[~moved], 0)
        self.assertGreater(np.abs(velocity[moved]).max(), 0)

    def test_rest_geometry(self):
        data = self.frames[0]
        G, B, n = (field(data, name) for name in ("G", "B", "n"))
        names = [data.GetPointData().GetArray("G").GetComponentName(c) for c in range(3)]
        self.assertEqual(names, ["11", "12", "22"])
        # Where a difference cannot be formed G is 0, elsewhere that of a flat sheet.
        self.assertTrue(np.all((np.abs(G[:, 0] - 1) < 1e-12) | (G[:, 0] == 0)))
        np.testing.assert_allclose(B, 0, atol=1e-12)
        np.testing.assert_allclose(n, np.tile([0, 0, 1], (len(n), 1)), atol=1e-12)

    def test_obj_normals_are_unit_and_on_the_exact_normals_side(self):
        for data, (_, normals, _) in zip(self.frames, self.objs):
            np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, rtol=1e-14)
            self.assertTrue(np.all((normals * field(data, "n")).sum(axis=1) > 0.5))

    def test_energy_densities_sum_to_the_probes_energies(self):
        rows = self.probes()
        area = (1.0 / (NODES[0] - 1)) * (0.8 / (NODES[1] - 1))
        for data, row in zip(self.frames, rows):
            for term in ("stretching", "bending"):
                energy = float(row[f"energy.{term} [J]"])
                density = field(data, f"energy_{term}")
                np.testing.assert_allclose(density.sum() * area, energy, rtol=1e-12, atol=1e-24)

    def test_lowest_is_the_probes(self):
        for data, row in zip(self.frames, self.probes()):
            self.assertEqual(points(data)[:, 2].min(), float(row["lowest [m]"]))

    def probes(self):
        with open(self.directory / "probes.csv", newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        return [row for row in rows if row["lowest [m]"]]


class EstimatedNormals(unittest.TestCase):
    def test_gauss_is_exact_with_coefficients_of_the_same_state(self):
        # The first frame has no previous state, so that r_ij less its tangential part is B_ij n to
        # rounding.
        scene = json.loads(json.dumps(SCENE))
        scene["surface"].update(differences="central", border="one_sided",
                                initial={"plugin": "sphere_patch", "radius": 0.9})
        scene.update(outputs=[{"plugin": "vtk"}], probes=[], duration=STEP)
        with tempfile.TemporaryDirectory() as folder:
            directory = run(pathlib.Path(folder), scene)
            data = read_vtp(collection(directory / "vtk" / "surface.pvd")[0][1])
        for c, pair in enumerate(("11", "12", "22")):
            curved = np.abs(field(data, "B")[:, c]) > 0.5  # delta of the scene
            self.assertEqual(curved.sum() > NODES[0] * NODES[1] / 2, pair != "12")
            np.testing.assert_allclose(field(data, f"n_{pair}_bending")[curved],
                                       field(data, "n")[curved], atol=1e-12)


class SamplesOfTheirOwn(unittest.TestCase):
    """Symmetric differences: bending at the nodes, stretching at the corners of the cells."""

    def test_membrane_is_a_cloud(self):
        scene = json.loads(json.dumps(SCENE))
        scene["surface"].update(differences="symmetric", border="one_sided", weights="area")
        with tempfile.TemporaryDirectory() as folder:
            directory = run(pathlib.Path(folder), scene)
            surface = read_vtp(collection(directory / "vtk" / "surface.pvd")[-1][1])
            series = collection(directory / "vtk" / "membrane_samples.pvd")
            data = read_vtp(series[-1][1])
            with open(directory / "probes.csv", newline="", encoding="utf-8") as file:
                energy = float(list(csv.DictReader(file))[-1]["energy.stretching [J]"])
        self.assertEqual(len(series), STEPS // EVERY + 1)
        cells = (NODES[0] - 1) * (NODES[1] - 1)
        self.assertEqual(data.GetNumberOfPoints(), 4 * cells)
        places = {tuple(place) for place in points(surface)}
        self.assertEqual({tuple(place) for place in points(data)}, places)
        weight = 1.0 * 0.8 / cells / 4
        np.testing.assert_allclose(field(data, "energy_stretching").sum() * weight, energy, rtol=1e-12)
        # Of B what exists there alone.
        self.assertEqual(field(data, "B").size, data.GetNumberOfPoints())
        self.assertEqual(data.GetPointData().GetArray("B").GetComponentName(0), "12")
        self.assertEqual(field(data, "G").shape, (4 * cells, 3))
        self.assertIsNone(data.GetPointData().GetArray("energy_bending"))
        self.assertEqual(field(surface, "B").shape, (NODES[0] * NODES[1], 3))
        self.assertEqual(field(surface, "energy_bending").shape, (NODES[0] * NODES[1],))


class SinglePrecision(unittest.TestCase):
    def test_rounds_to_float(self):
        scene = dict(SCENE, outputs=[{"plugin": "vtk", "every": STEPS, "precision": "single"},
                                     {"plugin": "obj", "every": STEPS}])
        with tempfile.TemporaryDirectory() as folder:
            directory = run(pathlib.Path(folder), scene)
            _, file = collection(directory / "vtk" / "surface.pvd")[-1]
            data = read_vtp(file)
            vertices, _, _ = read_obj(directory / "obj" / file.with_suffix(".obj").name)
        self.assertEqual(points(data).dtype, np.float32)
        np.testing.assert_array_equal(points(data), vertices.astype(np.float32))


if __name__ == "__main__":
    unittest.main()
