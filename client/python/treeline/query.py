"""What a server is asked: a frame, and what is known about it."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any, Literal, Union

import numpy as np
from numpy.typing import ArrayLike

from treeline import geometry
from treeline.cameras import Camera
from treeline.images import Encoding, Image, color_message, fill_depth
from treeline.v1 import (camera_pb2, frame_pb2, geometry_pb2,
                         relocalization_pb2)

# The side of the picture that is up in the world.
Orientation = Literal["top", "right", "bottom", "left"]

_ORIENTATIONS = {
    "top": frame_pb2.ORIENTATION_TOP_UP,
    "right": frame_pb2.ORIENTATION_RIGHT_UP,
    "bottom": frame_pb2.ORIENTATION_BOTTOM_UP,
    "left": frame_pb2.ORIENTATION_LEFT_UP,
}


@dataclasses.dataclass(frozen=True, eq=False)
class Depth:
    """A depth image: z along the optical axis, not the length of the ray.

    image: H x W of uint16 in units of unit_m, where 0 and 65535 mean "not
      measured"; or H x W of floats in metres, which are rounded to unit_m (what
      is not finite, not positive or over 65534 units is "not measured"; where
      all of it is over, it is refused); or a PNG file of 16-bit grey, its bytes
      or its path.
    unit_m: metres per unit, in (0, 1]; 0.001 for millimetres. Of floats at most
      0.01.
    registered: each depth pixel sees what the colour pixel of the same place
      sees; both images have one size. Otherwise the image comes straight from
      the depth camera: the one that the scene was recorded with, or `camera`.
    camera, color_from_depth: that of another depth camera, and the 4x4 pose
      that maps its points into the colour camera's frame; both or neither.
    scale: world units per measured metre, in [0.5, 2]; None: 1, or the scene's
      where its own depth camera is used, which takes no other.
    """

    image: Image
    unit_m: float = 0.001
    registered: bool = False
    camera: Camera | None = None
    color_from_depth: ArrayLike | None = None
    scale: float | None = None

    def __post_init__(self) -> None:
        if not 0 < self.unit_m <= 1:
            raise ValueError(f"depth: unit_m is {self.unit_m}; it must be in"
                             " (0, 1]")
        if (self.camera is None) != (self.color_from_depth is None):
            raise ValueError("depth: camera and color_from_depth go together")
        if self.registered and self.camera is not None:
            raise ValueError("depth: registered depth has the colour camera, no"
                             " other")


@dataclasses.dataclass(frozen=True, eq=False)
class PosePrior:
    """A pose that the answer must be near: world_from_camera (4x4) of the
    scene's pose sensor, and how far the truth may be from it."""

    world_from_camera: ArrayLike
    position_radius_m: float
    rotation_radius_rad: float  # in (0, pi]


@dataclasses.dataclass(frozen=True, eq=False)
class PositionPrior:
    """A place (3, world frame, metres) and a radius that the camera must be
    within, whatever its rotation."""

    position_in_world_m: ArrayLike
    radius_m: float


@dataclasses.dataclass(frozen=True, eq=False)
class HeightBand:
    """Heights between which the camera must be, along a direction of the world
    frame: its z axis unless up_in_world says otherwise."""

    min_m: float
    max_m: float
    up_in_world: ArrayLike | None = None


Prior = Union[PosePrior, PositionPrior, HeightBand]


@dataclasses.dataclass(frozen=True, eq=False)
class Query:
    """Where was this image taken?

    image: H x W x 3 of uint8 (R, G, B); or a JPEG or PNG file, its bytes or its
      path. It is sent as the sensor gives it: not turned, not scaled.
    depth: None, or a Depth, or what its `image` may be (then in millimetres if
      it has integers, from the depth camera that the scene was recorded with).
    camera: that took the image; None: the scene's, whose size the image must
      then have.
    scene: None: the server finds out which one, among candidate_scenes, or
      among all if there are none.
    model_version: None: the newest that is ready.
    priors: where the camera is expected, at most one of each kind. An answer
      that contradicts one is not given.
    min_confidence: the least of an answer that is localized, in [0, 1]; None:
      the scene's threshold, above which 99 of 100 are right. Lower only if you
      check poses by other means.
    orientation: the side of the picture that is up; None: not known but for
      what gravity or EXIF say. orientation_is_guess: other sides may be tried.
    gravity_in_camera_mps2: where things fall (3; x right, y down, z forward):
      the negative of what an accelerometer at rest reads.
    seed: the same seed, frame and model version give the same answer, bit for
      bit.
    time_budget_ms: most that the server may take from the request's arrival,
      beside the call's own timeout.
    want_correspondences: whether the answer brings the samples and what the
      model predicted for them: for pictures; some tens of kilobytes more.
    encoding: how arrays are sent: "raw", "png" (without loss) or "jpeg" (colour
      with loss). Files are sent as they are.
    """

    image: Image
    depth: Depth | Image | None = None
    _: dataclasses.KW_ONLY
    camera: Camera | None = None
    scene: str | None = None
    candidate_scenes: Sequence[str] | str = ()
    model_version: str | None = None
    priors: Sequence[Prior] | Prior = ()
    min_confidence: float | None = None
    orientation: Orientation | None = None
    orientation_is_guess: bool = False
    gravity_in_camera_mps2: ArrayLike | None = None
    seed: int = 0
    time_budget_ms: float | None = None
    want_correspondences: bool = False
    encoding: Encoding = "raw"


def _vector(values: ArrayLike, name: str) -> geometry_pb2.Vector3:
    v = np.asarray(values, dtype=np.float64)
    if v.shape != (3,):
        raise ValueError(f"{name}: 3 numbers are expected, not {v.shape}")
    return geometry_pb2.Vector3(x=v[0], y=v[1], z=v[2])


def _pose(values: ArrayLike, name: str) -> geometry_pb2.Pose:
    matrix = geometry.check_pose(values, name)
    w, x, y, z = geometry.quaternion_from_matrix(matrix)
    return geometry_pb2.Pose(
        rotation=geometry_pb2.Quaternion(w=w, x=x, y=y, z=z),
        translation_m=_vector(matrix[:3, 3], name))


def camera_message(camera: Camera) -> camera_pb2.Camera:
    return camera_pb2.Camera(model=camera.model, width_px=camera.width_px,
                             height_px=camera.height_px,
                             parameters=camera.parameters)


def _fill_depth(depth: Depth | Image, encoding: Encoding,
                message: frame_pb2.DepthImage) -> None:
    if not isinstance(depth, Depth):
        depth = Depth(depth)
    fill_depth(depth.image, depth.unit_m, encoding, message)
    message.unit_m = depth.unit_m
    if depth.scale is not None:
        message.depth_scale = depth.scale
    if depth.registered:
        message.registration = (
            frame_pb2.DEPTH_REGISTRATION_REGISTERED_TO_COLOR)
    elif depth.camera is None or depth.color_from_depth is None:
        message.registration = frame_pb2.DEPTH_REGISTRATION_SCENE_CALIBRATION
    else:
        message.registration = frame_pb2.DEPTH_REGISTRATION_EXPLICIT
        message.calibration.depth_camera.CopyFrom(camera_message(depth.camera))
        message.calibration.color_from_depth.CopyFrom(
            _pose(depth.color_from_depth, "depth: color_from_depth"))


def _fill_frame(query: Query, frame: frame_pb2.Frame) -> None:
    if query.encoding not in ("raw", "png", "jpeg"):
        raise ValueError(f"encoding: {query.encoding!r} is not \"raw\", \"png\""
                         " or \"jpeg\"")
    frame.color.CopyFrom(color_message(query.image, query.encoding))
    if query.camera is not None:
        frame.camera.CopyFrom(camera_message(query.camera))
    if query.depth is not None:
        _fill_depth(query.depth, query.encoding, frame.depth)
    if query.orientation is not None:
        if query.orientation not in _ORIENTATIONS:
            raise ValueError(f"orientation: {query.orientation!r} is no side;"
                             " top, right, bottom or left is up")
        frame.orientation = _ORIENTATIONS[query.orientation]
        frame.orientation_is_guess = query.orientation_is_guess
    if query.gravity_in_camera_mps2 is not None:
        frame.gravity_in_camera_mps2.CopyFrom(_vector(
            query.gravity_in_camera_mps2, "gravity_in_camera_mps2"))


def _fill_priors(priors: Sequence[Prior] | Prior,
                 options: relocalization_pb2.LocalizeOptions) -> None:
    if isinstance(priors, (PosePrior, PositionPrior, HeightBand)):
        priors = (priors,)
    kinds = [type(prior) for prior in priors]
    if len(set(kinds)) < len(kinds):
        raise ValueError("priors: at most one of each kind")
    for prior in priors:
        if isinstance(prior, PosePrior):
            options.prior.world_from_camera.CopyFrom(
                _pose(prior.world_from_camera, "priors: world_from_camera"))
            options.prior.position_radius_m = prior.position_radius_m
            options.prior.rotation_radius_rad = prior.rotation_radius_rad
        elif isinstance(prior, PositionPrior):
            options.position_prior.position_in_world_m.CopyFrom(_vector(
                prior.position_in_world_m, "priors: position_in_world_m"))
            options.position_prior.radius_m = prior.radius_m
        elif isinstance(prior, HeightBand):
            options.height_band.min_m = prior.min_m
            options.height_band.max_m = prior.max_m
            if prior.up_in_world is not None:
                options.height_band.up_in_world.CopyFrom(
                    _vector(prior.up_in_world, "priors: up_in_world"))
        else:
            raise TypeError("priors: a PosePrior, PositionPrior or HeightBand"
                            f" is expected, not {type(prior).__name__}")


def request_of(query: Query) -> relocalization_pb2.LocalizeRequest:
    """ValueError, TypeError, OSError: what is wrong with the query or with a
    file that it names. What only the server can know is left to it."""
    # A text is one scene, not its letters.
    candidates = ((query.candidate_scenes,)
                  if isinstance(query.candidate_scenes, str)
                  else query.candidate_scenes)
    request = relocalization_pb2.LocalizeRequest(
        scene=query.scene or "", model_version=query.model_version or "",
        candidate_scenes=candidates)
    _fill_frame(query, request.frame)
    options = request.options
    options.seed = query.seed
    options.include_correspondences = query.want_correspondences
    if query.time_budget_ms is not None:
        options.time_budget_ms = query.time_budget_ms
    if query.min_confidence is not None:
        options.min_confidence = query.min_confidence
    _fill_priors(query.priors, options)
    return request


def query_of(frame: Query | Image, fields: dict[str, Any]) -> Query:
    """A frame of a stream: a Query as it is, an image with the fields."""
    return frame if isinstance(frame, Query) else Query(frame, **fields)
