#!/usr/bin/env python3
"""The wire contract keeps buf's rules and is not broken.

    contract_test.py FOLDER PROTO

FOLDER is where npm has fetched buf into node_modules; PROTO holds the .proto
files, buf.yaml and contract.binpb, the contract to compare with.
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

SKIPPED = 77
FOLDER = pathlib.Path(sys.argv[1])
PROTO = pathlib.Path(sys.argv[2])
BUF = FOLDER / "node_modules" / ".bin" / "buf"


def buf(verb, protos, *arguments):
    """What `buf VERB` says of a folder with .proto files."""
    return subprocess.run([BUF, verb, ".", *arguments], cwd=protos,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, check=False)


class Contract(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.copy = pathlib.Path(folder.name) / "proto"
        shutil.copytree(PROTO, self.copy)

    def breaking(self, protos):
        return buf("breaking", protos, "--against", "contract.binpb")

    def change(self, file, before, after):
        path = self.copy / "treeline" / "v1" / file
        text = path.read_text()
        self.assertIn(before, text)
        path.write_text(text.replace(before, after))

    def test_keeps_the_rules(self):
        result = buf("lint", PROTO)
        self.assertEqual(result.returncode, 0, result.stdout)

    def test_is_not_broken(self):
        result = self.breaking(PROTO)
        self.assertEqual(result.returncode, 0, result.stdout)

    def test_a_zero_with_a_meaning_is_found(self):
        self.change("relocalization.proto", "OUTCOME_UNSPECIFIED",
                    "OUTCOME_NONE")
        result = buf("lint", self.copy)
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("OUTCOME_NONE", result.stdout)

    def test_a_number_that_changes_is_found(self):
        self.change("relocalization.proto", "OUTCOME_LOCALIZED = 1",
                    "OUTCOME_LOCALIZED = 3")
        result = self.breaking(self.copy)
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("Outcome", result.stdout)

    def test_a_name_that_goes_is_found(self):
        self.change("navigation.proto", "  NAVIGATION_CAUSE_NONE = 0",
                    "  // NAVIGATION_CAUSE_NONE = 0")
        self.assertNotEqual(self.breaking(self.copy).returncode, 0)

    def test_what_is_added_breaks_nothing(self):
        self.change("relocalization.proto", "  OUTCOME_NOT_LOCALIZED = 2;",
                    "  OUTCOME_NOT_LOCALIZED = 2;\n  OUTCOME_MORE = 3;")
        result = self.breaking(self.copy)
        self.assertEqual(result.returncode, 0, result.stdout)


if __name__ == "__main__":
    if not BUF.exists():
        print("SKIPPED: npm's registry could not be reached for buf")
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1])
