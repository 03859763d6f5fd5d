#!/usr/bin/python3
"""Makes sample/comparison.json and sample/run.json from real runs, to develop the page with.

Simulates some variants of sheet P and writes what docs/report-format.md describes. Needs a built
program and python3-vtk9.

Usage: scripts/make_sample.py [--program build/release/bin/deform] [--out sample]
"""

import argparse
import base64
import csv
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

ROOT = pathlib.Path(__file__).resolve().parents[3]
SCENE = ROOT / "scenes/benchmarks/sheet_p.json"
REFERENCE = "exact_1e-6"
VARIANTS = [REFERENCE, "terzopoulos_1e-6", "gauss_divergence_1e-6", "gauss_expanded_1e-6",
            "variational_1e-6", "terzopoulos_1e-5"]
PROBES = ["energy", "lowest", "in_plane_displacement", "mirror_asymmetry", "normal_error",
          "flatness"]
TOLERANCE = 0.01  # m
LEVELS = 65534  # level 65535: no value


def text(array, dtype):
    return base64.b64encode(np.ascontiguousarray(array, dtype).tobytes()).decode()


def levels(values, low, high):
    """Quantised as docs/report-format.md says; NaN becomes 65535."""
    span = np.where(np.asarray(high) > low, np.subtract(high, low), 1.0)
    scaled = np.rint((values - low) / span * LEVELS)
    return text(np.where(np.isnan(values), LEVELS + 1, scaled), "<u2")


def read_frame(path):
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput()
    point = data.GetPointData()
    names = [point.GetArrayName(i) for i in range(point.GetNumberOfArrays())]
    arrays = {n: vtk_to_numpy(point.GetArray(n)) for n in names}
    faces = vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 4)
    return vtk_to_numpy(data.GetPoints().GetData()), arrays, faces


def unit(v):
    with np.errstate(invalid="ignore", divide="ignore"):
        return v / np.linalg.norm(v, axis=-1, keepdims=True)


def normal_angle(arrays):
    """Between the exact normal and the estimated one of the pair 11, sign left out; NaN without."""
    if "n_11_bending" not in arrays:
        return None
    cosine = np.abs((unit(arrays["n"]) * unit(arrays["n_11_bending"])).sum(-1))
    return np.arccos(np.clip(cosine, 0, 1))


def field(name, unit_, scale, frames):
    values = np.stack(frames).astype(float)
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    return {"name": name, "unit": unit_, "scale": scale, "min": low, "max": high,
            "data": levels(values, low, high)}


def fields_of(frames):
    arrays = [f[1] for f in frames]
    made = [field(f"B_{ij}", "1/m", "diverging", [a["B"][:, c] for a in arrays])
            for c, ij in enumerate(("11", "12", "22"))]
    for term in ("stretching", "bending"):
        key = f"energy_{term}"
        if key in arrays[0]:
            made.append(field(f"energy density, {term}", "J/m²", "sequential",
                              [a[key] for a in arrays]))
    angles = [normal_angle(a) for a in arrays]
    if angles[0] is not None and not np.isnan(angles).all():
        made.append(field("normal angle", "rad", "sequential", angles))
    return made


def probes_of(run):
    with open(run / "probes.csv", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    columns = []
    for head in rows[0]:
        name, unit_ = re.fullmatch(r"(.*?)(?: \[(.*)\])?", head).groups()
        columns.append({"name": name, "unit": unit_ or ""})
    values = [[float(x) if x else None for x in row] for row in rows[1:]]
    return {"columns": columns, "rows": values}


def parts_of(positions, reference, parameters, times):
    """The first recorded frame at which a node is further from the reference than TOLERANCE."""
    for i in range(min(len(positions), len(reference))):
        distance = np.linalg.norm(positions[i] - reference[i], axis=1)
        node = int(distance.argmax())
        if distance[node] > TOLERANCE:
            return {"step": i, "time": times[i], "where": parameters[node].tolist(), "node": node}
    return None


def simulate(program, name, out):
    command = [program, "run", str(SCENE), "--variant", name, "--out", str(out), "--quiet",
               "--set", '/outputs=[{"plugin":"vtk","every":1}]',
               "--set", "/probes=" + json.dumps(PROBES)]
    code = subprocess.run(command, stdout=subprocess.DEVNULL, check=False).returncode
    if code not in (0, 3):
        sys.exit(f"{' '.join(command)} ended with {code}")


def variant_of(name, run, frames, scene):
    positions = np.stack([f[0] for f in frames])
    low, high = positions.min((0, 1)), positions.max((0, 1))
    manifest = json.loads((run / "manifest.json").read_text())
    changes = scene["variants"][name]
    steps = max(manifest["steps"], 1)
    return {"name": name, "status": manifest["status"], "reason": manifest["reason"],
            "frames": len(frames),
            "positions": {"min": low.tolist(), "max": high.tolist(),
                          "data": levels(positions, low, high)},
            "fields": fields_of(frames), "probes": probes_of(run),
            "changes": [{"pointer": p, "value": v} for p, v in changes.items()],
            "cost": {"ms_per_step": manifest["seconds"]["all_steps"] / steps * 1e3},
            "parts": None, "manifest": manifest}


def sentences_of(variants, largest):
    off = [v for v in variants if v["parts"]]
    near = [v for v in variants if v["name"] in largest and v not in off and
            v["name"] != REFERENCE and v["status"] == "done"]
    said = [f"{v['name']} folds the paper: {largest[v['name']] * 1e3:.0f} mm from {REFERENCE} "
            f"at the end, off since {v['parts']['time']:g} s."
            for v in off if v["status"] == "done"]
    if near:
        names = ", ".join(v["name"] for v in near)
        far = max(largest[v["name"]] for v in near)
        said.append(f"{names} stay within {far * 1e3:.1f} mm of it.")
    said += [f"{v['name']} diverged at step {v['manifest']['steps'] + 1}."
             for v in variants if v["status"] == "diverged"]
    return said


def without_comments(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    return json.loads("\n".join(x for x in lines if not x.lstrip().startswith("//")))


def comparison(program, work):
    scene = without_comments(SCENE)
    runs = {}
    for name in VARIANTS:
        simulate(program, name, work / name)
        runs[name] = [read_frame(p) for p in sorted((work / name / "vtk").glob("*.vtp"))]
    start, _, faces = runs[REFERENCE][0]
    count = max(len(r) for r in runs.values())
    step = scene["integrator"]["step"]
    times = [round(i * step, 10) for i in range(count)]
    variants = [variant_of(name, work / name, runs[name], scene) for name in VARIANTS]
    reference = [f[0] for f in runs[REFERENCE]]
    largest = {}
    for variant in variants:
        positions = [f[0] for f in runs[variant["name"]]]
        if variant["name"] != REFERENCE:
            variant["parts"] = parts_of(positions, reference, start[:, :2], times)
        if len(positions) == len(reference):
            difference = np.linalg.norm(positions[-1] - reference[-1], axis=1)
            largest[variant["name"]] = float(difference.max())
    rows = []
    for v in variants:
        probes = v["probes"]
        last = dict(zip([c["name"] for c in probes["columns"]], probes["rows"][-1]))
        rows.append({"variant": v["name"], "values": [
            largest.get(v["name"]) if v["name"] != REFERENCE else None, last.get("lowest"),
            last.get("mirror_asymmetry"), last.get("normal_error.bending.mean")]})
    resolved = json.loads((work / REFERENCE / "scene.json").read_text())
    return {
        "format": 1, "kind": "comparison", "title": scene["title"],
        "created": variants[0]["manifest"]["started"][:10], "program": "deform 0.1.0",
        "mesh": {"nodes": len(start), "quads": text(faces, "<u4"),
                 "parameters": text(start[:, :2], "<f4")},
        "frames": {"steps": list(range(count)), "times": times},
        "reference": REFERENCE, "tolerance": {"value": TOLERANCE, "unit": "m"},
        "variants": variants,
        "verdict": {"columns": [
            {"name": "largest distance", "unit": "m", "better": "lower"},
            {"name": "lowest", "unit": "m", "better": None},
            {"name": "mirror asymmetry", "unit": "m", "better": "lower"},
            {"name": "normal error, mean", "unit": "rad", "better": "lower"}],
            "rows": rows, "sentences": sentences_of(variants, largest)},
        "scene": resolved,
        "notes": ["positions are rounded to 16 bits: 1.5e-5 of the extent"]}


def single_run(report, name):
    """The same as the report of one run."""
    variant = next(v for v in report["variants"] if v["name"] == name)
    return report | {"kind": "run", "reference": None, "verdict": None, "tolerance": None,
                     "variants": [variant | {"parts": None, "changes": []}]}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/deform"))
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "apps/report/sample")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as work:
        report = comparison(options.program, pathlib.Path(work))
    options.out.mkdir(parents=True, exist_ok=True)
    for name, content in (("comparison", report), ("run", single_run(report, VARIANTS[1]))):
        path = options.out / f"{name}.json"
        path.write_text(json.dumps(content), encoding="utf-8")
        print(f"{path}: {path.stat().st_size / 1e6:.1f} MB")


main()
