"""docs/frames.md: its pictures are those of scripts/draw-frames, its matrices
those of the clients, and the functions that it names are there."""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import numpy as np

from treeline import geodesy, geometry

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "frames.md").read_text()
TYPESCRIPT = ROOT / "client" / "typescript" / "src" / "camera"


def matrices():
    """other_from_camera of each row of the table, by its first words."""
    table = PAGE.partition("`other_from_camera`, row by row")[2]
    found = {}
    for name, _, cell in re.findall(r"^\| (.+?) \| (.+?) \| (.+?) \|$",
                                    table.partition("```")[0], re.M):
        if name.startswith("-"):
            continue
        rows = re.findall(r"`([-\d ]+)`", cell)
        found[name.split(",")[0].split(":")[0]] = (
            np.array([[float(n) for n in row.split()] for row in rows])
            if rows else np.eye(3))
    return found


class Frames(unittest.TestCase):

    def test_pictures_are_those_that_are_drawn(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([sys.executable, "-B",
                            ROOT / "scripts" / "draw-frames", folder],
                           check=True)
            for name in ("axes.svg", "pixels.svg"):
                self.assertEqual(
                    (pathlib.Path(folder) / name).read_text(),
                    (ROOT / "docs" / "pictures" / name).read_text(),
                    f"{name}: run scripts/draw-frames")
                self.assertIn(f"(pictures/{name})", PAGE)

    def test_matrices_are_those_of_the_client(self):
        found = matrices()
        self.assertEqual(list(found), ["OpenCV", "ARKit", "base of a robot",
                                       "GeoPose Protocol"])
        rng = np.random.default_rng(3)
        quaternion = rng.normal(size=4)
        quaternion /= np.linalg.norm(quaternion)
        camera = geometry.pose(quaternion, rng.normal(size=3))
        # world_from_camera = world_from_other * other_from_camera
        for name, client in (
                ("ARKit", geometry.opengl_pose_from_camera(camera)),
                ("base of a robot", geometry.body_pose_from_camera(camera))):
            np.testing.assert_allclose(client[:3, :3] @ found[name],
                                       camera[:3, :3], atol=1e-12)
        # At the equator and the meridian, with a world that is East-North-Up.
        upright = geometry.pose(quaternion, np.zeros(3))
        device = geometry.matrix_from_quaternion(geodesy.geo_pose(
            upright, geodesy.GeoAnchor(0, 0, 0)).enu_from_device_wxyz)
        np.testing.assert_allclose(device @ found["GeoPose Protocol"],
                                   upright[:3, :3], atol=1e-12)
        for matrix in found.values():
            self.assertAlmostEqual(np.linalg.det(matrix), 1)

    def test_the_functions_are_there(self):
        sources = "".join(path.read_text() for path in TYPESCRIPT.glob("*.ts"))
        named = set(re.findall(r"`(\w+Of\w+)`", PAGE))
        self.assertGreaterEqual(len(named), 5)
        for name in named:
            self.assertRegex(sources, rf"export (const|function) {name}\b")
        for name in re.findall(r"`geometry\.(\w+)`", PAGE):
            self.assertTrue(hasattr(geometry, name), name)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
