"""Where a pose lies on the Earth: WGS84 and OGC GeoPose, as the server's
POST /geopose computes it.

Frames: `enu` has East, North, Up at a position on the ellipsoid. `ecef` is
fixed to the Earth, with x to latitude 0, longitude 0 and z to the north pole
(metres). `device` is a camera with x to the right of the picture, y forward
along the optical axis, z to the top of the picture: a camera held level that
looks north has the identity.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import ArrayLike

from treeline import geometry

_SEMI_MAJOR_M = 6378137.0
_FLATTENING = 1 / 298.257223563
_SEMI_MINOR_M = _SEMI_MAJOR_M * (1 - _FLATTENING)
# Squared eccentricities, first and second.
_E2 = _FLATTENING * (2 - _FLATTENING)
_EP2 = _E2 / (1 - _E2)

# 95 % of a chi-square distribution with three degrees of freedom.
_CHI_SQUARE_3_OF_95 = 7.814727903251179

# Columns: the axes of `device` in `camera`.
_CAMERA_FROM_DEVICE = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])


@dataclasses.dataclass(frozen=True)
class GeoAnchor:
    """Ties a scene's world frame to the Earth: its origin lies at the position,
    and enu_from_world (w, x, y, z) turns its axes into East, North, Up."""

    latitude_deg: float
    longitude_deg: float
    height_m: float  # above the ellipsoid of WGS84
    enu_from_world_wxyz: tuple[float, float, float, float] = (1, 0, 0, 0)

    def __post_init__(self) -> None:
        if not abs(self.latitude_deg) <= 90:
            raise ValueError(f"the latitude {self.latitude_deg} is outside"
                             " -90..90 degrees")
        if not abs(self.longitude_deg) <= 180:
            raise ValueError(f"the longitude {self.longitude_deg} is outside"
                             " -180..180 degrees")
        if not math.isfinite(self.height_m):
            raise ValueError("the height is not a number")


@dataclasses.dataclass(frozen=True)
class GeoPose:
    """OGC GeoPose 1.0: Basic-Quaternion and Basic-YPR."""

    latitude_deg: float
    longitude_deg: float
    height_m: float
    # Into East-North-Up at the position: w, x, y, z.
    enu_from_device_wxyz: tuple[float, float, float, float]

    def as_json(self) -> dict:
        """As the standard writes Basic-Quaternion."""
        w, x, y, z = self.enu_from_device_wxyz
        return {"position": self._position_as_json(),
                "quaternion": {"x": x, "y": y, "z": z, "w": w}}

    def as_ypr_json(self) -> dict:
        """As the standard writes Basic-YPR: degrees, about the device's z (up),
        then its new y (forward), then its new x (right), anticlockwise seen
        from the axis' end. Where the picture's right side points straight up or
        down, yaw and roll are one; then roll is 0."""
        yaw, pitch, roll = _yaw_pitch_roll_deg(self.enu_from_device_wxyz)
        return {"position": self._position_as_json(),
                "angles": {"yaw": yaw, "pitch": pitch, "roll": roll}}

    def _position_as_json(self) -> dict:
        return {"lat": self.latitude_deg, "lon": self.longitude_deg,
                "h": self.height_m}


def _yaw_pitch_roll_deg(wxyz: tuple[float, float, float, float]
                        ) -> tuple[float, float, float]:
    w, x, y, z = wxyz
    # The device's x axis in East, North, Up.
    right = (1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y))
    level = math.hypot(right[0], right[1])
    pitch = math.atan2(-right[2], level)
    if level < 1e-9:
        yaw, roll = 2 * math.atan2(z, w), 0.0
        yaw = math.remainder(yaw, 2 * math.pi)
    else:
        yaw = math.atan2(right[1], right[0])
        roll = math.atan2(2 * (y * z + w * x), 1 - 2 * (x * x + y * y))
    return math.degrees(yaw), math.degrees(pitch), math.degrees(roll)


def ecef_from_geodetic(latitude_deg: float, longitude_deg: float,
                       height_m: float) -> geometry.Array:
    """The position as a point (3) in ecef, metres."""
    latitude = math.radians(latitude_deg)
    longitude = math.radians(longitude_deg)
    sine = math.sin(latitude)
    # Radius of curvature across the meridian.
    normal_m = _SEMI_MAJOR_M / math.sqrt(1 - _E2 * sine * sine)
    from_axis_m = (normal_m + height_m) * math.cos(latitude)
    return np.array([from_axis_m * math.cos(longitude),
                     from_axis_m * math.sin(longitude),
                     (normal_m * (1 - _E2) + height_m) * sine])


def geodetic_from_ecef(point_in_ecef_m: ArrayLike) -> tuple[float, float,
                                                            float]:
    """Latitude and longitude (degrees) and height (m) of a point, by Bowring's
    method (1976): better than a micrometre within 50 km of the ellipsoid."""
    x, y, z = (float(c) for c in np.asarray(point_in_ecef_m, np.float64))
    from_axis_m = math.hypot(x, y)
    reduced = math.atan2(z, (1 - _FLATTENING) * from_axis_m)
    latitude = 0.0
    for _ in range(4):
        latitude = math.atan2(
            z + _EP2 * _SEMI_MINOR_M * math.sin(reduced)**3,
            from_axis_m - _E2 * _SEMI_MAJOR_M * math.cos(reduced)**3)
        reduced = math.atan2((1 - _FLATTENING) * math.sin(latitude),
                             math.cos(latitude))
    sine = math.sin(latitude)
    height_m = (from_axis_m * math.cos(latitude) + z * sine -
                _SEMI_MAJOR_M * math.sqrt(1 - _E2 * sine * sine))
    longitude = math.atan2(y, x)
    if longitude == -math.pi:
        longitude = math.pi
    return math.degrees(latitude), math.degrees(longitude), height_m


def ecef_from_enu(latitude_deg: float, longitude_deg: float) -> geometry.Array:
    """3x3; its columns are East, North and Up at the position."""
    latitude = math.radians(latitude_deg)
    longitude = math.radians(longitude_deg)
    sin_lat, cos_lat = math.sin(latitude), math.cos(latitude)
    sin_lon, cos_lon = math.sin(longitude), math.cos(longitude)
    return np.array([[-sin_lon, -sin_lat * cos_lon, cos_lat * cos_lon],
                     [cos_lon, -sin_lat * sin_lon, cos_lat * sin_lon],
                     [0, cos_lat, sin_lat]])


def geo_pose(world_from_camera: ArrayLike, anchor: GeoAnchor) -> GeoPose:
    """Of a camera in the scene that has the anchor (Client.scene() gives it).
    The server's POST /geopose speaks of the colour camera, whose pose
    Calibration.color_pose() gives. East, North and Up are those at the camera,
    not at the anchor: 1 km away they differ by about 0.009 degrees."""
    pose = geometry.check_pose(world_from_camera, "world_from_camera")
    rotation = (ecef_from_enu(anchor.latitude_deg, anchor.longitude_deg) @
                geometry.matrix_from_quaternion(anchor.enu_from_world_wxyz))
    point = rotation @ pose[:3, 3] + ecef_from_geodetic(
        anchor.latitude_deg, anchor.longitude_deg, anchor.height_m)
    latitude_deg, longitude_deg, height_m = geodetic_from_ecef(point)
    enu_from_device = (ecef_from_enu(latitude_deg, longitude_deg).T @
                       rotation @ pose[:3, :3] @ _CAMERA_FROM_DEVICE)
    w, x, y, z = (float(c) for c in
                  geometry.quaternion_from_matrix(enu_from_device))
    return GeoPose(latitude_deg, longitude_deg, height_m, (w, x, y, z))


def accuracy(covariance: ArrayLike) -> tuple[float, float]:
    """(position in metres, orientation in degrees): how far the truth may be
    from an answer of this 6x6 covariance, with a probability of at least 95 %
    of the error that the covariance describes."""
    matrix = np.asarray(covariance, dtype=np.float64)
    if matrix.shape != (6, 6) or not np.isfinite(matrix).all():
        raise ValueError("covariance: a finite 6x6 matrix is expected")
    radii = []
    for first in (0, 3):
        largest = np.linalg.eigvalsh(
            matrix[first:first + 3, first:first + 3])[-1]
        if largest < 0:
            raise ValueError("covariance: has negative variances")
        radii.append(math.sqrt(_CHI_SQUARE_3_OF_95 * largest))
    return radii[0], min(math.degrees(radii[1]), 180.0)
