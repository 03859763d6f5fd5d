"""A stranger's way: install deform, copy the example project elsewhere, build it against the installation, check
its plugins and run its scene; and begin projects of one's own with `deform plugin new`."""

import json
import os
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

PROGRAM = Path(os.environ["DEFORM_PROGRAM"])
SOURCE = Path(os.environ["DEFORM_SOURCE"])
BUILD = PROGRAM.parent.parent
TIMEOUT = 500

PARAMETERS = {"constraint": {"where": {"boundary": "left"}}}
MOST_LINES = {"curvature_blend.cpp": 25, "saint_venant.cpp": 40}


def lines_of_code(file):
    lines = [line.strip() for line in file.read_text(encoding="utf-8").splitlines()]
    return sum(1 for line in lines if line and not line.startswith("//"))


class Outside(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory(prefix="deform_outside_")
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = Path(temporary.name)
        cls.prefix = cls.folder / "prefix"
        cls.command("cmake", "--install", BUILD, "--prefix", cls.prefix)
        cls.program = cls.prefix / "bin" / "deform"

    @classmethod
    def command(cls, *arguments, expect=0, cwd=None):
        environment = {k: v for k, v in os.environ.items() if not k.startswith("DEFORM_")}
        result = subprocess.run([str(a) for a in arguments], cwd=cwd or cls.folder, text=True,
                                capture_output=True, timeout=TIMEOUT, env=environment)
        if result.returncode != expect:
            raise AssertionError(f"{arguments} ended with {result.returncode}, expected {expect}:\n"
                                 f"{result.stdout}\n{result.stderr}")
        return result

    def build(self, project):
        self.command("cmake", "-S", project, "-B", project / "build",
                     f"-DCMAKE_PREFIX_PATH={self.prefix}")
        return self.command("cmake", "--build", project / "build", "--parallel", "2")


class Installation(Outside):
    def test_the_program_finds_the_plugins_that_were_installed_with_it(self):
        listed = self.command(self.program, "plugins").stdout
        folder = re.search(r"^ +(.*) \(installation\)$", listed, re.MULTILINE).group(1)
        self.assertTrue(Path(folder).is_relative_to(self.prefix), folder)
        self.assertIn("gauss", listed)
        self.assertNotIn("DOES NOT LOAD", listed)

    def test_the_licences_come_with_it(self):
        for name in ("LICENSE", "LICENSES.md", "README.md"):
            self.assertTrue((self.prefix / "share" / "doc" / "deform" / name).is_file(), name)

    def test_it_may_be_moved(self):
        moved = self.folder / "moved"
        shutil.copytree(self.prefix, moved, symlinks=True)
        listed = self.command(moved / "bin" / "deform", "plugins").stdout
        self.assertIn(f"{moved}/", listed)
        self.assertNotIn("DOES NOT LOAD", listed)

    def test_a_plugins_author_needs_nothing_but_eigen(self):
        config = next(self.prefix.rglob("deformConfig.cmake")).read_text()
        self.assertEqual(re.findall(r"find_dependency\((\w+)", config), ["Eigen3"])
        targets = next(self.prefix.rglob("deformTargets.cmake")).read_text()
        self.assertIn("-march=", targets)
        self.assertIn("-fno-gnu-unique", targets)
        self.assertNotIn(str(BUILD), targets)
        self.assertNotIn(str(SOURCE), targets)


class Example(Outside):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.project = cls.folder / "my-plugins"
        shutil.copytree(SOURCE / "examples" / "my-plugins", cls.project,
                        ignore=shutil.ignore_patterns("build", "runs"))

    def test_builds_keeps_its_promises_and_runs(self):
        self.build(self.project)
        plugins = self.project / "build"
        for library in ("normal-curvature_blend.so", "energy-saint_venant.so"):
            table = self.command(self.program, "plugin", "check", plugins / library).stdout
            self.assertIn(" 0 failed", table)
        gradient = re.search(r"force = −gradient of the energy, as promised +(\S+)", table)
        self.assertLess(float(gradient.group(1)), 1e-6)

        out = self.folder / "run"
        self.command(self.program, "run", self.project / "scene.json", "--plugin-path", plugins,
                     "--out", out)
        summary = json.loads((out / "summary.json").read_text())
        self.assertEqual(summary["status"], "done")
        self.assertTrue(-0.5 < summary["probes"]["lowest"]["final"] < 0, summary)
        # Friction takes what gravity gives: the total energy falls.
        self.assertLess(summary["probes"]["energy.total"]["final"], 0)
        log = (out / "log.txt").read_text()
        self.assertEqual(log.count("numerical derivative of its energy density"), 1, log)
        self.assertIn("energy/saint_venant", log)

    def test_is_as_short_as_it_can_be(self):
        for name, most in MOST_LINES.items():
            self.assertLessEqual(lines_of_code(self.project / name), most, name)


class NewPlugin(Outside):
    def new(self, *arguments, expect=0):
        return self.command(self.program, "plugin", "new", *arguments, expect=expect)

    def kinds(self):
        return self.new("colour", "red", expect=2).stderr.strip().rpartition("kinds are ")[2].split(", ")

    def test_projects_of_every_kind_build_keep_their_promises_and_run(self):
        projects = self.folder / "projects"
        projects.mkdir()
        kinds = self.kinds()
        self.assertIn("energy", kinds)
        for kind in kinds:
            self.new(kind, f"my_{kind}", "--out", projects / f"my_{kind}")
        # Each stands alone; together they are configured once.
        folders = "".join(f"add_subdirectory(my_{kind})\n" for kind in kinds)
        (projects / "CMakeLists.txt").write_text(
            f"cmake_minimum_required(VERSION 3.22)\nproject(all LANGUAGES CXX)\n{folders}")
        self.build(projects)
        for kind in kinds:
            with self.subTest(kind=kind):
                plugins = projects / "build" / f"my_{kind}"
                library = plugins / f"{kind}-my_{kind}.so"
                self.command(self.program, "plugin", "check", library, "--parameters",
                             json.dumps(PARAMETERS.get(kind, {})))
                self.command(self.program, "run", projects / f"my_{kind}" / "scene.json",
                             "--plugin-path", plugins, "--out", self.folder / "runs" / kind)

    def test_one_alone(self):
        said = self.new("force", "breeze").stdout
        project = self.folder / "breeze"
        self.assertEqual(sorted(path.name for path in project.iterdir()),
                         ["CMakeLists.txt", "README.md", "breeze.cpp", "scene.json"])
        self.assertNotIn("@", "".join(path.read_text() for path in project.iterdir()))
        self.assertIn("deform plugin check breeze/build/force-breeze.so", said)
        self.build(project)
        self.command(self.program, "run", project / "scene.json", "--plugin-path",
                     project / "build", "--out", self.folder / "runs" / "breeze")

    def test_refusals(self):
        existing = self.folder / "existing"
        existing.mkdir()
        (existing / "thesis.tex").write_text("years of work")
        refused = {("force", "gust", "--out", existing): "exists",
                   ("force", "existing"): "exists",
                   ("colour", "red"): "kinds are surface, shape",
                   ("force", "Gust"): "no name for a plugin",
                   ("force", "../gust"): "no name for a plugin",
                   ("force", "my-gust"): "no name for a plugin",
                   ("force", ""): "no name for a plugin"}
        for arguments, why in refused.items():
            with self.subTest(arguments=arguments):
                self.assertIn(why, self.new(*arguments, expect=2).stderr)
        self.assertEqual([path.name for path in existing.iterdir()], ["thesis.tex"])
        self.assertFalse((self.folder / "gust").exists())


if __name__ == "__main__":
    unittest.main()
