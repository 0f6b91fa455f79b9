"""Poses, quaternions and axes."""

import math
import unittest

import numpy as np

from treeline import geometry


def random_poses(count):
    random = np.random.default_rng(20261124)
    for _ in range(count):
        q = random.normal(size=4)
        yield geometry.pose(q / np.linalg.norm(q), random.normal(size=3))


class Poses(unittest.TestCase):

    def test_the_inverse_undoes_a_pose(self):
        for pose in random_poses(50):
            np.testing.assert_allclose(
                geometry.compose(pose, geometry.inverse(pose)), np.eye(4),
                atol=1e-14)

    def test_compose_multiplies_in_order(self):
        a, b, c = random_poses(3)
        np.testing.assert_array_equal(geometry.compose(a, b, c), a @ b @ c)
        np.testing.assert_array_equal(geometry.compose(), np.eye(4))

    def test_transform_takes_one_point_and_many(self):
        turn_left = geometry.pose([[0, -1, 0], [1, 0, 0], [0, 0, 1]], [1, 2, 3])
        np.testing.assert_allclose(geometry.transform(turn_left, [1, 0, 0]),
                                   [1, 3, 3])
        np.testing.assert_allclose(
            geometry.transform(turn_left, [[0, 0, 0], [0, 1, 0]]),
            [[1, 2, 3], [0, 2, 3]])
        with self.assertRaisesRegex(ValueError, "N x 3"):
            geometry.transform(turn_left, [1, 2])

    def test_what_is_no_pose_is_refused_by_its_name(self):
        mirrored = np.diag([1, 1, -1, 1])
        scaled = np.diag([2, 2, 2, 1])
        bottom = np.eye(4)
        bottom[3, 0] = 1
        nan = np.full((4, 4), np.nan)
        for wrong in (mirrored, scaled, bottom, nan, np.eye(3)):
            with self.assertRaisesRegex(ValueError, "^the prior: "):
                geometry.check_pose(wrong, "the prior")

    def test_constants_cannot_be_changed(self):
        with self.assertRaises(ValueError):
            geometry.CAMERA_FROM_OPENGL[0, 0] = 2


class Quaternions(unittest.TestCase):

    def test_go_to_matrices_and_back(self):
        random = np.random.default_rng(1)
        # Near half turns about each axis too, where each of the four formulas
        # is needed.
        special = [[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [1, 0, 0, 0],
                   [1e-9, 1, 1e-9, 0], [1e-9, 0, 0, 1]]
        for q in [*special, *random.normal(size=(100, 4))]:
            q = np.array(q) / np.linalg.norm(q)
            back = geometry.quaternion_from_matrix(
                geometry.matrix_from_quaternion(q))
            np.testing.assert_allclose(back, -q if q[0] < 0 else q, atol=1e-14)
            self.assertGreaterEqual(back[0], 0)

    def test_a_quarter_turn_about_z_takes_x_to_y(self):
        half = math.sqrt(0.5)
        matrix = geometry.matrix_from_quaternion([half, 0, 0, half])
        np.testing.assert_allclose(matrix @ [1, 0, 0], [0, 1, 0], atol=1e-15)

    def test_products_are_those_of_matrices(self):
        a, b = (geometry.quaternion_from_matrix(p) for p in random_poses(2))
        np.testing.assert_allclose(
            geometry.matrix_from_quaternion(
                geometry.multiply_quaternions(a, b)),
            geometry.matrix_from_quaternion(a) @
            geometry.matrix_from_quaternion(b), atol=1e-14)

    def test_unit_to_rounding_stays_bit_for_bit(self):
        q = np.array([0.6514121155060778, -0.75854369050178,
                      -0.0012354997405219375, 0.016498451813040816])
        np.testing.assert_array_equal(geometry.unit_quaternion(q), q)
        np.testing.assert_allclose(
            np.linalg.norm(geometry.unit_quaternion(1.005 * q)), 1, rtol=1e-15)
        with self.assertRaisesRegex(ValueError, "norm 2"):
            geometry.unit_quaternion([2, 0, 0, 0])

    def test_angles_are_from_0_to_half_a_turn(self):
        turn = geometry.matrix_from_quaternion([math.cos(0.6), 0,
                                                math.sin(0.6), 0])
        self.assertAlmostEqual(geometry.angle_rad(np.eye(3), turn), 1.2)
        self.assertAlmostEqual(geometry.angle_rad(turn, np.eye(4)), 1.2)
        half = np.diag([1.0, -1, -1])
        self.assertAlmostEqual(geometry.angle_rad(np.eye(3), half), math.pi)


class Axes(unittest.TestCase):

    def test_opengl_has_y_up_and_looks_backwards(self):
        pose = geometry.camera_from_opengl_pose(np.eye(4))
        # Forward and down of the camera, in OpenGL's axes.
        np.testing.assert_array_equal(pose[:3, :3] @ [0, 0, 1], [0, 0, -1])
        np.testing.assert_array_equal(pose[:3, :3] @ [0, 1, 0], [0, -1, 0])
        for one in random_poses(5):
            np.testing.assert_allclose(geometry.opengl_pose_from_camera(
                geometry.camera_from_opengl_pose(one)), one)

    def test_a_body_of_rep_103_has_x_forward_and_z_up(self):
        rotation = geometry.BODY_FROM_CAMERA[:3, :3]
        np.testing.assert_array_equal(rotation @ [0, 0, 1], [1, 0, 0])
        np.testing.assert_array_equal(rotation @ [1, 0, 0], [0, -1, 0])
        np.testing.assert_array_equal(rotation @ [0, 1, 0], [0, 0, -1])
        for one in random_poses(5):
            body = geometry.body_pose_from_camera(one)
            np.testing.assert_array_equal(body[:3, 3], one[:3, 3])
            np.testing.assert_allclose(geometry.camera_pose_from_body(body),
                                       one)

    def test_ros_orders_quaternions_with_w_last(self):
        pose = geometry.pose([1, 0, 0, 0], [1, 2, 3])
        position, orientation = geometry.ros_pose(pose)
        np.testing.assert_array_equal(position, [1, 2, 3])
        np.testing.assert_array_equal(orientation, [0, 0, 0, 1])

    def test_gravity_of_a_level_camera_is_downwards(self):
        level = geometry.camera_from_opengl_pose(np.eye(4))
        np.testing.assert_allclose(geometry.gravity_in_camera(level),
                                   [0, 9.80665, 0], atol=1e-15)
        z_up = geometry.camera_pose_from_body(np.eye(4))
        np.testing.assert_allclose(
            geometry.gravity_in_camera(z_up, (0, 0, 2)), [0, 9.80665, 0],
            atol=1e-15)
        with self.assertRaisesRegex(ValueError, "up_in_world"):
            geometry.gravity_in_camera(level, (0, 0, 0))


if __name__ == "__main__":
    unittest.main()
