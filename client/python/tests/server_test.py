"""treeline-server itself, asked from Python and from C++.

    server_test.py PROGRAMS SCENE

PROGRAMS holds treeline-server and treeline-client; SCENE is a folder with
recording/ and room.treeline, of tests/integration/make_scene.cmake.
"""

import base64
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest
import urllib.request

import numpy as np
from PIL import Image
from real_server import RealServer, put_scene

import treeline
from treeline import errors, geodesy, geometry

PROGRAMS = pathlib.Path(sys.argv[1])
RECORDING = pathlib.Path(sys.argv[2]) / "recording"
STEMS = (RECORDING / "test.txt").read_text().split()[:8]


def color_file(stem):
    return RECORDING / f"{stem}.color.jpg"


def depth_file(stem):
    return RECORDING / f"{stem}.depth.png"


def color_array(stem):
    return np.asarray(Image.open(color_file(stem)))


def depth_array(stem):
    return np.asarray(Image.open(depth_file(stem))).astype(np.uint16)


def same(a, b):
    """Whether two answers are equal bit for bit, but for times."""
    return (a.localized == b.localized and a.reason == b.reason
            and np.array_equal(a.rotation_wxyz, b.rotation_wxyz)
            and np.array_equal(a.position_in_world_m, b.position_in_world_m)
            and np.array_equal(a.covariance, b.covariance)
            and (a.inliers, a.samples, a.confidence) ==
            (b.inliers, b.samples, b.confidence))


class RealServerTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.models = pathlib.Path(folder.name) / "models"
        put_scene(cls.models, pathlib.Path(sys.argv[2]) / "room.treeline")
        cls.server = cls.start()
        cls.client = treeline.Client(cls.server.address, timeout_s=60)
        cls.addClassCleanup(cls.client.close)

    @classmethod
    def start(cls):
        server = RealServer(PROGRAMS / "treeline-server", cls.models)
        cls.addClassCleanup(server.stop)
        return server

    def localize(self, stem, **fields):
        fields = {"scene": "room", **fields}
        return self.client.localize(color_file(stem), depth_file(stem),
                                    **fields)

    def from_cpp(self, *stems):
        """What treeline-client says of the frames."""
        with tempfile.NamedTemporaryFile("w") as listed:
            listed.write("\n".join(stems) + "\n")
            listed.flush()
            result = subprocess.run(
                [PROGRAMS / "treeline-client", "localize", "--server",
                 self.server.address, "--scene", "room", "--list", listed.name,
                 "--root", RECORDING, "--json"],
                capture_output=True, text=True, check=True)
        return [json.loads(line) for line in result.stdout.splitlines()]

    def test_answers_are_those_of_the_cpp_client_bit_for_bit(self):
        localized = 0
        for stem, theirs in zip(STEMS, self.from_cpp(*STEMS), strict=True):
            self.assertEqual(theirs["stem"], stem)
            ours = self.localize(stem)
            self.assertEqual(ours.localized, theirs["outcome"] == "LOCALIZED")
            self.assertEqual(ours.reason, theirs["reason"])
            self.assertEqual((ours.inliers, ours.samples, ours.inlier_ratio),
                             (theirs["inliers"], theirs["samples"],
                              theirs["inlier_ratio"]))
            self.assertEqual((ours.confidence, ours.confidence_threshold),
                             (theirs["confidence"],
                              theirs["confidence_threshold"]))
            self.assertEqual(ours.focal_scale, theirs["focal_scale"])
            self.assertEqual(ours.depth_scale, theirs["depth_scale"])
            self.assertEqual((ours.scene, ours.model_version),
                             (theirs["scene"], theirs["version"]))
            if not ours:
                continue
            localized += 1
            pose = theirs["world_from_camera"]
            self.assertEqual(ours.rotation_wxyz.tolist(),
                             [pose["qw"], pose["qx"], pose["qy"], pose["qz"]])
            self.assertEqual(ours.position_in_world_m.tolist(),
                             [pose["tx"], pose["ty"], pose["tz"]])
            self.assertEqual(ours.covariance.ravel().tolist(),
                             theirs["covariance"])
            self.assertEqual(ours.pose_sensor, theirs["pose_sensor"])
        self.assertGreaterEqual(localized, len(STEMS) // 2)

    def test_the_pose_is_the_true_one(self):
        errors_m = []
        for stem in STEMS:
            truth = np.loadtxt(RECORDING / f"{stem}.pose.txt")
            answer = self.localize(stem)
            if answer:
                errors_m.append(geometry.distance_m(
                    truth, answer.world_from_camera))
                self.assertLess(geometry.angle_rad(
                    truth, answer.world_from_camera), math.radians(5))
        self.assertLess(np.median(errors_m), 0.05)

    def test_arrays_are_answered_like_files(self):
        for stem in STEMS[:3]:
            color, depth = color_array(stem), depth_array(stem)
            as_png = self.client.localize(color, depth, scene="room",
                                          encoding="png")
            raw = self.client.localize(color, depth, scene="room")
            self.assertTrue(same(raw, as_png))
            # The same integers come of metres.
            metres = np.where(np.isin(depth, (0, 65535)), np.nan, depth / 1000)
            self.assertTrue(same(raw, self.client.localize(
                color, metres, scene="room")))
            # Depth as in the file, and the file's own colour.
            self.assertTrue(same(
                self.localize(stem), self.client.localize(
                    color_file(stem), depth, scene="room")))

    def test_streams_are_answered_like_calls(self):
        queries = [treeline.Query(color_file(stem), depth_file(stem),
                                  scene="room") for stem in STEMS]
        calls = [self.client.ask(query) for query in queries]
        streamed = [a.get() for a in self.client.stream(queries,
                                                        max_pending=2)]
        self.assertEqual(len(streamed), len(calls))
        for call, answer in zip(calls, streamed):
            self.assertTrue(same(call, answer))
        last = list(self.client.localize_latest(queries))[-1]
        self.assertEqual(last.index, len(queries) - 1)
        self.assertTrue(same(last.get(), calls[-1]))

    def test_inliers_are_where_the_model_says(self):
        answer = next(a for a in map(lambda stem: self.localize(
            stem, want_correspondences=True), STEMS) if a)
        samples = answer.correspondences
        self.assertEqual(len(samples.pixels), answer.samples)
        self.assertEqual(len(answer.inlier_pixels), answer.inliers)
        # Of points that a forest predicts to a few centimetres, 2 m away.
        distance_m = np.linalg.norm(geometry.transform(
            answer.world_from_camera, samples.points_in_camera_m)
            - samples.points_in_world_m, axis=1)
        self.assertLess(np.median(distance_m[samples.inlier]), 0.05)
        calibration = self.client.scene("room").model.calibration
        seen = calibration.color.project(geometry.transform(
            geometry.inverse(calibration.color_pose(answer)),
            samples.points_in_world_m))
        distance_px = np.linalg.norm(seen - samples.pixels, axis=1)
        self.assertLess(np.median(distance_px[samples.inlier]), 10)
        # What was measured lies where it was seen, to a rounded pixel.
        self.assertEqual(answer.pose_sensor, "DEPTH")
        np.testing.assert_allclose(
            calibration.color.project(geometry.transform(
                calibration.color_from_depth, samples.points_in_camera_m)),
            samples.pixels, atol=0.51)

    def test_noise_is_not_localized(self):
        random = np.random.default_rng(3)
        answer = self.client.localize(
            random.integers(0, 256, (480, 640, 3), np.uint8),
            random.uniform(1, 3, (480, 640)), scene="room", orientation="top")
        self.assertFalse(answer)
        self.assertTrue(answer.reason.isupper())
        self.assertIsNone(answer.world_from_camera)

    def test_priors_and_confidence_count(self):
        stem = STEMS[0]
        answer = self.localize(stem)
        near = treeline.PositionPrior(answer.position_in_world_m, 0.5)
        self.assertTrue(self.localize(stem, priors=near))
        far = treeline.PositionPrior(answer.position_in_world_m + 9, 0.5)
        self.assertEqual(self.localize(stem, priors=far).reason,
                         "CONTRADICTS_PRIOR")
        pose = treeline.PosePrior(answer.world_from_camera, 0.1, 0.1)
        band = treeline.HeightBand(answer.position_in_world_m[2] - 0.1,
                                   answer.position_in_world_m[2] + 0.1)
        self.assertTrue(self.localize(stem, priors=[near, pose, band]))
        sure = self.localize(stem, min_confidence=1.0)
        self.assertEqual(sure.reason, "LOW_CONFIDENCE")

    def test_the_server_finds_out_which_scene_it_is(self):
        answer = self.localize(STEMS[0], scene=None)
        self.assertTrue(answer)
        self.assertEqual(answer.scene, "room")
        self.assertEqual(answer.candidates[0].scene, "room")
        self.assertTrue(answer.candidates[0].tried)

    def test_scenes_and_health_are_told(self):
        scene, = self.client.scenes()
        self.assertEqual((scene.name, scene.display_name, scene.versions),
                         ("room", "Room", ("1",)))
        self.assertEqual(self.client.health(), "SERVING")
        self.assertEqual(self.client.health("room"), "SERVING")
        with self.assertRaises(errors.NotFound):
            self.client.health("attic")

    def test_errors_have_stable_reasons(self):
        with self.assertRaises(errors.NotFound) as caught:
            self.localize(STEMS[0], scene="attic")
        self.assertEqual(caught.exception.reason, "SCENE_NOT_FOUND")
        with self.assertRaises(errors.InvalidRequest) as caught:
            self.localize(STEMS[0], camera=treeline.cameras.pinhole(
                500, 500, 160, 120, 320, 240))
        self.assertEqual(caught.exception.metadata["field"], "frame.camera")
        # Whether it is tried depends on how long others took.
        with self.assertRaises(errors.TreelineError) as caught:
            self.client.localize(color_file(STEMS[0]), depth_file(STEMS[0]),
                                 scene="room", time_budget_ms=1e-6)
        self.assertIn(caught.exception.reason,
                      ("DEADLINE_EXCEEDED", "DEADLINE_UNREACHABLE"))

    def test_geo_poses_are_those_of_the_server(self):
        stem = STEMS[0]
        answer = self.localize(stem)
        scene = self.client.scene("room")
        anchor = scene.geo_anchor
        self.assertEqual(anchor, treeline.GeoAnchor(48.137, 11.575, 520,
                                                    (0.8, 0, 0, 0.6)))
        # The server's is that of the camera that took the picture.
        ours = geodesy.geo_pose(scene.model.calibration.color_pose(answer),
                                anchor)
        theirs = self.post_geopose(color_file(stem), depth_file(stem))
        position = theirs["geopose"]["position"]
        # Both in 64 bits; 1e-9 degrees are 0.1 mm.
        self.assertAlmostEqual(ours.latitude_deg, position["lat"], delta=1e-10)
        self.assertAlmostEqual(ours.longitude_deg, position["lon"],
                               delta=1e-10)
        self.assertAlmostEqual(ours.height_m, position["h"], delta=1e-5)
        for axis, value in theirs["geopose"]["quaternion"].items():
            self.assertAlmostEqual(
                ours.as_json()["quaternion"][axis], value, delta=1e-12)
        position_m, orientation_deg = geodesy.accuracy(answer.covariance)
        self.assertAlmostEqual(position_m, theirs["accuracy"]["position"])
        self.assertAlmostEqual(orientation_deg,
                               theirs["accuracy"]["orientation"])

    def post_geopose(self, color, depth):
        readings = [{"timestamp": 1764000000123, "sensorId": sensor,
                     "sequenceNumber": 0, "imageFormat": kind,
                     "size": [640, 480],
                     "imageBytes": base64.b64encode(
                         file.read_bytes()).decode()}
                    for sensor, kind, file in (("color", "JPG", color),
                                               ("depth", "DEPTH", depth))]
        request = urllib.request.Request(
            f"http://{self.server.http}/geopose",
            json.dumps({"id": "1", "timestamp": 1764000000123,
                        "type": "geopose",
                        "sensors": [{"id": name, "type": "camera"}
                                    for name in ("color", "depth")],
                        "sensorReadings": {"cameraReadings": readings}}
                       ).encode(),
            {"Content-Type": "application/json",
             "Accept": "application/vnd.oscp+json;version=2.0"})
        with urllib.request.urlopen(request, timeout=60) as response:
            return json.load(response)

    def test_another_replica_answers_for_one_that_is_killed(self):
        first, second = self.start(), self.start()
        with treeline.Client([first.address, second.address],
                             timeout_s=60) as client:
            expected = client.localize(color_file(STEMS[0]),
                                       depth_file(STEMS[0]), scene="room")
            first.kill()
            for _ in range(4):
                self.assertTrue(same(expected, client.localize(
                    color_file(STEMS[0]), depth_file(STEMS[0]),
                    scene="room")))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
