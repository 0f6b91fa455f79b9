"""Small trees of files, made for one test."""

import pathlib
import tempfile
import unittest

import lint_common


class FixtureTreeTest(unittest.TestCase):
    """A test case with an empty tree at self.root."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = folder.name

    def write(self, path, text=""):
        file = pathlib.Path(self.root, path)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")


class FilesOfTest(FixtureTreeTest):

    def test_leaves_build_folders_out(self):
        for path in ("a/x.cc", "build/dev/y.cc", "a/out/z.cc", ".git/w.cc"):
            self.write(path)
        self.assertEqual(lint_common.files_of(self.root, (".cc",)),
                         ["a/x.cc"])
