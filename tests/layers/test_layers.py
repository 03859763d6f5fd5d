"""Includes of the core run downwards: a layer knows those below it and nothing of those above."""

import os
import re
import unittest
from pathlib import Path

ROOT = Path(os.environ.get("DEFORM_SOURCE", Path(__file__).resolve().parents[2]))

# From the bottom up. A folder of framework/include/deform and the one of framework/src with the same
# name are one layer; files in no folder (errors, logs, types, …) are "base".
LAYERS = ["base", "text", "files", "json", "profile", "geometry", "plugin", "parallel", "surface", "model",
          "solve", "record", "host", "simulation", "scene", "compare", "report", "check"]

# What may look upwards all the same: (file, included file), and why.
EXCEPTIONS = {
    ("framework/src/geometry/geometry.cpp", "deform/surface/sample_set.h"):
        "geometries are computed at the samples of a surface, which are made of pairs and derivatives "
        "that geometry defines",
    ("framework/src/plugin/setup.cpp", "deform/surface/surface.h"):
        "a Setup hands the surface to plugins, and a surface is a plugin: one of the two must name the "
        "other; the header does so without including it",
}

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]+["<]([^">]+)[">]', re.MULTILINE)
PUBLIC, PRIVATE = "framework/include/deform/", "framework/src/"


def layer_of(path):
    """The layer of a file that is named from the top of the repository; None where it has none."""
    inside = path.removeprefix(PUBLIC).removeprefix(PRIVATE)
    if inside == path:
        return None
    return inside.split("/")[0] if "/" in inside else "base"


def target_of(include):
    """The file of the core that an include directive names; None where it is a library's."""
    for path in (f"framework/include/{include}", f"{PRIVATE}{include}"):
        if (ROOT / path).is_file():
            return path
    return None


def includes(path):
    return INCLUDE.findall((ROOT / path).read_text())


def files(*folders):
    for folder in folders:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in (".h", ".cpp") and "node_modules" not in path.parts:
                yield path.relative_to(ROOT).as_posix()


def is_upward(path, include):
    target = target_of(include)
    return target is not None and LAYERS.index(layer_of(target)) > LAYERS.index(layer_of(path))


class Layers(unittest.TestCase):
    def test_every_folder_of_the_core_is_a_layer(self):
        found = {layer_of(path) for path in files("framework/include", "framework/src")}
        self.assertEqual(found, set(LAYERS))

    def test_includes_run_downwards(self):
        upward = {(path, include) for path in files("framework/include", "framework/src")
                  for include in includes(path) if is_upward(path, include)}
        for path, include in sorted(upward - set(EXCEPTIONS)):
            with self.subTest(path):
                self.fail(f'{path} includes "{include}", which is of a layer above it: move one of them, or '
                          "what they share")
        self.assertEqual(set(EXCEPTIONS) - upward, set(), "exceptions that nothing needs any more")

    def test_knows_upward_from_downward(self):
        self.assertTrue(is_upward("framework/src/plugin/expression.cpp", "deform/solve/system.h"))
        self.assertTrue(is_upward("framework/src/error.cpp", "json/json.h"))
        self.assertFalse(is_upward("framework/src/solve/system.cpp", "deform/plugin/plugin.h"))
        self.assertFalse(is_upward("framework/src/solve/system.cpp", "deform/solve/system.h"))
        self.assertFalse(is_upward("framework/src/error.cpp", "nlohmann/json.hpp"))
        self.assertEqual(INCLUDE.findall('#include "a.h"\n  # include <b>\n// #include "c.h"\n'), ["a.h", "b"])


class Borders(unittest.TestCase):
    """Who may see what, beyond layers."""

    def refuse(self, folders, is_refused, rule):
        for path in files(*folders):
            for include in includes(path):
                with self.subTest(path):
                    self.assertFalse(is_refused(include), f'{path} includes "{include}": {rule}')

    def test_public_headers_include_public_ones_alone(self):
        self.refuse(["framework/include"], lambda include: (target_of(include) or PUBLIC).startswith(PRIVATE),
                    "a public header includes no private one")

    def test_plugins_and_applications_include_public_headers_alone(self):
        self.refuse(["plugins", "apps", "tests/model", "examples"],
                    lambda include: (target_of(include) or PUBLIC).startswith(PRIVATE),
                    "only what is below framework/include/deform is for plugins and applications")


if __name__ == "__main__":
    unittest.main()
