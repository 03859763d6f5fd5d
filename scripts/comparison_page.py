"""What the pages that are made from comparisons share: options, runs, figures in text."""

import argparse
import json
import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ENVIRONMENT = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}


def options_of(tool, description, runs):
    """The options of a tool that keeps its runs in the folder runs/`runs`."""
    parser = argparse.ArgumentParser(prog=f"scripts/{tool}", description=description, epilog=(
        "Exit codes: 0 all claims hold; 1 something failed; 2 wrong usage; 5 a claim fails."))
    parser.add_argument("--program", type=Path, default=ROOT / "build/release/bin/deform",
                        help="the built program (default: build/release/bin/deform)")
    parser.add_argument("--out", type=Path, default=ROOT / "runs" / runs,
                        help=f"folder of the runs (default: runs/{runs})")
    parser.add_argument("--reuse", action="store_true",
                        help="take over runs that are complete and unchanged")
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time (default: 1)")
    return parser


def parsed(parser):
    """The options given; ends with 2 without a program, else makes the folder of the runs."""
    options = parser.parse_args()
    if not options.program.exists():
        print(f"{parser.prog}: there is no {options.program}; scripts/build makes it",
              file=sys.stderr)
        sys.exit(2)
    options.out.mkdir(parents=True, exist_ok=True)
    return options


def cell(words):
    """Of a table in Markdown."""
    return words.replace("|", "\\|")


def table_row(cells):
    return f"| {' | '.join(map(cell, cells))} |"


def table(head, rows):
    return "\n".join([table_row(head), "|" + "---|" * len(head),
                      *(table_row([str(cell) for cell in row]) for row in rows)])


def make_page(text, tables, page, parts):
    """Writes the file `page` from the file `text`; each [[part]] becomes tables/part.md."""
    text = text.read_text()
    for name in parts:
        file = tables / f"{name}.md"
        made = file.read_text().rstrip() if file.exists() else "*Not measured yet.*"
        text = text.replace(f"[[{name}]]", made)
    page.write_text(text)


class Comparison:
    """The runs of one scene: their figures, and the claims that fail."""

    def __init__(self, scene, options):
        """`scene` is the file of a scene with claims beside it."""
        name = scene.stem
        self.folder = options.out / name
        again = "--resume" if options.reuse and self.folder.exists() else "--force"
        print(f"comparing: {name}", flush=True)
        done = subprocess.run(
            [options.program, "compare", scene, "--expect", scene.with_suffix(".expect.json"),
             "--out", self.folder, "--jobs", str(options.jobs), "--quiet", again],
            stderr=subprocess.PIPE, text=True, env=ENVIRONMENT, check=False)
        if done.returncode not in (0, 5):
            sys.exit(f"{name}: {done.stderr.strip()}")
        self.failing = re.findall(r"does not hold: (.*)", done.stderr)
        self.runs = {run["name"]: run for run in
                     json.loads((self.folder / "summary.json").read_text())["variants"]}

    def figure(self, name):
        """`name` is RUN.FIGURE; runs' names may have dots in them."""
        for run in sorted(self.runs, key=len, reverse=True):
            if name.startswith(run + "."):
                value = self.runs[run]["figures"].get(name[len(run) + 1:], {}).get("value")
                if value is not None:
                    return value
        sys.exit(f"there is no figure {name} in {self.folder}")

    def fill(self, text):
        return re.sub(r"\{([^{}:]+)(?::([^{}]*))?\}",
                      lambda m: format(self.figure(m[1]) + 0.0, m[2] or ".4g"), text)


def exit_code(comparisons):
    """Names the claims that fail; 5 when there are any."""
    failing = [claim for runs in comparisons for claim in runs.failing]
    for claim in failing:
        print(f"does not hold: {claim}", file=sys.stderr)
    return 5 if failing else 0
