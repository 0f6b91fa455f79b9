"""`docker build` gets all that CMake and the Dockerfile need."""

import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from docker_context import DockerIgnore, copy_context
from stub_programs import REPOSITORY


class DockerIgnoreTest(unittest.TestCase):

    def test_the_last_rule_that_matches_decides(self):
        ignore = DockerIgnore("# why\n*\n!server\nserver/models\n")
        self.assertTrue(ignore.excludes("docs/readme.md"))
        self.assertFalse(ignore.excludes("server"))
        self.assertFalse(ignore.excludes("server/app/main.cc"))
        self.assertTrue(ignore.excludes("server/models/base.treeline"))

    def test_one_star_ends_at_a_folder_and_two_do_not(self):
        ignore = DockerIgnore("a/*.o\n**/__pycache__\nb/**/c\n")
        self.assertTrue(ignore.excludes("a/x.o"))
        self.assertFalse(ignore.excludes("a/b/x.o"))
        self.assertTrue(ignore.excludes("__pycache__/x"))
        self.assertTrue(ignore.excludes("a/b/__pycache__/x"))
        self.assertTrue(ignore.excludes("b/c"))
        self.assertTrue(ignore.excludes("b/d/e/c/f"))

    def test_other_signs_stand_for_themselves(self):
        ignore = DockerIgnore("a.b\n/c?\n[de]f/\n")
        self.assertTrue(ignore.excludes("a.b"))
        self.assertFalse(ignore.excludes("axb"))
        self.assertTrue(ignore.excludes("cc"))
        self.assertTrue(ignore.excludes("df/g"))


class ContextTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="docker_context_")
        cls.addClassCleanup(folder.cleanup)
        cls.context = pathlib.Path(folder.name) / "context"
        cls.context.mkdir()
        copy_context(
            REPOSITORY, cls.context,
            DockerIgnore((REPOSITORY / ".dockerignore").read_text()))

    def configure(self):
        return subprocess.run(["cmake", "--preset", "release"],
                              cwd=self.context, text=True, check=False,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    def top_folders(self):
        cmake = (REPOSITORY / "CMakeLists.txt").read_text()
        return re.findall(r"^\s*add_subdirectory\((\w+)\)", cmake, re.M)

    def test_cmake_configures_what_docker_gets_and_nothing_less(self):
        self.addCleanup(shutil.rmtree, self.context / "build")
        result = self.configure()
        self.assertEqual(result.returncode, 0, result.stdout[-4000:])
        # In the same build folder, where compilers are known: quickly.
        folder = self.top_folders()[0]
        (self.context / folder).rename(self.context.parent / folder)
        result = self.configure()
        (self.context.parent / folder).rename(self.context / folder)
        self.assertNotEqual(result.returncode, 0)
        self.assertIn(folder, result.stdout)

    def test_every_top_folder_and_every_copied_file_is_there(self):
        self.assertIn("server", self.top_folders())
        for folder in self.top_folders():
            self.assertTrue((self.context / folder / "CMakeLists.txt").is_file(),
                            f"{folder} is left out by .dockerignore")
        dockerfile = (REPOSITORY / "Dockerfile").read_text()
        copies = re.findall(r"^COPY (?!--)(.+) \S+$", dockerfile, re.M)
        self.assertTrue(copies)
        for source in " ".join(copies).split():
            self.assertTrue((self.context / source).exists(),
                            f"{source} is left out by .dockerignore")

    def test_nothing_that_was_built_is_sent(self):
        self.assertFalse((self.context / "build").exists())
        self.assertFalse((self.context / ".git").exists())


if __name__ == "__main__":
    unittest.main()
