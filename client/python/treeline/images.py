"""Images into the messages of the wire contract."""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from typing import Literal, Union

import numpy as np
from numpy.typing import NDArray

from treeline.v1 import frame_pb2

# An array; the bytes of an image file; or the path of one.
Image = Union[NDArray, bytes, str, "os.PathLike[str]"]

# How arrays are sent. "raw": pixel by pixel, nothing else is needed. "png":
# without loss, about half as large. "jpeg": colour with loss (quality 90), a
# tenth; depth as PNG. The last two need Pillow or OpenCV.
Encoding = Literal["raw", "png", "jpeg"]

_JPEG_QUALITY = 90
_JPEG_START = b"\xff\xd8\xff"
_PNG_START = b"\x89PNG\r\n\x1a\n"

# Of depth: what is more means "not measured".
_MAX_DEPTH = 65534
# Metres that are rounded to more lose what depth is for.
_MAX_ROUNDING_M = 0.01


def _file_bytes(image: bytes | str | os.PathLike[str], what: str,
                starts: tuple[bytes, ...]) -> bytes:
    if isinstance(image, (str, os.PathLike)):
        what = os.fspath(image)
        with open(image, "rb") as file:
            image = file.read()
    data = bytes(image)
    if not data.startswith(starts):
        kinds = "a PNG" if len(starts) == 1 else "a JPEG or PNG"
        raise ValueError(f"{what}: is not {kinds} file")
    return data


def _encoder(extension: str) -> Callable[[NDArray], bytes]:
    """Of Pillow, or else of OpenCV. ImportError: neither is installed."""
    try:
        from PIL import Image as pillow
    except ImportError:
        pillow = None
    if pillow is not None:
        def with_pillow(pixels: NDArray) -> bytes:
            file = io.BytesIO()
            picture = pillow.fromarray(np.ascontiguousarray(pixels))
            if extension == ".jpg":
                picture.save(file, "JPEG", quality=_JPEG_QUALITY)
            else:
                picture.save(file, "PNG", compress_level=1)
            return file.getvalue()
        return with_pillow
    try:
        import cv2
    except ImportError:
        raise ImportError("encoding: JPEG and PNG need python3-pil or"
                          " python3-opencv; encoding=\"raw\" needs neither"
                          ) from None

    def with_opencv(pixels: NDArray) -> bytes:
        if pixels.ndim == 3:
            pixels = pixels[..., ::-1]  # OpenCV's order is B, G, R
        done, data = cv2.imencode(extension, np.ascontiguousarray(pixels),
                                  [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY]
                                  if extension == ".jpg" else [])
        if not done:
            raise ValueError("encoding: OpenCV could not encode the image")
        return data.tobytes()
    return with_opencv


def color_message(image: Image, encoding: Encoding) -> frame_pb2.ColorImage:
    """H x W x 3 uint8 (R, G, B), or a JPEG or PNG file. ValueError: anything
    else."""
    if not isinstance(image, np.ndarray):
        if not isinstance(image, (bytes, bytearray, memoryview, str,
                                  os.PathLike)):
            raise TypeError("image: an array, the bytes of a JPEG or PNG file"
                            " or a path is expected, not "
                            + type(image).__name__)
        return frame_pb2.ColorImage(encoded=_file_bytes(
            image, "image", (_JPEG_START, _PNG_START)))
    if image.ndim != 3 or image.shape[2] != 3 or image.dtype != np.uint8:
        raise ValueError("image: H x W x 3 of uint8 (R, G, B) is expected, not "
                         f"{image.shape} of {image.dtype}")
    if image.size == 0:
        raise ValueError("image: it has no pixels")
    if encoding == "raw":
        height, width = image.shape[:2]
        return frame_pb2.ColorImage(rgb8=frame_pb2.Rgb8Image(
            width_px=width, height_px=height, data=image.tobytes()))
    return frame_pb2.ColorImage(
        encoded=_encoder(".jpg" if encoding == "jpeg" else ".png")(image))


def depth_values(depth: NDArray, unit_m: float) -> NDArray[np.uint16]:
    """H x W of uint16 in units of unit_m. Of floats (metres), what is not
    positive, not finite or too far for 16 bits is 0: not measured; so is what is
    masked. ValueError:
    also for floats that are no metres, by all signs."""
    if depth.ndim != 2 or depth.size == 0:
        raise ValueError(f"depth: H x W is expected, not {depth.shape}")
    if isinstance(depth, np.ma.MaskedArray):
        # tobytes() would write its fill value, 999999 as 16 bits, there.
        depth = depth.filled(0)
    if depth.dtype == np.uint16:
        return depth
    if not np.issubdtype(depth.dtype, np.floating):
        raise ValueError("depth: uint16 (in units of unit_m) or floats (metres)"
                         f" are expected, not {depth.dtype}")
    if unit_m > _MAX_ROUNDING_M:
        raise ValueError(f"depth: floats are metres and would be rounded to"
                         f" unit_m, {unit_m} m; leave it away")
    with np.errstate(invalid="ignore", over="ignore"):
        units = np.rint(depth.astype(np.float64) / unit_m)
        measured = (units >= 1) & (units <= _MAX_DEPTH)
        too_far = (units > _MAX_DEPTH) & np.isfinite(units)
    if np.any(too_far) and not np.any(measured):
        raise ValueError("depth: floats are metres, and all of these are beyond"
                         f" {_MAX_DEPTH * unit_m:g} m; are they millimetres?")
    return np.where(measured, units, 0).astype(np.uint16)


def fill_depth(image: Image, unit_m: float, encoding: Encoding,
               message: frame_pb2.DepthImage) -> None:
    """An array, or a PNG file of 16-bit grey."""
    if not isinstance(image, np.ndarray):
        if not isinstance(image, (bytes, bytearray, memoryview, str,
                                  os.PathLike)):
            raise TypeError("depth: an array, the bytes of a PNG file, a path"
                            " or a treeline.Depth is expected, not "
                            + type(image).__name__)
        message.png = _file_bytes(image, "depth", (_PNG_START,))
        return
    values = depth_values(image, unit_m)
    if encoding == "raw":
        message.raw.height_px, message.raw.width_px = values.shape
        message.raw.data = values.astype("<u2").tobytes()
    else:
        message.png = _encoder(".png")(values)
