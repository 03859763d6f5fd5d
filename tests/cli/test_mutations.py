"""Scenes changed at random end, whatever they are: done, refused, diverged or a plugin's failure.

The seed is fixed; a failure prints how to see it again. DEFORM_MUTATIONS says how many scenes (120),
DEFORM_MUTATION_SEED where to begin, DEFORM_MUTATION_SECONDS after which time no other is begun (40),
DEFORM_MUTATION_SHOWS an exit code whose scenes are to be shown.
"""

import concurrent.futures
import json
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "mutations"))
import mutants  # noqa: E402

PROGRAM = os.environ["DEFORM_PROGRAM"]
SCENES = Path(os.environ["DEFORM_SCENES"])
SCHEMAS = Path(os.environ["DEFORM_SOURCE"]) / "schemas" / "plugins"
COUNT = int(os.environ.get("DEFORM_MUTATIONS", "120"))
SEED = int(os.environ.get("DEFORM_MUTATION_SEED", "1987"))
SECONDS = float(os.environ.get("DEFORM_MUTATION_SECONDS", "40"))
SHOWN = os.environ.get("DEFORM_MUTATION_SHOWS", "")
FEWEST = 20  # are tried in any case
PATIENCE = 15  # seconds; a run that takes longer is asked to end, and has to
MOST_MEMORY = 4 << 30  # bytes of address space

DONE, REFUSED, INTERRUPTED = 0, 2, 130
CRASH = r"it (crashed|called)"  # no scene may do that to the plugins that are ours
ENDS = {DONE, REFUSED, 3, 4, 5, INTERRUPTED}


def limit_memory():
    # The shadow memory of the sanitizers is terabytes large.
    if not any(os.environ.get(name) for name in ("ASAN_OPTIONS", "TSAN_OPTIONS")):
        resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))


def deform(folder, *arguments):
    """The exit code and what was said on stderr; the code of a signal is negative."""
    process = subprocess.Popen(
        [PROGRAM, *arguments], cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE, preexec_fn=limit_memory)
    try:
        _, said = process.communicate(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGTERM)
        try:
            _, said = process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            return None, ""
    return process.returncode, said.decode(errors="backslashreplace")


def objection(folder, code, said):
    """What is wrong with how a run of the folder's scene ended; None where nothing is."""
    if code is None:
        return f"goes on after {PATIENCE} s, and {PATIENCE} s after SIGTERM"
    if code not in ENDS:
        return f"ends with {code}"
    if re.search(CRASH, said):
        return f"a plugin ends the process: {said[:300]}"
    written = sorted(path.name for path in folder.iterdir())
    if code != REFUSED:  # what fails before its first step may have written nothing
        return None if set(written) <= {"out", "scene.json"} else f"wrote {written}"
    if written != ["scene.json"]:
        return f"is refused, but wrote {written}"
    problems = [line for line in said.splitlines()
                if line.startswith("deform: ") and not line.startswith("deform: warning: ")]
    if not problems:
        return "is refused without a word"
    for line in problems:
        placed = re.match(r"deform: scene\.json(:\d+:\d+)?: .{8}", line)
        if not placed:
            return f"is refused without a place and a rule: {line[:300]}"
    return None


class Mutations(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scenes = {
            str(file.relative_to(SCENES)): json.loads(mutants.without_comments(file.read_text()))
            for file in sorted(SCENES.rglob("*.json")) if not file.name.endswith(".expect.json")}
        cls.schemas = {}
        for file in sorted(SCHEMAS.glob("*.schema.json")):
            kind, name = file.name.removesuffix(".schema.json").split("-", 1)
            cls.schemas[kind, name] = json.loads(file.read_text())

    def try_one(self, number):
        """None where nobody looked for want of time; else the exit code and what is wrong."""
        if number >= FEWEST and time.monotonic() > self.deadline:
            return None
        text, done = mutants.Mutator(self.scenes, self.schemas, f"{SEED + number}").mutant()
        with tempfile.TemporaryDirectory(prefix="deform_mutant_") as place:
            folder = Path(place)
            (folder / "scene.json").write_text(text, encoding="utf-8", errors="surrogatepass")
            validated, complaint = deform(folder, "validate", "scene.json")
            code, said = deform(folder, "run", "scene.json", "--out", "out", "--threads", "1", "--quiet")
            wrong = objection(folder, code, said)
            if not wrong and (validated not in (DONE, REFUSED, 4) or re.search(CRASH, complaint)):
                wrong = f"`validate` ends with {validated}: {complaint[:300]}"
            if not wrong and code == REFUSED and validated != REFUSED:
                wrong = f"is refused by `run`, but `validate` ends with {validated}"
        if str(code) == SHOWN:
            wrong = wrong or f"ends with {code}"
        if wrong:
            wrong = (f"{wrong}\nDEFORM_MUTATIONS=1 DEFORM_MUTATION_SEED={SEED + number} shows it again\n"
                     f"{'; '.join(done)}\n{text[:3000]}\n{said[:2000]}")
        return code, wrong

    def test_all_end(self):
        self.deadline = time.monotonic() + SECONDS
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            results = [result for result in pool.map(self.try_one, range(COUNT)) if result]
        codes = [code for code, _ in results]
        counts = {code: codes.count(code) for code in sorted(set(codes), key=str)}
        print(f"{len(results)} scenes, by exit code: {counts}", file=sys.stderr)
        wrong = [why for _, why in results if why]
        self.assertEqual(len(wrong), 0, "\n\n".join(wrong[:10]))
        if COUNT >= 100:  # changes that are always refused, or never, would try nothing
            self.assertGreater(codes.count(DONE), len(codes) / 20)
            self.assertGreater(codes.count(REFUSED), len(codes) / 20)


if __name__ == "__main__":
    unittest.main(verbosity=2)
