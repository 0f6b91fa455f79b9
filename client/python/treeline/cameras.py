"""Intrinsics of cameras, and how other systems write them.

Treeline has COLMAP's models and parameter order, but **the centre of the top
left pixel is (0, 0)**. COLMAP, Apple and NeRF put the corner of that pixel at
(0, 0), and its centre at (0.5, 0.5): their cx and cy are half a pixel larger.
OpenCV has the centre at (0, 0), as Treeline has. The functions here convert.

Poses of ARKit, ARCore, Record3D and NeRF have OpenGL's axes:
treeline.geometry.camera_from_opengl_pose() converts them.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from treeline import geometry
from treeline.geometry import Array

# The names of each model's parameters, in their order. Focal lengths and
# principal point in pixels; omega in radians; the rest has no unit.
PARAMETERS: Mapping[str, tuple[str, ...]] = {
    model: tuple(names.split()) for model, names in {
        "SIMPLE_PINHOLE": "f cx cy",
        "PINHOLE": "fx fy cx cy",
        "SIMPLE_RADIAL": "f cx cy k",
        "RADIAL": "f cx cy k1 k2",
        "OPENCV": "fx fy cx cy k1 k2 p1 p2",
        "FULL_OPENCV": "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6",
        "OPENCV_FISHEYE": "fx fy cx cy k1 k2 k3 k4",
        "FOV": "fx fy cx cy omega",
        "SIMPLE_RADIAL_FISHEYE": "f cx cy k",
        "RADIAL_FISHEYE": "f cx cy k1 k2",
        "THIN_PRISM_FISHEYE": "fx fy cx cy k1 k2 p1 p2 k3 k4 sx1 sy1",
    }.items()}

# Those whose distortion project() computes.
_PROJECTED = ("SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV",
              "FULL_OPENCV")

_MAX_SIZE_PX = 16384


@dataclasses.dataclass(frozen=True)
class Camera:
    """Intrinsics that belong to images of width x height pixels. ValueError:
    an unknown model, a wrong number of parameters, not finite, a focal length
    that is not positive."""

    model: str
    width_px: int
    height_px: int
    parameters: tuple[float, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "parameters",
                           tuple(float(p) for p in self.parameters))
        names = PARAMETERS.get(self.model)
        if names is None:
            raise ValueError(f"camera: no model {self.model!r}; there are "
                             + ", ".join(PARAMETERS))
        for size in (self.width_px, self.height_px):
            if not 1 <= size <= _MAX_SIZE_PX:
                raise ValueError(f"camera: a size of {size} pixels; 1 to"
                                 f" {_MAX_SIZE_PX} is expected")
        if len(self.parameters) != len(names):
            raise ValueError(f"camera: {self.model} has the parameters "
                             f"{', '.join(names)}; {len(self.parameters)} are"
                             " given")
        if not all(math.isfinite(p) for p in self.parameters):
            raise ValueError("camera: a parameter is not finite")
        if not min(self.focal_lengths_px) > 0:
            raise ValueError("camera: a focal length is not positive")

    def __getitem__(self, name: str) -> float:
        """A parameter by its name, as in PARAMETERS; KeyError."""
        names = PARAMETERS[self.model]
        if name not in names:
            raise KeyError(f"{self.model} has no parameter {name!r}")
        return self.parameters[names.index(name)]

    @property
    def focal_lengths_px(self) -> tuple[float, float]:
        """fx, fy."""
        if PARAMETERS[self.model][0] == "f":
            return self.parameters[0], self.parameters[0]
        return self.parameters[0], self.parameters[1]

    @property
    def principal_point_px(self) -> tuple[float, float]:
        """cx, cy; the centre of the top left pixel is (0, 0)."""
        return self["cx"], self["cy"]

    @property
    def matrix(self) -> Array:
        """OpenCV's camera matrix, 3x3, without the distortion."""
        fx, fy = self.focal_lengths_px
        cx, cy = self.principal_point_px
        return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])

    def project(self, points_in_camera_m: ArrayLike) -> Array:
        """Pixels (N x 2) of points (N x 3) in front of the camera, by the
        equations of OpenCV; NaN for those that are not. ValueError for models
        of fisheye lenses and FOV."""
        if self.model not in _PROJECTED:
            raise ValueError(f"project() does not know {self.model}")
        points = np.asarray(points_in_camera_m, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ValueError(f"points: N x 3 is expected, not {points.shape}")
        named = dict(zip(PARAMETERS[self.model], self.parameters))
        k1, k2, p1, p2, k3, k4, k5, k6 = (
            named.get(k, 0.0)
            for k in ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"))
        k1 = named.get("k", k1)
        z = np.where(points[:, 2] > 0, points[:, 2], np.nan)
        x, y = points[:, 0] / z, points[:, 1] / z
        r2 = x * x + y * y
        radial = ((1 + r2 * (k1 + r2 * (k2 + r2 * k3))) /
                  (1 + r2 * (k4 + r2 * (k5 + r2 * k6))))
        fx, fy = self.focal_lengths_px
        cx, cy = self.principal_point_px
        return np.stack(
            [fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cx,
             fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + cy],
            axis=1)

    def scaled(self, width_px: int, height_px: int) -> Camera:
        """Of the same view as an image of another size. Distortion does not
        depend on the size; pixel centres move with the size of the pixels.
        Models with one focal length need the same factor both ways."""
        x, y = width_px / self.width_px, height_px / self.height_px
        if PARAMETERS[self.model][0] == "f" and not math.isclose(
                x, y, rel_tol=1e-3):
            raise ValueError(f"{self.model} has one focal length: width and"
                             " height must be scaled alike")
        factors = {"f": x, "fx": x, "fy": y}
        values = []
        for name, value in zip(PARAMETERS[self.model], self.parameters):
            if name in ("cx", "cy"):
                factor = x if name == "cx" else y
                values.append((value + 0.5) * factor - 0.5)
            else:
                values.append(value * factors.get(name, 1.0))
        return Camera(self.model, width_px, height_px, tuple(values))


def _focals_and_centre(matrix: ArrayLike) -> tuple[float, float, float, float]:
    """fx, fy, cx, cy of a 3x3 camera matrix without skew."""
    k = np.asarray(matrix, dtype=np.float64)
    if k.shape != (3, 3):
        raise ValueError(f"camera matrix: 3x3 is expected, not {k.shape}")
    if k[2, 2] != 1 or k[0, 1] != 0 or np.any(k[2, :2]) or k[1, 0] != 0:
        raise ValueError("camera matrix: [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]"
                         " is expected; is it transposed, or has it skew?")
    return float(k[0, 0]), float(k[1, 1]), float(k[0, 2]), float(k[1, 2])


def pinhole(fx: float, fy: float, cx: float, cy: float, width_px: int,
            height_px: int) -> Camera:
    """A camera without distortion; cx, cy of pixel centres at integers."""
    return Camera("PINHOLE", width_px, height_px, (fx, fy, cx, cy))


def from_opencv(matrix: ArrayLike, distortion: ArrayLike | None,
                width_px: int, height_px: int) -> Camera:
    """What cv2.calibrateCamera gives: the 3x3 camera matrix and 0, 4, 5, 8, 12
    or 14 coefficients (k1 k2 p1 p2 [k3 [k4 k5 k6 [s1..s4 [tx ty]]]]). Thin
    prism and tilt must be zero: no model has them. ROS's plumb_bob (5) and
    rational_polynomial (8) are the same."""
    focals = _focals_and_centre(matrix)
    d = np.zeros(0) if distortion is None else np.ravel(
        np.asarray(distortion, dtype=np.float64))
    if d.size not in (0, 4, 5, 8, 12, 14):
        raise ValueError("distortion: 0, 4, 5, 8, 12 or 14 coefficients are"
                         f" expected, not {d.size}")
    if np.any(d[8:]):
        raise ValueError("distortion: no model has OpenCV's thin prism (s1..s4)"
                         " or tilt")
    d = d[:8]
    if not d.any():
        return Camera("PINHOLE", width_px, height_px, focals)
    if not d[4:].any():
        return Camera("OPENCV", width_px, height_px, (*focals, *d[:4]))
    padded = np.concatenate([d, np.zeros(8 - d.size)])
    return Camera("FULL_OPENCV", width_px, height_px, (*focals, *padded))


def from_opencv_fisheye(matrix: ArrayLike, distortion: ArrayLike,
                        width_px: int, height_px: int) -> Camera:
    """What cv2.fisheye.calibrate gives: 3x3 and k1..k4. ROS's equidistant is
    the same."""
    d = np.ravel(np.asarray(distortion, dtype=np.float64))
    if d.size != 4:
        raise ValueError(f"distortion: k1..k4 are expected, not {d.size}"
                         " coefficients")
    return Camera("OPENCV_FISHEYE", width_px, height_px,
                  (*_focals_and_centre(matrix), *d))


def _moved(camera: Camera, by_px: float) -> Camera:
    """With cx and cy moved by so many pixels."""
    names = PARAMETERS[camera.model]
    return dataclasses.replace(camera, parameters=tuple(
        value + by_px if name in ("cx", "cy") else value
        for name, value in zip(names, camera.parameters)))


def from_colmap(model: str, width_px: int, height_px: int,
                parameters: Sequence[float]) -> Camera:
    """A camera of COLMAP: half a pixel is subtracted from its cx and cy."""
    return _moved(Camera(model, width_px, height_px, tuple(parameters)), -0.5)


def from_colmap_line(line: str) -> Camera:
    """A line of COLMAP's cameras.txt: CAMERA_ID MODEL WIDTH HEIGHT
    PARAMETERS..."""
    parts = line.split()
    try:
        width_px, height_px = int(parts[2]), int(parts[3])
        parameters = [float(part) for part in parts[4:]]
    except (IndexError, ValueError):
        raise ValueError(f"not a line of cameras.txt: {line!r}") from None
    return from_colmap(parts[1], width_px, height_px, parameters)


def to_colmap(camera: Camera) -> tuple[str, int, int, tuple[float, ...]]:
    """model, width, height and parameters, with COLMAP's pixel centres."""
    moved = _moved(camera, 0.5)
    return moved.model, moved.width_px, moved.height_px, moved.parameters


def from_arkit(intrinsics: ArrayLike, width_px: int, height_px: int) -> Camera:
    """ARCamera.intrinsics and imageResolution, which belong to capturedImage as
    the sensor gives it (landscape). `intrinsics` is 3x3 in rows; simd_float3x3
    lists its columns: transpose those. Apple measures from the corner of the
    top left pixel, so half a pixel is subtracted."""
    fx, fy, cx, cy = _focals_and_centre(intrinsics)
    return pinhole(fx, fy, cx - 0.5, cy - 0.5, width_px, height_px)


def from_arcore(focal_length_px: Sequence[float],
                principal_point_px: Sequence[float],
                image_dimensions_px: Sequence[int]) -> Camera:
    """CameraIntrinsics of Camera.getImageIntrinsics(): those of the image for
    the CPU, not of the texture. ARCore does not say where its pixel centres
    are; as with all textures, (0, 0) is taken to be the corner."""
    fx, fy = focal_length_px
    cx, cy = principal_point_px
    width_px, height_px = image_dimensions_px
    return pinhole(fx, fy, cx - 0.5, cy - 0.5, width_px, height_px)


def from_record3d(metadata: Mapping[str, Any]) -> Camera:
    """The `metadata` of a Record3D recording: K (9 numbers, by columns), w,
    h. Apple's intrinsics, so half a pixel is subtracted. record3d_poses() gives
    the poses."""
    matrix = np.asarray(metadata["K"], dtype=np.float64).reshape(3, 3).T
    return from_arkit(matrix, int(metadata["w"]), int(metadata["h"]))


def record3d_poses(metadata: Mapping[str, Any]) -> Array:
    """N x 4 x 4 world_from_camera of a Record3D recording, from its `poses` of
    qx, qy, qz, qw, tx, ty, tz with OpenGL's axes."""
    poses = [geometry.camera_from_opengl_pose(
        geometry.pose((qw, qx, qy, qz), (tx, ty, tz)))
        for qx, qy, qz, qw, tx, ty, tz in metadata["poses"]]
    return np.array(poses).reshape(-1, 4, 4)


def from_nerf(transforms: Mapping[str, Any]) -> Camera:
    """The camera of a transforms.json of NeRF programs: fl_x, fl_y, cx, cy, w,
    h, and k1 k2 p1 p2 k3 k4 where they are there. Its cx and cy come from
    COLMAP in all converters, so half a pixel is subtracted."""
    missing = [k for k in ("fl_x", "cx", "cy", "w", "h") if k not in transforms]
    if missing:
        raise ValueError(f"transforms.json: has no {', '.join(missing)}")
    fx = float(transforms["fl_x"])
    fy = float(transforms.get("fl_y", fx))
    d = [float(transforms.get(k, 0)) for k in ("k1", "k2", "p1", "p2", "k3",
                                                "k4")]
    matrix = np.array([[fx, 0, float(transforms["cx"]) - 0.5],
                       [0, fy, float(transforms["cy"]) - 0.5], [0, 0, 1]])
    size = int(transforms["w"]), int(transforms["h"])
    model = transforms.get("camera_model", "OPENCV")
    if model == "OPENCV_FISHEYE":
        return from_opencv_fisheye(matrix, [d[0], d[1], d[4], d[5]], *size)
    if d[5]:
        raise ValueError(f"transforms.json: k4 of a camera_model {model!r}")
    return from_opencv(matrix, d[:5], *size)


def nerf_poses(transforms: Mapping[str, Any]) -> Array:
    """N x 4 x 4 world_from_camera of the frames of a transforms.json."""
    poses = [geometry.camera_from_opengl_pose(frame["transform_matrix"])
             for frame in transforms["frames"]]
    return np.array(poses).reshape(-1, 4, 4)
