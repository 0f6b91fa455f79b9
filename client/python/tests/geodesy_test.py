"""WGS84 and GeoPose."""

import unittest

import numpy as np

from treeline import geodesy, geometry
from treeline.geodesy import GeoAnchor

# A camera that is level and looks along y, the picture's top at z.
LOOKS_ALONG_Y = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


class Geodesy(unittest.TestCase):

    def test_knows_the_axes_of_the_ellipsoid(self):
        for position, point in (((0, 0, 0), (6378137.0, 0, 0)),
                                ((0, 90, 0), (0, 6378137.0, 0)),
                                ((-90, 0, 10), (0, 0, -6356762.314245))):
            np.testing.assert_allclose(geodesy.ecef_from_geodetic(*position),
                                       point, atol=1e-6)

    def test_comes_back_from_ecef_within_a_micrometre(self):
        random = np.random.default_rng(7)
        for _ in range(500):
            position = (random.uniform(-90, 90), random.uniform(-180, 180),
                        random.uniform(-11000, 50000))
            point = geodesy.ecef_from_geodetic(*position)
            back = geodesy.geodetic_from_ecef(point)
            self.assertLess(np.linalg.norm(
                geodesy.ecef_from_geodetic(*back) - point), 1e-6)
            self.assertAlmostEqual(back[2], position[2], delta=1e-6)

    def test_a_level_camera_that_looks_north_has_the_identity(self):
        pose = geodesy.geo_pose(geometry.pose(LOOKS_ALONG_Y, [0, 0, 0]),
                                GeoAnchor(48, 11, 520))
        np.testing.assert_allclose(
            [pose.latitude_deg, pose.longitude_deg, pose.height_m],
            [48, 11, 520], atol=1e-9)
        np.testing.assert_allclose(pose.enu_from_device_wxyz, [1, 0, 0, 0],
                                   atol=1e-12)
        self.assertEqual(sorted(pose.as_json()), ["position", "quaternion"])
        self.assertEqual(pose.as_json()["position"]["lat"], pose.latitude_deg)
        self.assertEqual(pose.as_json()["quaternion"]["w"],
                         pose.enu_from_device_wxyz[0])

    def test_angles_turn_about_up_then_forward_then_right(self):
        for angles in ((0, 0, 0), (90, 0, 0), (0, 30, 0), (0, 0, -40),
                       (-130, 55, 170)):
            said = self.pose_of(*angles).as_ypr_json()
            self.assertEqual(sorted(said), ["angles", "position"])
            np.testing.assert_allclose(
                [said["angles"][name] for name in ("yaw", "pitch", "roll")],
                angles, atol=1e-9)

    def test_a_picture_whose_right_side_is_straight_up_keeps_its_pose(self):
        # A phone on its side, whose pictures are not turned.
        for pitch in (90, -90):
            for yaw, roll in ((20, 0), (20, 70), (-150, 100)):
                pose = self.pose_of(yaw, pitch, roll)
                angles = pose.as_ypr_json()["angles"]
                self.assertEqual(angles["roll"], 0)
                self.assertLessEqual(abs(angles["yaw"]), 180)
                again = self.pose_of(**angles)
                self.assertGreater(abs(np.dot(again.enu_from_device_wxyz,
                                              pose.enu_from_device_wxyz)),
                                   1 - 1e-12)

    @staticmethod
    def pose_of(yaw, pitch, roll):
        def about(axis, angle_deg):
            cosine, sine = (f(np.radians(angle_deg)) for f in (np.cos, np.sin))
            matrix = np.eye(3)
            i, j = (axis + 1) % 3, (axis + 2) % 3
            matrix[i, i] = matrix[j, j] = cosine
            matrix[i, j], matrix[j, i] = -sine, sine
            return matrix

        return geodesy.GeoPose(48, 11, 520, tuple(
            geometry.quaternion_from_matrix(
                about(2, yaw) @ about(1, pitch) @ about(0, roll))))

    def test_the_anchors_rotation_turns_the_world(self):
        # World x is north, so a camera that looks along world x looks north.
        half = np.sqrt(0.5)
        anchor = GeoAnchor(0, 0, 0, (half, 0, 0, half))
        looks_along_x = np.array([[0.0, 0, 1], [-1, 0, 0], [0, -1, 0]])
        pose = geodesy.geo_pose(geometry.pose(looks_along_x, [100, 0, 5]),
                                anchor)
        # A degree of latitude at the equator is 110574 m.
        self.assertAlmostEqual(pose.latitude_deg, 100 / 110574, delta=1e-8)
        # 5 m, and what the tangent leaves the ellipsoid by in 100 m.
        self.assertAlmostEqual(pose.height_m, 5, delta=1e-3)
        self.assertGreater(pose.enu_from_device_wxyz[0], 1 - 1e-9)

    def test_an_anchor_outside_the_earth_is_refused(self):
        for wrong in ((91, 0, 0), (0, 181, 0), (0, 0, float("nan"))):
            with self.assertRaises(ValueError):
                GeoAnchor(*wrong)

    def test_accuracy_is_the_longest_half_axis(self):
        covariance = np.diag([1e-4, 4e-4, 1e-4, 1e-6, 1e-6, 9e-6])
        position_m, orientation_deg = geodesy.accuracy(covariance)
        self.assertAlmostEqual(position_m, 0.02 * 2.7955, delta=1e-5)
        self.assertAlmostEqual(orientation_deg,
                               np.degrees(0.003 * 2.7955), delta=1e-4)
        with self.assertRaisesRegex(ValueError, "6x6"):
            geodesy.accuracy(np.eye(5))
        with self.assertRaisesRegex(ValueError, "negative"):
            geodesy.accuracy(-np.eye(6))


if __name__ == "__main__":
    unittest.main()
