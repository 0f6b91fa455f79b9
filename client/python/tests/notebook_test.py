"""The cells of the example notebook, run as they are.

    notebook_test.py PROGRAMS SCENE PACKAGE
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from PIL import Image
from real_server import RealServer, put_scene

PROGRAMS, SCENE, PACKAGE = (pathlib.Path(a).resolve() for a in sys.argv[1:4])
EXAMPLES = pathlib.Path(__file__).resolve().parents[1] / "examples"


class Notebook(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        put_scene(self.folder / "models", SCENE / "room.treeline")
        self.server = RealServer(PROGRAMS / "treeline-server",
                                 self.folder / "models")
        self.addCleanup(self.server.stop)

    def test_localizes_and_draws(self):
        done = subprocess.run(
            [sys.executable, "-B", EXAMPLES / "run_notebook.py",
             EXAMPLES / "localize.ipynb"], cwd=self.folder, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
            env={**os.environ, "PYTHONPATH": str(PACKAGE / "lib"),
                 "TREELINE_SERVER": self.server.address,
                 "TREELINE_RECORDING": str(SCENE / "recording")})
        self.assertEqual(done.returncode, 0, done.stdout)
        frames = len((SCENE / "recording" / "test.txt").read_text().split())
        lines = done.stdout.splitlines()
        self.assertEqual(lines[0], f"{frames} frames of (480, 640, 3)")
        localized = [line for line in lines if "confidence" in line]
        self.assertGreaterEqual(len(localized), frames // 2, done.stdout)
        for name, size in (("track.png", (800, 500)),
                           ("inliers.png", (800, 600))):
            picture = Image.open(self.folder / name)
            self.assertEqual(picture.size, size)
            # Not one colour: something is drawn in it.
            self.assertGreater(np.asarray(picture.convert("L")).std(), 10)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
