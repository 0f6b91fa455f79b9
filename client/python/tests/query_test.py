"""Queries and images as messages."""

import importlib.util
import io
import pathlib
import sys
import tempfile
import unittest
import unittest.mock

import numpy as np
from PIL import Image

import treeline
from treeline import cameras, geometry
from treeline.images import depth_values
from treeline.query import request_of
from treeline.v1 import frame_pb2

JPEG = b"\xff\xd8\xff rest"
PNG = b"\x89PNG\r\n\x1a\n rest"
RGB = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)


def frame_of(image=JPEG, depth=None, **fields):
    return request_of(treeline.Query(image, depth, **fields)).frame


class Images(unittest.TestCase):

    def test_arrays_are_sent_row_by_row(self):
        image = frame_of(RGB[:, ::-1]).color.rgb8  # not contiguous
        self.assertEqual((image.width_px, image.height_px), (4, 2))
        self.assertEqual(image.data, RGB[:, ::-1].tobytes())

    def test_files_are_sent_as_they_are(self):
        self.assertEqual(frame_of(JPEG).color.encoded, JPEG)
        self.assertEqual(frame_of(PNG).color.encoded, PNG)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "a.jpg"
            path.write_bytes(JPEG)
            self.assertEqual(frame_of(path).color.encoded, JPEG)
            self.assertEqual(frame_of(str(path)).color.encoded, JPEG)
            path.write_bytes(b"GIF89a")
            with self.assertRaisesRegex(ValueError, "a.jpg: is not a JPEG"):
                frame_of(path)
        with self.assertRaises(FileNotFoundError):
            frame_of("/nowhere/a.jpg")

    def test_what_is_no_image_is_refused_in_words(self):
        for image, why in ((RGB[..., 0], r"\(2, 4\) of uint8"),
                           (RGB / 255, "of float64"),
                           (np.zeros((2, 2, 4), np.uint8), r"\(2, 2, 4\)"),
                           (np.zeros((0, 2, 3), np.uint8), "no pixels"),
                           (b"GIF89a", "not a JPEG or PNG")):
            with self.assertRaisesRegex(ValueError, "image: .*" + why):
                frame_of(image)
        with self.assertRaisesRegex(TypeError, "not list"):
            frame_of([1, 2])

    def test_png_is_without_loss_and_jpeg_almost(self):
        png = frame_of(RGB, encoding="png").color.encoded
        np.testing.assert_array_equal(self.decoded(png), RGB)
        grey = np.full((64, 64, 3), 100, np.uint8)
        jpeg = frame_of(grey, encoding="jpeg").color.encoded
        self.assertTrue(jpeg.startswith(JPEG[:3]))
        self.assertLessEqual(
            np.abs(self.decoded(jpeg).astype(int) - 100).max(), 2)
        depth = np.array([[0, 1, 65535], [300, 4000, 65534]], np.uint16)
        png = frame_of(RGB, depth, encoding="jpeg").depth.png
        np.testing.assert_array_equal(self.decoded(png), depth)
        with self.assertRaisesRegex(ValueError, "'gif'"):
            frame_of(RGB, encoding="gif")

    def test_opencv_encodes_where_there_is_no_pillow(self):
        if importlib.util.find_spec("cv2") is None:
            self.skipTest("no python3-opencv")
        depth = np.array([[0, 1, 65535], [300, 4000, 65534]], np.uint16)
        with unittest.mock.patch.dict(sys.modules, {"PIL": None}):
            frame = frame_of(RGB, depth, encoding="png")
            red = np.full((64, 64, 3), [200, 0, 0], np.uint8)
            jpeg = frame_of(red, encoding="jpeg").color.encoded
        np.testing.assert_array_equal(
            self.decoded(frame.color.encoded), RGB)
        np.testing.assert_array_equal(self.decoded(frame.depth.png), depth)
        self.assertLessEqual(
            np.abs(self.decoded(jpeg).astype(int) - red).max(), 4)

    def test_without_either_only_raw_pixels_can_be_sent(self):
        with unittest.mock.patch.dict(sys.modules,
                                      {"PIL": None, "cv2": None}):
            with self.assertRaisesRegex(ImportError, "python3-pil"):
                frame_of(RGB, encoding="png")
            self.assertEqual(frame_of(RGB).color.rgb8.width_px, 4)

    @staticmethod
    def decoded(data):
        return np.asarray(Image.open(io.BytesIO(data)))


class Depth(unittest.TestCase):

    def test_integers_are_sent_little_endian_in_their_unit(self):
        values = np.array([[1, 256], [65535, 0]], ">u2")
        depth = frame_of(depth=treeline.Depth(
            values.astype(np.uint16), unit_m=0.0002)).depth
        self.assertEqual(depth.raw.data, b"\x01\0\0\x01\xff\xff\0\0")
        self.assertEqual(depth.unit_m, 0.0002)
        self.assertEqual(depth.registration,
                         frame_pb2.DEPTH_REGISTRATION_SCENE_CALIBRATION)

    def test_metres_are_rounded_and_the_rest_is_not_measured(self):
        metres = np.array([[1.2344, 1.2346, 65.534], [65.6, np.nan, np.inf],
                           [0, -1, 0.0001]])
        expected = [[1234, 1235, 65534], [0, 0, 0], [0, 0, 0]]
        for kind in (np.float64, np.float32):
            np.testing.assert_array_equal(
                depth_values(metres.astype(kind), 0.001), expected)

    def test_what_is_masked_is_not_measured(self):
        millimetres = np.ma.array([[1234, 4321]], np.uint16,
                                  mask=[[False, True]])
        depth = frame_of(depth=millimetres).depth
        self.assertEqual(depth.raw.data, b"\xd2\x04\0\0")
        np.testing.assert_array_equal(
            depth_values(np.ma.array([[1.5, 2.5]], mask=[[True, False]]),
                         0.001), [[0, 2500]])

    def test_floats_that_are_no_metres_are_refused_in_words(self):
        millimetres = np.array([[1234, 0], [np.nan, 2345]], np.float32)
        with self.assertRaisesRegex(ValueError, "are they millimetres"):
            frame_of(depth=millimetres)
        with self.assertRaisesRegex(ValueError, "rounded to unit_m, 1.0 m"):
            frame_of(depth=treeline.Depth(millimetres / 1000, unit_m=1.0))
        nothing = np.array([[0, np.nan, np.inf, -1]])
        self.assertFalse(depth_values(nothing, 0.001).any())

    def test_registered_and_explicit(self):
        registered = frame_of(RGB, treeline.Depth(
            np.ones((2, 4)), registered=True, scale=1.02)).depth
        self.assertEqual(registered.registration,
                         frame_pb2.DEPTH_REGISTRATION_REGISTERED_TO_COLOR)
        self.assertEqual(registered.depth_scale, 1.02)
        camera = cameras.pinhole(500, 500, 2, 1, 4, 2)
        beside = geometry.pose([1, 0, 0, 0], [0.025, 0, 0])
        explicit = frame_of(RGB, treeline.Depth(
            PNG, camera=camera, color_from_depth=beside)).depth
        self.assertEqual(explicit.png, PNG)
        self.assertEqual(explicit.registration,
                         frame_pb2.DEPTH_REGISTRATION_EXPLICIT)
        self.assertEqual(explicit.calibration.depth_camera.model, "PINHOLE")
        self.assertEqual(
            explicit.calibration.color_from_depth.translation_m.x, 0.025)
        self.assertFalse(explicit.HasField("depth_scale"))

    def test_what_is_no_depth_is_refused_in_words(self):
        for depth, why in ((RGB, "H x W"), (np.ones((2, 2), np.int32), "int32"),
                           (JPEG, "not a PNG")):
            with self.assertRaisesRegex(ValueError, "depth: .*" + why):
                frame_of(depth=depth)
        with self.assertRaisesRegex(ValueError, "unit_m is 1000"):
            treeline.Depth(PNG, unit_m=1000)
        with self.assertRaisesRegex(ValueError, "go together"):
            treeline.Depth(PNG, color_from_depth=np.eye(4))
        with self.assertRaisesRegex(ValueError, "no other"):
            treeline.Depth(PNG, registered=True, color_from_depth=np.eye(4),
                           camera=cameras.pinhole(1, 1, 1, 1, 4, 2))


class Queries(unittest.TestCase):

    def test_keep_every_field(self):
        pose = geometry.pose([0.6, 0.8, 0, 0], [1, 2, 3])
        request = request_of(treeline.Query(
            JPEG, camera=cameras.pinhole(500, 501, 320, 240, 640, 480),
            candidate_scenes=["kitchen", "office"], model_version="7",
            priors=[treeline.PosePrior(pose, 4, 0.5),
                    treeline.PositionPrior([1, 2, 3], 5),
                    treeline.HeightBand(-1, 2, up_in_world=[0, 1, 0])],
            min_confidence=0.4, orientation="left", orientation_is_guess=True,
            gravity_in_camera_mps2=[0, -9.81, 0.5], seed=2**64 - 1,
            time_budget_ms=250, want_correspondences=True))
        self.assertEqual(request.scene, "")
        self.assertEqual(list(request.candidate_scenes), ["kitchen", "office"])
        self.assertEqual(request.model_version, "7")
        self.assertEqual(list(request.frame.camera.parameters),
                         [500, 501, 320, 240])
        self.assertEqual(request.frame.orientation,
                         frame_pb2.ORIENTATION_LEFT_UP)
        self.assertTrue(request.frame.orientation_is_guess)
        self.assertEqual(request.frame.gravity_in_camera_mps2.z, 0.5)
        options = request.options
        self.assertEqual(options.seed, 2**64 - 1)
        self.assertEqual(options.time_budget_ms, 250)
        self.assertEqual(options.min_confidence, 0.4)
        self.assertTrue(options.include_correspondences)
        self.assertAlmostEqual(options.prior.world_from_camera.rotation.x, 0.8)
        self.assertEqual(options.prior.world_from_camera.translation_m.z, 3)
        self.assertEqual(options.prior.rotation_radius_rad, 0.5)
        self.assertEqual(options.position_prior.radius_m, 5)
        self.assertEqual(options.height_band.max_m, 2)
        self.assertEqual(options.height_band.up_in_world.y, 1)

    def test_what_is_not_said_is_absent(self):
        request = request_of(treeline.Query(JPEG, scene="room"))
        self.assertEqual(request.scene, "room")
        self.assertFalse(request.frame.HasField("camera"))
        self.assertFalse(request.frame.HasField("depth"))
        self.assertFalse(request.frame.HasField("gravity_in_camera_mps2"))
        for field in ("time_budget_ms", "min_confidence", "prior",
                      "position_prior", "height_band"):
            self.assertFalse(request.options.HasField(field), field)

    def test_one_candidate_need_not_be_a_list(self):
        for candidates in ("hall", ["hall"], ("hall",)):
            self.assertEqual(request_of(treeline.Query(
                JPEG, candidate_scenes=candidates)).candidate_scenes, ["hall"])

    def test_a_prior_need_not_be_a_list_and_two_of_a_kind_contradict(self):
        band = treeline.HeightBand(0, 2)
        request = request_of(treeline.Query(JPEG, priors=band))
        self.assertFalse(request.options.height_band.HasField("up_in_world"))
        with self.assertRaisesRegex(ValueError, "one of each kind"):
            request_of(treeline.Query(JPEG, priors=[band, band]))
        with self.assertRaisesRegex(TypeError, "not float"):
            request_of(treeline.Query(JPEG, priors=[1.0]))
        with self.assertRaisesRegex(ValueError, "no side"):
            frame_of(orientation="up")
        with self.assertRaisesRegex(ValueError, "3 numbers"):
            frame_of(gravity_in_camera_mps2=[1, 2])


if __name__ == "__main__":
    unittest.main()
