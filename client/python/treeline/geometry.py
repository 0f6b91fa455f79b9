"""Poses, rotations and changes of axes, with numpy.

A transform is called <target>_from_<source>. It is a 4x4 float64 matrix that
maps points of the source frame into the target frame (metres):

    point_in_target = target_from_source @ [x, y, z, 1]

A quaternion is an array of 4: w, x, y, z (Hamilton's convention, unit, and
w >= 0 where this module makes it). ROS orders x, y, z, w: see ros_pose().

Frames: `camera` has x right, y down, z forward (docs/frames.md of Treeline).
`opengl` is the same camera with x right, y up, z backwards: that of OpenGL,
WebXR, ARKit, ARCore, Record3D, NeRF. `body` has x forward, y left, z up: that
of REP-103 for robots.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array: TypeAlias = NDArray[np.float64]

# How far a matrix may be from a rotation, and a quaternion from norm 1.
_MAX_ROTATION_ERROR = 1e-3
_MAX_NORM_ERROR = 1e-2

# A dozen rounding errors of a norm near 1.
_UNIT_TO_ROUNDING = 4e-15

CAMERA_FROM_OPENGL: Array = np.diag([1.0, -1.0, -1.0, 1.0])
"""Its own inverse."""

BODY_FROM_CAMERA: Array = np.array([[0.0, 0.0, 1.0, 0.0],
                                    [-1.0, 0.0, 0.0, 0.0],
                                    [0.0, -1.0, 0.0, 0.0],
                                    [0.0, 0.0, 0.0, 1.0]])
"""From `camera` (REP-103's suffix _optical) to `body`, at one place."""

for _constant in (CAMERA_FROM_OPENGL, BODY_FROM_CAMERA):
    _constant.setflags(write=False)


def check_pose(target_from_source: ArrayLike, name: str = "pose") -> Array:
    """The pose as a 4x4 float64 array. ValueError, naming `name`, if it is not
    a rigid transform: its rotation may be off by rounding of floats (1e-3),
    but not mirrored or scaled."""
    pose = np.asarray(target_from_source, dtype=np.float64)
    if pose.shape != (4, 4):
        raise ValueError(f"{name}: a 4x4 matrix is expected, not {pose.shape}")
    if not np.isfinite(pose).all():
        raise ValueError(f"{name}: has a NaN or an infinity")
    rotation = pose[:3, :3]
    if (np.abs(rotation @ rotation.T - np.eye(3)).max() > _MAX_ROTATION_ERROR
            or np.linalg.det(rotation) < 0):
        raise ValueError(f"{name}: its 3x3 part is not a rotation (orthonormal,"
                         " determinant 1)")
    if np.abs(pose[3] - [0, 0, 0, 1]).max() > 1e-9:
        raise ValueError(f"{name}: its last row must be 0 0 0 1")
    return pose


def pose(rotation: ArrayLike, translation_m: ArrayLike) -> Array:
    """The 4x4 pose of a rotation and a translation (3, metres, in the target
    frame). The rotation is a 3x3 matrix, or a quaternion w, x, y, z."""
    rotation = np.asarray(rotation, dtype=np.float64)
    result = np.eye(4)
    result[:3, :3] = (rotation if rotation.shape == (3, 3) else
                      matrix_from_quaternion(rotation))
    result[:3, 3] = np.asarray(translation_m, dtype=np.float64).reshape(3)
    return check_pose(result)


def inverse(target_from_source: ArrayLike) -> Array:
    """source_from_target, 4x4."""
    given = check_pose(target_from_source)
    result = np.eye(4)
    result[:3, :3] = given[:3, :3].T
    result[:3, 3] = -given[:3, :3].T @ given[:3, 3]
    return result


def compose(*poses: ArrayLike) -> Array:
    """a_from_b, b_from_c, ... multiplied in their order: a_from_z, 4x4.
    Without poses: the identity."""
    result = np.eye(4)
    for one in poses:
        result = result @ check_pose(one)
    return result


def transform(target_from_source: ArrayLike, points: ArrayLike) -> Array:
    """Points of the source frame (N x 3 or 3, metres) in the target frame."""
    given = check_pose(target_from_source)
    points = np.asarray(points, dtype=np.float64)
    if points.shape[-1:] != (3,):
        raise ValueError(f"points: N x 3 is expected, not {points.shape}")
    return points @ given[:3, :3].T + given[:3, 3]


def unit_quaternion(wxyz: ArrayLike) -> Array:
    """The quaternion w, x, y, z, normalised if its norm is within 0.01 of 1;
    ValueError otherwise. One that is unit to rounding stays as it is, bit for
    bit."""
    q = np.asarray(wxyz, dtype=np.float64)
    if q.shape != (4,):
        raise ValueError(f"a quaternion has 4 numbers (w, x, y, z), not"
                         f" {q.shape}")
    norm = float(np.sqrt(q @ q))
    if not abs(norm - 1) <= _MAX_NORM_ERROR:
        raise ValueError(f"a quaternion of norm {norm:g}; it must be 1")
    return q if abs(norm - 1) <= _UNIT_TO_ROUNDING else q / norm


def matrix_from_quaternion(wxyz: ArrayLike) -> Array:
    """The 3x3 rotation of unit_quaternion(wxyz)."""
    q = unit_quaternion(wxyz)
    w, x, y, z = q
    return np.array(
        [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
         [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
         [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def quaternion_from_matrix(rotation: ArrayLike) -> Array:
    """The quaternion w, x, y, z (w >= 0) of a 3x3 rotation, or of the rotation
    of a 4x4 pose. Of the four equal formulas (Shepperd's) the one that divides
    by the largest number."""
    a = np.asarray(rotation, dtype=np.float64)
    if a.shape == (4, 4):
        a = a[:3, :3]
    if a.shape != (3, 3):
        raise ValueError(f"a 3x3 rotation is expected, not {a.shape}")
    trace = np.trace(a)
    diagonal = [trace, a[0, 0], a[1, 1], a[2, 2]]
    largest = int(np.argmax(diagonal))
    if largest == 0:
        q = np.array([1 + trace, a[2, 1] - a[1, 2], a[0, 2] - a[2, 0],
                      a[1, 0] - a[0, 1]])
    else:
        i = largest - 1
        j, k = (i + 1) % 3, (i + 2) % 3
        q = np.empty(4)
        q[0] = a[k, j] - a[j, k]
        q[1 + i] = 1 + 2 * a[i, i] - trace
        q[1 + j] = a[i, j] + a[j, i]
        q[1 + k] = a[i, k] + a[k, i]
    q /= np.linalg.norm(q)
    return -q if q[0] < 0 else q


def multiply_quaternions(a_from_b: ArrayLike, b_from_c: ArrayLike) -> Array:
    """a_from_c of two quaternions w, x, y, z."""
    aw, ax, ay, az = np.asarray(a_from_b, dtype=np.float64)
    bw, bx, by, bz = np.asarray(b_from_c, dtype=np.float64)
    return np.array([aw * bw - ax * bx - ay * by - az * bz,
                     aw * bx + ax * bw + ay * bz - az * by,
                     aw * by - ax * bz + ay * bw + az * bx,
                     aw * bz + ax * by - ay * bx + az * bw])


def angle_rad(a: ArrayLike, b: ArrayLike) -> float:
    """The angle of the rotation that takes one pose or rotation (4x4 or 3x3)
    to the other, 0 to pi."""
    of = [np.asarray(m, dtype=np.float64)[:3, :3] for m in (a, b)]
    q = quaternion_from_matrix(of[0].T @ of[1])
    return 2 * float(np.arctan2(np.linalg.norm(q[1:]), q[0]))


def distance_m(a: ArrayLike, b: ArrayLike) -> float:
    """Between the origins of two poses (4x4) in one target frame."""
    return float(np.linalg.norm(np.asarray(a, dtype=np.float64)[:3, 3] -
                                np.asarray(b, dtype=np.float64)[:3, 3]))


def camera_from_opengl_pose(world_from_opengl: ArrayLike) -> Array:
    """world_from_camera of a pose whose camera has OpenGL's axes (x right, y
    up, z backwards): what ARKit, ARCore, WebXR, Record3D and NeRF give."""
    return check_pose(world_from_opengl) @ CAMERA_FROM_OPENGL


def opengl_pose_from_camera(world_from_camera: ArrayLike) -> Array:
    """The inverse of camera_from_opengl_pose(): to draw where an answer is."""
    return check_pose(world_from_camera) @ CAMERA_FROM_OPENGL


def body_pose_from_camera(world_from_camera: ArrayLike) -> Array:
    """world_from_body: the same place, with REP-103's axes of a body (x forward
    along the optical axis, y left, z up)."""
    return check_pose(world_from_camera) @ BODY_FROM_CAMERA.T


def camera_pose_from_body(world_from_body: ArrayLike) -> Array:
    """The inverse of body_pose_from_camera()."""
    return check_pose(world_from_body) @ BODY_FROM_CAMERA


def ros_pose(target_from_source: ArrayLike) -> tuple[Array, Array]:
    """position (x, y, z, metres) and orientation (x, y, z, w), as
    geometry_msgs/Pose orders them. An answer's covariance has the order and the
    meaning of PoseWithCovariance already."""
    given = check_pose(target_from_source)
    w, x, y, z = quaternion_from_matrix(given)
    return given[:3, 3].copy(), np.array([x, y, z, w])


def gravity_in_camera(world_from_camera: ArrayLike,
                      up_in_world: ArrayLike = (0, 1, 0)) -> Array:
    """Where things fall (3, metres per second squared) in the camera's frame,
    for Query.gravity_in_camera_mps2, from the pose that an AR system tracks.
    Its world has y up (ARKit with .gravity, ARCore, WebXR) unless `up_in_world`
    says otherwise."""
    up = np.asarray(up_in_world, dtype=np.float64)
    norm = np.linalg.norm(up)
    if up.shape != (3,) or not norm > 0:
        raise ValueError("up_in_world: a direction of 3 numbers is expected")
    rotation = check_pose(world_from_camera)[:3, :3]
    return rotation.T @ (up * (-9.80665 / norm))
