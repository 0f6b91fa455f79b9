"""`cmake --install` of each component puts there what it should.

    installed_files_test.py PACKAGING BUILD
"""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from packaging import arguments

PACKAGING, BUILD = arguments(2)
# That of project() in CMakeLists.txt.
VERSION = re.search(r"(?m)^CMAKE_PROJECT_VERSION:\w+=(.*)$",
                    (BUILD / "CMakeCache.txt").read_text())[1]
SHARE = "share/treeline"
# Of each component what must be there, and what may be: pages, where they were
# built.
COMPONENTS = {
    "server": (["bin/treeline-server"], None),
    "client-program": (["bin/treeline-client"],
                       rf"{SHARE}/bench-report\.html"),
    "agent": (["bin/treeline-agent"], rf"{SHARE}/page/.*"),
    "tools": (["bin/treeline", "bin/treeline-emulator",
               f"{SHARE}/models/base-rgb.treeline",
               f"{SHARE}/models/base-rgbd.treeline"],
              rf"{SHARE}/report\.html"),
    "demo": (["bin/treeline-demo", f"{SHARE}/demo/demo_table.py"], None),
    "ar-page": ([], rf"{SHARE}/ar-page/.*"),
}


class InstalledFilesTest(unittest.TestCase):

    def installed(self, component):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        done = subprocess.run(
            ["cmake", "--install", BUILD, "--component", component, "--prefix",
             folder.name], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        prefix = pathlib.Path(folder.name)
        return prefix, {str(path.relative_to(prefix))
                        for path in prefix.rglob("*") if path.is_file()}

    def test_each_component_has_its_files_and_no_others(self):
        for component, (needed, allowed) in COMPONENTS.items():
            with self.subTest(component=component):
                _, files = self.installed(component)
                self.assertLessEqual(set(needed), files)
                for file in files - set(needed):
                    self.assertTrue(
                        allowed and re.fullmatch(allowed, file), file)

    def test_programs_run_from_where_they_are_installed(self):
        for component, (needed, _) in COMPONENTS.items():
            if component == "demo":
                continue
            prefix, _ = self.installed(component)
            for file in needed:
                if not file.startswith("bin/"):
                    continue
                self.assertTrue(os.access(prefix / file, os.X_OK), file)
                done = subprocess.run([prefix / file, "--version"],
                                      capture_output=True, text=True,
                                      check=False, env={})
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(
                    done.stdout, f"{pathlib.Path(file).name} {VERSION}\n")

    def test_no_component_is_forgotten(self):
        stage = (PACKAGING / "stage").read_text()
        staged = set(re.findall(r"install_component (\S+) ", stage))
        self.assertEqual(staged, {*COMPONENTS, "client"})
        for rules in ("deploy/packages", "client/package"):
            text = (PACKAGING.parents[1] / rules /
                    "CMakeLists.txt").read_text()
            named = set(re.findall(r"COMPONENT ([a-z-]+)", text))
            self.assertLessEqual(named, staged)


if __name__ == "__main__":
    unittest.main(argv=["installed_files_test.py"])
