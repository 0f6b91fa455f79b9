"""Programs that stand in for real ones while a script is tested."""

import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]


class ScriptTest(unittest.TestCase):
    """A copy of scripts/ in an empty tree, and a folder of stubs for PATH."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name, "tree")
        self.stubs = pathlib.Path(folder.name, "stubs")
        self.stubs.mkdir()
        shutil.copytree(REPOSITORY / "scripts", self.root / "scripts")

    def write_program(self, path, text):
        path = pathlib.Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        path.chmod(0o755)

    def stub(self, name, text):
        self.write_program(self.stubs / name, text)

    def environment(self, **variables):
        path = f"{self.stubs}{os.pathsep}{os.environ['PATH']}"
        return {**os.environ, "PATH": path, **variables}

    def run_script(self, *arguments, cwd=None, **variables):
        return subprocess.run(
            [str(self.root / "scripts" / arguments[0]), *arguments[1:]],
            cwd=cwd or self.root, env=self.environment(**variables),
            stdin=subprocess.DEVNULL, capture_output=True, text=True,
            check=False, timeout=60)
