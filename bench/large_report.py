#!/usr/bin/env python3
"""How large a report gets and how long its parts take, for surfaces of any size.

Writes a comparison directory of made-up waves (a trajectory takes too long to simulate at this
size), has `deform report` make the page, and opens it in Chromium where node, the packages of
apps/report and Chromium are there. Needs python3-numpy.

Usage: bench/large_report.py [--nodes 257] [--variants 3] [--frames 100] [--program deform]
                             [--out FOLDER]
"""

import argparse
import json
import pathlib
import resource
import shutil
import struct
import subprocess
import sys
import tempfile
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[1]
NUMBERS = (("B_11", "1/m", "diverging"), ("B_12", "1/m", "diverging"), ("B_22", "1/m", "diverging"),
           ("energy density, stretching", "J/m²", "sequential"),
           ("energy density, bending", "J/m²", "sequential"), ("normal angle", "rad", "sequential"))
FIELDS = [{"name": name, "unit": unit, "scale": scale, "labels": []}
          for name, unit, scale in NUMBERS]
FIELDS.append({"name": "branch", "unit": "", "scale": "categorical",
               "labels": ["flat", "positive", "negative"]})


def mesh(side):
    a = np.linspace(0, 1, side)
    a1, a2 = np.meshgrid(a, a)  # a1 runs fastest
    first = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    quads = np.stack([first, first + 1, first + side + 1, first + side], axis=1)
    return a1.ravel(), a2.ravel(), quads


def trajectory(path, side, frames, amplitude, rng):
    """As framework/include/deform/record/trajectory.h describes it."""
    a1, a2, quads = mesh(side)
    header = json.dumps({"nodes": side * side, "faces": len(quads), "corners": quads.size,
                         "size": 1.0, "fields": FIELDS}).encode()
    bump = np.sin(np.pi * a1) * np.sin(np.pi * a2)
    with open(path, "wb") as file:
        file.write(b"deform trajectory 1\n" + struct.pack("<Q", len(header)) + header)
        for values in (a1, a2, np.full(side * side, 1 / side**2)):
            file.write(values.astype("<f8").tobytes())
        file.write((4 * np.arange(len(quads) + 1)).astype("<i4").tobytes())
        file.write(quads.astype("<i4").tobytes())
        for frame in range(frames):
            time_ = frame / max(frames - 1, 1)
            z = -amplitude * time_ * bump**4 * (1 + 0.1 * np.sin(40 * a1 + frame))
            file.write(struct.pack("<qd", frame, time_))
            for values in (a1, a2, z):
                file.write(values.astype("<f8").tobytes())
            noise = rng.standard_normal(side * side).astype("<f4")
            for field in FIELDS:
                is_branch = field["scale"] == "categorical"
                file.write((np.abs(noise).clip(0, 2).round() if is_branch else noise).astype("<f4")
                           .tobytes())


def comparison(folder, side, variants, frames):
    rng = np.random.default_rng(1)
    entries = []
    for i in range(variants):
        name = f"variant_{i}"
        run = folder / name
        run.mkdir(parents=True)
        trajectory(run / "trajectory.bin", side, frames, 0.1 * (i + 1), rng)
        manifest = {"program": "deform", "status": "done", "reason": "", "title": "waves",
                    "steps_timed": frames, "peak_memory_MB": 100, "seconds": {"all_steps": 1.0}}
        (run / "manifest.json").write_text(json.dumps(manifest))
        (run / "summary.json").write_text(json.dumps({"probes": {"lowest": {"unit": "m"}}}))
        rows = [f"{k},{k / max(frames - 1, 1)},{-0.1 * (i + 1) * k}" for k in range(frames)]
        (run / "probes.csv").write_text("\n".join(["step,time [s],lowest [m]"] + rows) + "\n")
        entries.append({"name": name, "folder": name, "status": "done", "reason": "",
                        "changes": [], "dropped": [], "parts": None})
    (folder / "summary.json").write_text(json.dumps({
        "kind": "comparison", "title": f"{variants} waves of {side} × {side} nodes",
        "created": "", "reference": "variant_0", "tolerance": {"value": 0.01, "unit": "m"},
        "verdict": None, "scene": {}, "variants": entries}))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, default=257, help="along a side")
    parser.add_argument("--variants", type=int, default=3)
    parser.add_argument("--frames", type=int, default=100)
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/deform"))
    parser.add_argument("--out", type=pathlib.Path, help="folder (default: a temporary one)")
    options = parser.parse_args()
    folder = options.out or pathlib.Path(tempfile.mkdtemp(prefix="deform-large-"))
    try:
        comparison(folder, options.nodes, options.variants, options.frames)
        begin = time.perf_counter()
        code = subprocess.run([options.program, "report", str(folder)], check=False).returncode
        if code != 0:
            sys.exit(code)
        print(f"made in {time.perf_counter() - begin:.2f} s, "
              f"{resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024:.0f} MB of memory")
        page = folder / "report.html"
        print(f"size {page.stat().st_size / 1e6:.1f} MB")
        if shutil.which("node"):
            subprocess.run(["node", str(ROOT / "apps/report/scripts/first_picture.mjs"), str(page)],
                           check=False)
    finally:
        if options.out is None:
            shutil.rmtree(folder)


main()
