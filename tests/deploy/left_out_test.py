#!/usr/bin/env python3
"""No program goes into the images that needs what they leave out.

    left_out_test.py TREE
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

DEPLOY = pathlib.Path(sys.argv[1]) / "deploy"
PROGRAMS = ("treeline", "treeline-server", "treeline-client", "treeline-agent")


class LeftOut(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "bin").mkdir()
        for program in PROGRAMS:
            # bash maps libtinfo and libc.
            shutil.copy("/bin/bash", self.folder / "bin" / program)
        shutil.copy(DEPLOY / "collect-programs", self.folder)

    def collect(self, left_out):
        (self.folder / "left-out-files").write_text(left_out)
        return subprocess.run(
            [self.folder / "collect-programs", self.folder / "bin",
             self.folder / "out"], text=True, capture_output=True, check=False)

    def test_what_the_list_leaves_out_is_not_needed(self):
        done = self.collect((DEPLOY / "left-out-files").read_text())
        self.assertEqual(done.returncode, 0, done.stderr)
        packages = (self.folder / "out" / "packages-agent.txt").read_text()
        self.assertIn("libc6", packages.split())

    def test_what_is_needed_and_left_out_is_named(self):
        done = self.collect("# why\npath-exclude /usr/share/man/*\n"
                            "path-exclude /usr/lib/*/libtinfo.so*\n")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr,
                         r"treeline needs /\S*libtinfo\.so\S*, which \S*"
                         "left-out-files leaves out")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
