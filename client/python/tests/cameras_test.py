"""Intrinsics of other systems."""

import math
import unittest

import numpy as np

from treeline import cameras, geometry
from treeline.cameras import Camera

K = [[525.5, 0, 320.25], [0, 526.5, 240.75], [0, 0, 1]]


class Cameras(unittest.TestCase):

    def test_what_is_no_camera_is_refused(self):
        for model, width, parameters, why in (
                ("PIN", 640, (1, 1, 1, 1), "no model 'PIN'"),
                ("PINHOLE", 640, (1, 1, 1), "fx, fy, cx, cy; 3 are given"),
                ("PINHOLE", 0, (1, 1, 1, 1), "size of 0"),
                ("PINHOLE", 16385, (1, 1, 1, 1), "size of 16385"),
                ("PINHOLE", 640, (1, math.nan, 1, 1), "not finite"),
                ("PINHOLE", 640, (1, 0, 1, 1), "not positive")):
            with self.assertRaisesRegex(ValueError, why):
                Camera(model, width, 480, parameters)

    def test_parameters_have_names(self):
        camera = Camera("RADIAL", 640, 480, (500, 320, 240, 0.1, 0.2))
        self.assertEqual(camera["k2"], 0.2)
        self.assertEqual(camera.focal_lengths_px, (500, 500))
        np.testing.assert_array_equal(
            camera.matrix, [[500, 0, 320], [0, 500, 240], [0, 0, 1]])
        with self.assertRaisesRegex(KeyError, "RADIAL has no parameter 'p1'"):
            camera["p1"]

    def test_projects_as_a_pinhole(self):
        camera = cameras.pinhole(500, 400, 320, 240, 640, 480)
        np.testing.assert_allclose(
            camera.project([[0, 0, 2], [1, -1, 2]]), [[320, 240], [570, 40]])
        self.assertTrue(np.isnan(camera.project([[0, 0, -1]])).all())

    def test_projects_with_distortion(self):
        # By hand, x = 0.2, y = 0.1, r2 = 0.05: radial 1 + 0.1 * 0.05 + 0.02 *
        # 0.0025 = 1.00505; tangential x: 2 * 0.01 * 0.02 + 0.02 * (0.05 + 0.08)
        # = 0.003; y: 0.01 * (0.05 + 0.02) + 2 * 0.02 * 0.02 = 0.0015.
        camera = Camera("OPENCV", 640, 480,
                        (100, 100, 0, 0, 0.1, 0.02, 0.01, 0.02))
        np.testing.assert_allclose(camera.project([[0.4, 0.2, 2]]),
                                   [[20.401, 10.2005]])
        full = Camera("FULL_OPENCV", 640, 480,
                      (100, 100, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0))
        np.testing.assert_allclose(full.project([[0.4, 0.2, 2]]),
                                   [[20 / 1.05, 10 / 1.05]])
        fisheye = Camera("FOV", 640, 480, (100, 100, 0, 0, 0.5))
        with self.assertRaisesRegex(ValueError, "FOV"):
            fisheye.project([[0, 0, 1]])

    def test_scaling_keeps_the_corners_of_the_image(self):
        camera = cameras.from_opencv(K, None, 640, 480).scaled(320, 240)
        # The left border is at -0.5 in both; so many focal lengths off centre.
        self.assertAlmostEqual((camera["cx"] + 0.5) / camera["fx"],
                               (320.25 + 0.5) / 525.5)
        self.assertAlmostEqual(camera["fy"], 263.25)
        with self.assertRaisesRegex(ValueError, "one focal length"):
            Camera("SIMPLE_PINHOLE", 640, 480, (1, 2, 3)).scaled(320, 480)


class OpenCv(unittest.TestCase):

    def test_keeps_the_principal_point(self):
        self.assertEqual(cameras.from_opencv(K, None, 640, 480),
                         Camera("PINHOLE", 640, 480,
                                (525.5, 526.5, 320.25, 240.75)))

    def test_takes_the_model_that_the_coefficients_need(self):
        focals = (525.5, 526.5, 320.25, 240.75)
        for d, model, expected in (
                (np.zeros(5), "PINHOLE", ()),
                ([1, 2, 3, 4], "OPENCV", (1, 2, 3, 4)),
                ([[1, 2, 3, 4, 0]], "OPENCV", (1, 2, 3, 4)),
                ([1, 2, 3, 4, 5], "FULL_OPENCV", (1, 2, 3, 4, 5, 0, 0, 0)),
                (range(1, 9), "FULL_OPENCV", tuple(range(1, 9))),
                ([*range(1, 9), 0, 0, 0, 0], "FULL_OPENCV",
                 tuple(range(1, 9)))):
            self.assertEqual(cameras.from_opencv(K, d, 640, 480),
                             Camera(model, 640, 480, (*focals, *expected)))
        self.assertEqual(
            cameras.from_opencv_fisheye(K, [1, 2, 3, 4], 640, 480),
            Camera("OPENCV_FISHEYE", 640, 480, (*focals, 1, 2, 3, 4)))

    def test_refuses_what_no_model_has(self):
        with self.assertRaisesRegex(ValueError, "thin prism"):
            cameras.from_opencv(K, [0] * 11 + [1], 640, 480)
        with self.assertRaisesRegex(ValueError, "not 3"):
            cameras.from_opencv(K, [1, 2, 3], 640, 480)
        with self.assertRaisesRegex(ValueError, "transposed"):
            cameras.from_opencv(np.transpose(K), None, 640, 480)


class Others(unittest.TestCase):

    def test_colmap_has_pixel_centres_at_halves(self):
        camera = cameras.from_colmap_line(
            "1 SIMPLE_RADIAL 3072 2304 2559.68 1536 1152 -0.0204997\n")
        self.assertEqual(camera, Camera("SIMPLE_RADIAL", 3072, 2304,
                                        (2559.68, 1535.5, 1151.5, -0.0204997)))
        self.assertEqual(cameras.to_colmap(camera),
                         ("SIMPLE_RADIAL", 3072, 2304,
                          (2559.68, 1536, 1152, -0.0204997)))
        with self.assertRaisesRegex(ValueError, "cameras.txt"):
            cameras.from_colmap_line("# a comment")

    def test_apple_and_arcore_measure_from_the_corner(self):
        expected = Camera("PINHOLE", 640, 480, (525.5, 526.5, 319.75, 240.25))
        self.assertEqual(cameras.from_arkit(K, 640, 480), expected)
        self.assertEqual(cameras.from_arcore((525.5, 526.5), (320.25, 240.75),
                                             (640, 480)), expected)

    def test_record3d_writes_columns_and_opengl_poses(self):
        metadata = {"K": list(np.ravel(np.transpose(K))), "w": 640, "h": 480,
                    "poses": [[0, 0, 0, 1, 1, 2, 3], [1, 0, 0, 0, 4, 5, 6]]}
        self.assertEqual(cameras.from_record3d(metadata),
                         cameras.from_arkit(K, 640, 480))
        poses = cameras.record3d_poses(metadata)
        self.assertEqual(poses.shape, (2, 4, 4))
        np.testing.assert_allclose(poses[0], geometry.pose(
            np.diag([1, -1, -1]), [1, 2, 3]))
        # Half a turn about x is what lies between the axes.
        np.testing.assert_allclose(poses[1], geometry.pose(
            [1, 0, 0, 0], [4, 5, 6]), atol=1e-15)

    def test_nerf_has_colmaps_pixels_and_opengl_poses(self):
        transforms = {"fl_x": 500, "cx": 320, "cy": 240, "w": 640, "h": 480,
                      "k1": 0.1, "frames": [
                          {"transform_matrix": np.eye(4).tolist()}]}
        self.assertEqual(cameras.from_nerf(transforms), Camera(
            "OPENCV", 640, 480, (500, 500, 319.5, 239.5, 0.1, 0, 0, 0)))
        np.testing.assert_array_equal(cameras.nerf_poses(transforms),
                                      [np.diag([1, -1, -1, 1])])
        fisheye = {**transforms, "camera_model": "OPENCV_FISHEYE", "k4": 0.4}
        self.assertEqual(cameras.from_nerf(fisheye), Camera(
            "OPENCV_FISHEYE", 640, 480, (500, 500, 319.5, 239.5, 0.1, 0, 0,
                                         0.4)))
        with self.assertRaisesRegex(ValueError, "has no fl_x, h"):
            cameras.from_nerf({"cx": 1, "cy": 1, "w": 1})


if __name__ == "__main__":
    unittest.main()
