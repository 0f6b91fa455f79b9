"""What a server answers."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from treeline import geometry
from treeline.cameras import Camera
from treeline.errors import InternalError, TreelineError
from treeline.geodesy import GeoAnchor
from treeline.geometry import Array
from treeline.v1 import (camera_pb2, geometry_pb2, relocalization_pb2,
                         scenes_pb2)


@dataclasses.dataclass(frozen=True)
class Timings:
    """Where the server's time went, in the order of its stages (ms)."""

    queue_ms: float
    decode_ms: float
    sample_ms: float
    forest_ms: float
    pose_ms: float
    # The localizer as a whole: sample, forest, pose and what lies between.
    localize_ms: float
    # From the arrival of the request to its answer.
    total_ms: float


@dataclasses.dataclass(frozen=True)
class SceneCandidate:
    """A scene that the server considered, if it was to choose one."""

    scene: str
    similarity: float  # in [0, 1], comparable within one answer
    # Whether a pose in it was looked for; the rest is of that.
    tried: bool
    localized: bool
    confidence: float
    inliers: int


@dataclasses.dataclass(frozen=True, eq=False)
class Correspondences:
    """The N samples of a frame, as they were asked for."""

    pixels: Array  # N x 2, of the colour image; centre of the first is (0, 0)
    # N x 3, measured, in the frame of pose_sensor's camera; zero where nothing
    # was measured.
    points_in_camera_m: Array
    points_in_world_m: Array  # N x 3, as the model predicted them
    inlier: NDArray[np.bool_]  # N: whether the pose explains it


@dataclasses.dataclass(frozen=True, eq=False)
class Answer:
    """Where a frame was taken, or that it was not found: `if answer:` is `if
    answer.localized:`."""

    localized: bool
    # Why not: "TOO_FEW_SAMPLES", "TOO_FEW_INLIERS", "POORLY_CONSTRAINED",
    # "LOW_CONFIDENCE", "CONTRADICTS_PRIOR", "CONTRADICTS_DEPTH" or
    # "UNKNOWN_CAMERA"; the number of one that this client does not know. None
    # if localized.
    reason: str | None
    # 4 x 4: maps points of the frame of pose_sensor's camera (x right, y down,
    # z forward) into the scene's world frame, metres. None if not localized,
    # like the next four.
    world_from_camera: Array | None
    # Its rotation and translation, bit for bit as the server computed them: a
    # unit quaternion w, x, y, z, and the camera's centre in the world (m).
    rotation_wxyz: Array | None
    position_in_world_m: Array | None
    # 6 x 6, of x, y, z (m), then rotation about the x, y, z axes (rad), in the
    # world frame: docs/frames.md of Treeline. The order of ROS.
    covariance: Array | None
    # Whose pose it is: "COLOR" or "DEPTH", the one that the scene was trained
    # with.
    pose_sensor: str | None
    # Samples that the pose explains, and samples drawn from the frame.
    inliers: int
    samples: int
    inlier_ratio: float  # in [0, 1]
    # Probability that the pose is right, within 5 cm and 5 degrees; 0 if there
    # is no pose at all.
    confidence: float
    # The scene's: of answers that reach it, 99 of 100 were right in training.
    confidence_threshold: float
    # The pose is of a camera whose focal length is so many times the stated
    # one, since that fits better; 1: the stated one fits.
    focal_scale: float
    # If localized by a picture of which no camera was stated, or a guess that
    # does not fit: the camera that the pose is of, found by what is seen. None:
    # the stated one, or the scene's.
    camera: Camera | None
    # The pose is that of depth that is so many times as large as what was sent,
    # since that fits better; 1: it fits as it is.
    depth_scale: float
    # Who answered.
    scene: str
    model_version: str
    # If the server chose the scene: the best first.
    candidates: tuple[SceneCandidate, ...]
    timings: Timings
    # From the call to the answer in hand, retries included (ms). In streams:
    # without the time that the frame waited for room.
    round_trip_ms: float
    # None if they were not asked for.
    correspondences: Correspondences | None

    def __bool__(self) -> bool:
        return self.localized

    @property
    def inlier_pixels(self) -> Array | None:
        """N x 2: where the inliers are in the colour image (x right, y down).
        None if correspondences were not asked for."""
        if self.correspondences is None:
            return None
        return self.correspondences.pixels[self.correspondences.inlier]


@dataclasses.dataclass(frozen=True, eq=False)
class StreamAnswer:
    """To one frame of a stream: an answer or an error."""

    # Of the frame, counted from 0.
    index: int
    answer: Answer | None
    error: TreelineError | None

    def get(self) -> Answer:
        """The answer; raises the error if there is one."""
        if self.error is not None:
            raise self.error
        assert self.answer is not None
        return self.answer


@dataclasses.dataclass(frozen=True, eq=False)
class Calibration:
    """The cameras that a scene was recorded with, and what a query without its
    own is taken with."""

    color: Camera
    # None: there is no depth camera.
    depth: Camera | None
    # 4 x 4: maps points of the depth camera's frame into the colour camera's.
    color_from_depth: Array
    # World units per measured metre.
    depth_scale: float
    # Whose pose world_from_camera means: "COLOR" or "DEPTH".
    pose_sensor: str

    def color_pose(self, answer: Answer) -> Array:
        """world_from_color, 4 x 4, of an answer of this scene that is
        localized, whichever camera its pose is of. ValueError: it is not."""
        if answer.world_from_camera is None:
            raise ValueError("the answer has no pose: it is not localized")
        if answer.pose_sensor == "COLOR":
            return answer.world_from_camera
        return answer.world_from_camera @ geometry.inverse(
            self.color_from_depth)


@dataclasses.dataclass(frozen=True, eq=False)
class Model:
    """A model file as the server describes it."""

    method: str
    dataset: str
    created_utc: str
    software_version: str
    checksum: str
    calibration: Calibration
    # Axis-aligned box of the training points, world frame (m).
    bounds_min_in_world_m: tuple[float, float, float]
    bounds_max_in_world_m: tuple[float, float, float]
    training_frames: int
    training_s: float
    trees: int
    leaves: int
    file_bytes: int


@dataclasses.dataclass(frozen=True, eq=False)
class Scene:
    """A scene as the server describes it."""

    name: str
    # "READY", "LOADING", "UNLOADED" or "FAILED".
    state: str
    # Why it failed: "DATA_LOSS: ...". "" otherwise.
    failure: str
    # The version that answers; "" if none does.
    model_version: str
    # All versions on the server's disk, the newest first.
    versions: tuple[str, ...]
    # From the scene's scene.json; "" and None: it says nothing.
    display_name: str
    geo_anchor: GeoAnchor | None
    default_camera: Camera | None
    # Memory that its loaded versions take (bytes).
    resident_bytes: int
    # Of the version that answers.
    model: Model | None


def _broken(problem: str) -> InternalError:
    return InternalError(f"the server's answer is not valid: {problem}")


def _short_name(enum, number: int, prefix: str) -> str:
    """An enumerator's name without the prefix that all have; the number of one
    that this client does not know."""
    try:
        return enum.Name(number).removeprefix(prefix)
    except ValueError:
        return str(number)


def _vector(v: geometry_pb2.Vector3) -> tuple[float, float, float]:
    return v.x, v.y, v.z


def _camera(message: camera_pb2.Camera) -> Camera:
    try:
        return Camera(message.model, message.width_px, message.height_px,
                      tuple(message.parameters))
    except ValueError as problem:
        raise _broken(str(problem)) from None


def _unit_pose(pose: geometry_pb2.Pose, name: str) -> tuple[Array, Array,
                                                           Array]:
    """4 x 4, quaternion and translation, bit for bit."""
    if not pose.HasField("rotation"):
        raise _broken(f"{name}: has no rotation")
    q = pose.rotation
    position = np.array(_vector(pose.translation_m))
    try:
        rotation = geometry.unit_quaternion([q.w, q.x, q.y, q.z])
        return geometry.pose(rotation, position), rotation, position
    except ValueError as problem:
        raise _broken(f"{name}: {problem}") from None


def _sensor(sensor: int) -> str:
    if sensor not in (camera_pb2.RGBD_SENSOR_COLOR,
                      camera_pb2.RGBD_SENSOR_DEPTH):
        raise _broken("pose_sensor: is neither")
    return _short_name(camera_pb2.RgbdSensor, sensor, "RGBD_SENSOR_")


def _pose(response: relocalization_pb2.LocalizeResponse) -> dict:
    """The fields that only a localized answer has."""
    matrix, rotation, position = _unit_pose(response.world_from_camera,
                                            "world_from_camera")
    if len(response.covariance) != 36:
        raise _broken(f"covariance: {len(response.covariance)} entries")
    covariance = np.array(response.covariance).reshape(6, 6)
    if not np.isfinite(covariance).all():
        raise _broken("covariance: has a NaN or an infinity")
    return {"world_from_camera": matrix, "rotation_wxyz": rotation,
            "position_in_world_m": position, "covariance": covariance,
            "pose_sensor": _sensor(response.pose_sensor)}


def _correspondences(response: relocalization_pb2.LocalizeResponse
                     ) -> Correspondences:
    samples = response.correspondences
    return Correspondences(
        pixels=np.array([(s.color_pixel.x_px, s.color_pixel.y_px)
                         for s in samples]).reshape(-1, 2),
        points_in_camera_m=np.array([_vector(s.point_in_camera_m)
                                     for s in samples]).reshape(-1, 3),
        points_in_world_m=np.array([_vector(s.point_in_world_m)
                                    for s in samples]).reshape(-1, 3),
        inlier=np.array([s.inlier for s in samples], dtype=bool))


def answer_of(response: relocalization_pb2.LocalizeResponse,
              round_trip_ms: float, with_correspondences: bool) -> Answer:
    """InternalError: the server breaks the contract. A pose that is none must
    never reach a robot as if it were one."""
    if response.outcome not in (relocalization_pb2.OUTCOME_LOCALIZED,
                                relocalization_pb2.OUTCOME_NOT_LOCALIZED):
        raise _broken("outcome: is neither")
    localized = response.outcome == relocalization_pb2.OUTCOME_LOCALIZED
    pose: dict = dict.fromkeys(
        ("world_from_camera", "rotation_wxyz", "position_in_world_m",
         "covariance", "pose_sensor"))
    if localized:
        pose = _pose(response)
    timings = response.timings
    return Answer(
        localized=localized,
        reason=None if localized else _short_name(
            relocalization_pb2.NotLocalizedReason, response.reason,
            "NOT_LOCALIZED_REASON_"),
        inliers=response.inliers, samples=response.samples,
        inlier_ratio=response.inlier_ratio, confidence=response.confidence,
        confidence_threshold=response.confidence_threshold,
        focal_scale=(response.focal_scale
                     if response.HasField("focal_scale") else 1.0),
        camera=(_camera(response.camera)
                if response.HasField("camera") else None),
        depth_scale=(response.depth_scale
                     if response.HasField("depth_scale") else 1.0),
        scene=response.scene, model_version=response.model_version,
        candidates=tuple(SceneCandidate(
            scene=c.scene, similarity=c.similarity, tried=c.tried,
            localized=c.outcome == relocalization_pb2.OUTCOME_LOCALIZED,
            confidence=c.confidence, inliers=c.inliers)
            for c in response.candidates),
        timings=Timings(
            queue_ms=timings.queue_ms, decode_ms=timings.decode_ms,
            sample_ms=timings.sample_ms, forest_ms=timings.forest_ms,
            pose_ms=timings.pose_ms, localize_ms=timings.localize_ms,
            total_ms=timings.total_ms),
        round_trip_ms=round_trip_ms,
        correspondences=(_correspondences(response) if with_correspondences
                         else None),
        **pose)


def _calibration(message: camera_pb2.RgbdCalibration) -> Calibration:
    return Calibration(
        color=_camera(message.color),
        depth=_camera(message.depth) if message.HasField("depth") else None,
        color_from_depth=_unit_pose(message.color_from_depth,
                                    "calibration.color_from_depth")[0],
        depth_scale=message.depth_scale,
        pose_sensor=_sensor(message.pose_sensor))


def _model(info: scenes_pb2.ModelInfo) -> Model:
    return Model(
        method=info.method, dataset=info.dataset, created_utc=info.created_utc,
        software_version=info.software_version, checksum=info.checksum,
        calibration=_calibration(info.calibration),
        bounds_min_in_world_m=_vector(info.bounds_min_in_world_m),
        bounds_max_in_world_m=_vector(info.bounds_max_in_world_m),
        training_frames=info.training_frames, training_s=info.training_s,
        trees=info.trees, leaves=info.leaves, file_bytes=info.file_bytes)


def _anchor(message: geometry_pb2.GeoAnchor) -> GeoAnchor:
    q = message.enu_from_world
    rotation = ((q.w, q.x, q.y, q.z) if message.HasField("enu_from_world")
                else (1.0, 0.0, 0.0, 0.0))
    try:
        return GeoAnchor(message.latitude_deg, message.longitude_deg,
                         message.height_m, rotation)
    except ValueError as problem:
        raise _broken(f"geo_anchor: {problem}") from None


def scene_of(info: scenes_pb2.SceneInfo) -> Scene:
    """InternalError: the server breaks the contract."""
    return Scene(
        name=info.scene,
        state=_short_name(scenes_pb2.SceneState, info.state, "SCENE_STATE_"),
        failure=(f"{info.failure.code}: {info.failure.message}"
                 if info.HasField("failure") else ""),
        model_version=info.model_version,
        versions=tuple(v.version for v in info.versions),
        display_name=info.display_name,
        geo_anchor=(_anchor(info.geo_anchor) if info.HasField("geo_anchor")
                    else None),
        default_camera=(_camera(info.default_camera)
                        if info.HasField("default_camera") else None),
        resident_bytes=info.resident_bytes,
        model=_model(info.model) if info.HasField("model") else None)
