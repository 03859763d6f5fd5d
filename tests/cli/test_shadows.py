"""Shadows are measured on the run's states and change nothing of them."""

import struct
import unittest

from test_checkpoints import Checkpoints, results, scene
from test_run_command import sheet

SHADOWS = ["gauss", {"plugin": "gauss", "delta": "infinity"}, "terzopoulos", "exact"]
FIGURES = {"angle.mean": "rad", "angle.max": "rad", "force.rms": "N", "force.max": "N",
           "force.relative": "1"}


def after_file(checkpoint, at):
    """Where the description of a written file ends that begins there."""
    name, digits, _ = struct.unpack_from("<QQQ", checkpoint, at)
    return at + 24 + name + digits


def memory_of(checkpoint):
    """The entries of a checkpoint file."""
    at = len(b"deform checkpoint\n") + 4 + 64 + 8
    (files,) = struct.unpack_from("<Q", checkpoint, at)
    at += 8
    for _ in range(files):  # that it relies on: name, bytes, hash
        at = after_file(checkpoint, at)
    (count,) = struct.unpack_from("<Q", checkpoint, at)
    at += 8
    entries = {}
    for _ in range(count):
        name, values = struct.unpack_from("<QQ", checkpoint, at)
        at += 16
        entries[checkpoint[at:at + name].decode()] = checkpoint[at + name:at + name + 8 * values]
        at += name + 8 * values
    return entries


class Shadows(Checkpoints):
    def columns(self):
        """Of probes.csv: the fields below each header."""
        header, *rows = self.rows()
        return {name: [row[i] for row in rows] for i, name in enumerate(header)}

    def test_columns_and_summary(self):
        self.run_scene(sheet(shadow=SHADOWS[:2]))
        columns = self.columns()
        summary = self.load("summary.json")["probes"]
        for name in ("gauss", "gauss_2"):
            for figure, unit in FIGURES.items():
                column = columns[f"shadow.{name}.bending.{figure} [{unit}]"]
                found = summary[f"shadow.{name}.bending.{figure}"]
                self.assertEqual(found["unit"], unit)
                self.assertEqual(found["final"], float(column[-1]))
                self.assertEqual(found["max"], max(float(x) for x in column if x))
                self.assertGreater(float(column[-1]), 0)
                self.assertEqual(column[0] == "", figure.startswith("angle") or figure == "force.relative")

    def test_states_are_those_of_the_run_without(self):
        def without(name):
            return not name.startswith("shadow.")

        # With frames, mirror image, outputs and all; probes are due at some steps only.
        whole = dict(scene(), probes=[{"plugin": "energy", "every": 2}, {"plugin": "lowest", "every": 4},
                                      {"plugin": "mirror_asymmetry", "every": 3}])
        self.run_scene(whole)
        plain, plain_columns = results(self.out), self.columns()
        self.run_scene({**whole, "shadow": SHADOWS}, "--force")
        shadowed, columns = results(self.out), self.columns()
        self.assertEqual(len(columns), len(plain_columns) + 5 * len(SHADOWS))
        self.assertEqual({k: v for k, v in columns.items() if without(k)}, plain_columns)
        self.assertEqual(sorted(shadowed), sorted(plain))
        self.assertIn("trajectory.bin", plain)
        for name in set(plain) - {"scene.json", "probes.csv", "summary.json", "checkpoint.bin",
                                  "report.html"}:
            self.assertTrue(shadowed[name] == plain[name], f"{name} differs")
        memory, plain_memory = (memory_of(r["checkpoint.bin"]) for r in (shadowed, plain))
        for name in ("simulation/state/r", "simulation/state/v", "simulation/state/previous_r"):
            self.assertEqual(memory[name], plain_memory[name])
        for name in set(plain_memory) - {"probes/figures"}:
            self.assertEqual(memory[name], plain_memory[name], name)

    def test_killed_and_resumed(self):
        path = self.write(scene(shadow=SHADOWS, duration=12.0))
        expected = self.run_whole(path)
        process = self.start(path)
        self.wait_for_checkpoint(process)
        process.kill()
        process.communicate()
        self.resume(path)
        self.assert_same_results(expected)

    def test_other_shadows_are_another_scene(self):
        self.run_scene(scene(shadow=["gauss"]))
        result = self.resume(self.write(scene(shadow=["exact"])), expect=2)
        self.assertIn("the first difference is at /shadow/0", result.stderr)

    def test_the_completed_scene_runs_again(self):
        self.run_scene(sheet(shadow=SHADOWS))
        first = results(self.out)
        again = self.folder / "again"
        result = self.deform("run", self.out / "scene.json", "--out", again)
        self.assertEqual(result.returncode, 0, result.stderr)
        for name in ("scene.json", "probes.csv", "trajectory.bin"):
            self.assertEqual(results(again)[name], first[name])

    def test_option_appends_to_the_scenes_list(self):
        self.run_scene(sheet(shadow=["gauss"]), "--shadow", "exact,terzopoulos", "--shadow",
                       '{"plugin": "gauss", "delta": 0.1}')
        shadows = self.load("scene.json")["shadow"]
        self.assertEqual([use["plugin"] for use in shadows], ["gauss", "exact", "terzopoulos", "gauss"])
        self.assertEqual(shadows[3]["delta"], 0.1)
        by_option = results(self.out)["probes.csv"]
        self.run_scene(sheet(), "--set", '/shadow=["gauss", "exact", "terzopoulos", '
                       '{"plugin": "gauss", "delta": 0.1}]', "--force")
        self.assertEqual(results(self.out)["probes.csv"], by_option)

    def test_option_names_what_is_wrong(self):
        path = self.write(sheet())
        for arguments, said in (
                (["exat"], ["--shadow /shadow/0: at /shadow/0", 'did you mean "exact"?']),
                (["exact,gaus"], ["--shadow /shadow/1: at /shadow/1", 'did you mean "gauss"?']),
                (['{"plugin": "gauss", "delta": -1}'], ["at /shadow/0/delta", "found -1"]),
                (["exact", "--set", "/energies/1=bending_variational"],
                 ["at /shadow: no energy term of this scene takes a normal estimator"])):
            with self.subTest(arguments):
                result = self.deform("run", path, "--out", self.out, "--shadow", *arguments)
                self.assertEqual(result.returncode, 2, result.stderr)
                for text in said:
                    self.assertIn(text, result.stderr)
                self.assertFalse(self.out.exists())

    def test_plugins_of_shadows_are_in_the_manifest(self):
        self.run_scene(sheet(shadow=["terzopoulos"]))
        plugins = {f"{p['kind']}/{p['name']}" for p in self.load("manifest.json")["plugins"]}
        self.assertIn("normal/terzopoulos", plugins)
        self.assertIn("normal/exact", plugins)


if __name__ == "__main__":
    unittest.main(verbosity=2)
