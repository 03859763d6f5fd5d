"""The committed schemas are those of the program, and agree with its reader on every scene."""

import copy
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "bad_scenes"))
import cases  # noqa: E402

PROGRAM = os.environ["DEFORM_PROGRAM"]
SOURCE = Path(os.environ["DEFORM_SOURCE"])
FIXTURES = os.environ.get("DEFORM_FIXTURE_PLUGINS", "")
SCHEMAS = SOURCE / "schemas"
HERE = Path(__file__).parent
TIMEOUT = 300  # seconds; with sanitizers, on a busy machine


def deform(*arguments, cwd=None):
    environment = {k: v for k, v in os.environ.items() if k != "DEFORM_PLUGIN_PATH"}
    return subprocess.run([PROGRAM, *map(str, arguments)], cwd=cwd, env=environment, text=True,
                          encoding="utf-8", capture_output=True, timeout=TIMEOUT,
                          stdin=subprocess.DEVNULL)


def ajv(pairs):
    """What ajv says of pairs of schema and file."""
    result = subprocess.run(["node", HERE / "validate.mjs"], cwd=HERE, text=True, encoding="utf-8",
                            capture_output=True, timeout=TIMEOUT,
                            input=json.dumps([[str(path) for path in pair] for pair in pairs]))
    if result.returncode != 0:
        hint = "" if (HERE / "node_modules").exists() else "run npm ci in tests/schemas first\n"
        raise RuntimeError(hint + result.stderr)
    return json.loads(result.stdout)


def reader(files, *arguments):
    """What the reader says of each file: a list of problems."""
    said = {str(file): [] for file in files}
    for start in range(0, len(files), 200):
        result = deform("validate", *arguments, *files[start:start + 200])
        for line in result.stderr.splitlines():
            if line.startswith("deform: warning: "):  # a remark on what is no error
                continue
            found = re.match(r"deform: ([^:]+):\d+:\d+: (.*)", line)
            if not found:
                raise RuntimeError(f"neither a problem nor a place: {line}")
            said[found[1]].append(found[2])
        accepted = re.findall(r"^(.+): ok \(\d+ variants?\)$", result.stdout, re.MULTILINE)
        for file in map(str, files[start:start + 200]):
            if (file in accepted) == bool(said[file]):
                raise RuntimeError(f"{file}: {said[file]}, accepted: {file in accepted}")
    return [said[str(file)] for file in files]


class Folder(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="deform_schemas_")
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)


class Committed(Folder):
    def test_are_those_of_the_program(self):
        result = deform("schema", "--out", self.folder)
        self.assertEqual((result.returncode, result.stdout, result.stderr), (0, "", ""))
        made = {file.relative_to(self.folder): file.read_bytes()
                for file in self.folder.rglob("*.json")}
        kept = {file.relative_to(SCHEMAS): file.read_bytes() for file in SCHEMAS.rglob("*.json")}
        self.assertEqual(sorted(made), sorted(kept), "run scripts/schemas")
        for name, text in made.items():
            self.assertEqual(text, kept[name], f"{name}: run scripts/schemas")

    def test_is_what_is_printed(self):
        result = deform("schema")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertEqual(result.stdout, (SCHEMAS / "scene.schema.json").read_text(encoding="utf-8"))

    def test_folder_that_cannot_be_made(self):
        (self.folder / "file").touch()
        result = deform("schema", "--out", self.folder / "file")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("--out", result.stderr)

    def test_of_plugins_compile(self):
        surface = self.folder / "surface.json"
        surface.write_text(json.dumps(cases.BASE["surface"]), encoding="utf-8")
        schemas = sorted(SCHEMAS.glob("plugins/*.json"))
        for schema, verdict in zip(schemas, ajv((schema, surface) for schema in schemas)):
            with self.subTest(schema.name):
                self.assertEqual(verdict["accepted"], schema.name == "surface-grid.schema.json")

    def test_a_plugin_that_does_not_load_is_left_out(self):
        (self.folder / "normal-broken.so").write_text("no library")
        result = deform("schema", "--plugin-path", self.folder)
        self.assertEqual(result.returncode, 0)
        self.assertIn("normal/broken is left out", result.stderr)
        self.assertNotIn("normal-broken", result.stdout)


class Agreement(Folder):
    """Of ajv, with the schema, and the reader."""

    schema = SCHEMAS / "scene.schema.json"

    def judge(self, files):
        return ajv((self.schema, file) for file in files)

    def write(self, scenes):
        files = []
        for name, scene in scenes.items():
            files.append(self.folder / f"{name}.json")
            files[-1].write_text(json.dumps(scene, indent=1), encoding="utf-8")
        return files

    def test_scenes_of_the_repository(self):
        files = sorted(file for file in (SOURCE / "scenes").rglob("*.json")
                       if not file.name.endswith(".expect.json"))
        self.assertTrue(files)
        for file, verdict, said in zip(files, self.judge(files), reader(files)):
            self.assertTrue(verdict.get("accepted"), f"{file}: {verdict}")
            self.assertEqual(said, [])
            named = re.search(r'"\$schema": "([^"]+)"', file.read_text(encoding="utf-8"))
            self.assertEqual((file.parent / named[1]).resolve(), self.schema.resolve())

    def test_completed_scene(self):
        scene = self.write({"scene": cases.changed({"/outputs": [], "/duration": 0.02})})[0]
        result = deform("run", scene, "--out", self.folder / "run", "--quiet")
        self.assertEqual(result.returncode, 0, result.stderr)
        verdict = self.judge([self.folder / "run" / "scene.json"])[0]
        self.assertTrue(verdict["accepted"], verdict)

    def test_cases(self):
        cases.write_all(self.folder / "cases")
        index = json.loads((self.folder / "cases" / "index.json").read_text(encoding="utf-8"))
        verdicts = self.judge([self.folder / "cases" / case["file"] for case in index])
        for case, verdict in zip(index, verdicts):
            with self.subTest(case["name"]):
                self.assertEqual(verdict["json"], case["beyond"] != "syntax")
                if verdict["json"]:
                    expected = case["good"] or bool(case["beyond"])
                    self.assertEqual(verdict["accepted"], expected, verdict["errors"])

    def test_errors_speak_of_the_plugin_that_is_named_alone(self):
        for pointer, value in (("/energies/1/normal/delt", 1), ("/energies/1/form", "expandet"),
                               ("/outputs/0/every", 0), ("/forces/0/plugin", "gravit"),
                               ("/probes/0", "energi")):
            with self.subTest(pointer):
                file = self.write({"scene": cases.changed({pointer: value})})[0]
                errors = self.judge([file])[0]["errors"]
                self.assertTrue(errors)
                for path, message in errors:
                    self.assertTrue(pointer.startswith(path), (path, message))

    def assert_agree(self, schema, scenes, *arguments):
        """The schema rejects nothing that is right, and accepts of what is wrong only what no
        schema can reject."""
        files = self.write(scenes)
        beyond = "|".join(pattern for why, pattern in cases.BEYOND_SCHEMA.values() if pattern)
        disagreements, right = [], 0
        for file, verdict, said in zip(files, ajv((schema, file) for file in files), reader(files, *arguments)):
            right += not said
            scene = json.loads(file.read_text(encoding="utf-8"))
            if not said and not verdict["accepted"]:
                disagreements.append(f"too strict: {verdict['errors']}: {scene}")
            for problem in said if verdict["accepted"] else []:
                if not re.search(beyond, problem):
                    disagreements.append(f"too lax: {problem}: {scene}")
        print(f"{len(files)} changed scenes, {right} of them right", file=sys.stderr)
        self.assertEqual(disagreements, [], "\n".join(disagreements[:20]))
        self.assertTrue(0 < right < len(files))

    def test_changes_of_scenes(self):
        scenes = mutations(cases.BASE, "")
        for name, changes in cases.GOOD.items():
            for pointer, value in changes.items():
                if value is not cases.REMOVE and not isinstance(value, (int, float, str)):
                    at = pointer.replace("/-", "/1")
                    for key, scene in mutations(cases.changed(changes), at).items():
                        scenes[f"{name}_{key}"] = scene
        self.assert_agree(self.schema, scenes)

    @unittest.skipUnless(FIXTURES, "plugins of the tests are not there")
    def test_changes_of_every_type(self):
        deform("schema", "--plugin-path", FIXTURES, "--out", self.folder / "schemas")
        force = {
            "plugin": "every_type", "flag": False, "small": 2, "whole": -7, "number": 0.25,
            "limit": "infinity", "unsaid": 1, "text": "t", "choice": "right", "pair": [1, 2],
            "vector": [1, 2, 3], "weights": 1, "field": {"formula": "1 + a1/9"}, "named": {"k": 1},
            "weights_field": [[1, {"formula": "a1"}], [{"formula": "a1"}, 2]], "numbers": [1, 2], "wholes": [1], "flags": [True],
            "texts": ["x"], "counts": [2, 3], "both": True, "places": [[1, 2, 3]], "time": 1,
            "where": {"node": 1}, "normal": "gauss", "shape": "flat", "file": "f", "no_file": "g",
        }
        scenes = mutations(cases.changed({"/forces/-": force}), "/forces/1")
        self.assert_agree(self.folder / "schemas" / "scene.schema.json", scenes, "--plugin-path",
                          FIXTURES)


VALUES = [None, True, -1, 0, 1, 2.5, 1e300, "", "x", "flat", "all", [], {}, [1, 2], [0, 1, 2], ["x"],
          [[1, 0], [0, 1]], {"plugin": "exact"}, {"ramp": [0, 1]}, {"node": 0}]


def pointers_of(value, pointer=""):
    """Those of the value and of everything in it."""
    yield pointer
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, child in items:
        step = str(key).replace("~", "~0").replace("/", "~1")
        yield from pointers_of(child, f"{pointer}/{step}")


def steps_of(pointer):
    return [step.replace("~1", "/").replace("~0", "~") for step in pointer.split("/")[1:]]


def mutations(scene, below):
    """The scene with each value at or below a pointer replaced, taken away, or given a new key."""
    made = {}

    def at(root, steps):
        for step in steps:
            root = root[int(step)] if isinstance(root, list) else root[step]
        return root

    for n, pointer in enumerate(pointers_of(at(scene, steps_of(below)), below)):
        steps = steps_of(pointer)
        for i, value in enumerate([*VALUES, cases.REMOVE]):
            if not steps:
                continue
            changed = copy.deepcopy(scene)
            parent = at(changed, steps[:-1])
            key = int(steps[-1]) if isinstance(parent, list) else steps[-1]
            if value is cases.REMOVE:
                del parent[key]
            else:
                parent[key] = value
            made[f"{n}_{i}"] = changed
        changed = copy.deepcopy(scene)
        if isinstance(at(changed, steps), dict):
            at(changed, steps)["unknown"] = 1
            made[f"{n}_key"] = changed
    return made


if __name__ == "__main__":
    unittest.main(verbosity=2)
