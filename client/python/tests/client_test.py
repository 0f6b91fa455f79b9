"""Calls against a server that misbehaves on demand."""

import pathlib
import sys
import tempfile
import threading
import time
import types
import unittest
from unittest import mock

import grpc
import numpy as np
from fake_server import Failure, Server, localized

import treeline
from treeline import errors
from treeline.v1 import relocalization_pb2, scenes_pb2

JPEG = b"\xff\xd8\xff rest"
TRACEPARENT = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"
OVERLOADED = Failure(grpc.StatusCode.UNAVAILABLE, "overloaded", "QUEUE_FULL")


class WithServer(unittest.TestCase):

    def setUp(self):
        self.server = Server()
        self.addCleanup(self.server.stop)
        self.service = self.server.service
        self.client = self.connect()

    def connect(self, *targets, **options):
        client = treeline.Client(list(targets) or self.server.address,
                                 **options)
        self.addCleanup(client.close)
        return client


class Answers(WithServer):

    def test_keep_every_field_bit_for_bit(self):
        self.service.response = localized()
        answer = self.client.localize(JPEG, want_correspondences=True)
        self.assertTrue(answer)
        self.assertTrue(answer.localized)
        self.assertIsNone(answer.reason)
        np.testing.assert_array_equal(answer.rotation_wxyz, [
            0.6514121155060778, -0.75854369050178, -0.0012354997405219375,
            0.016498451813040816])
        np.testing.assert_array_equal(answer.position_in_world_m,
                                      [1.25, 0.1, -3])
        np.testing.assert_array_equal(answer.world_from_camera[:3, 3],
                                      [1.25, 0.1, -3])
        np.testing.assert_array_equal(answer.world_from_camera[3], [0, 0, 0, 1])
        np.testing.assert_array_equal(
            answer.covariance, 1e-7 * np.arange(36).reshape(6, 6))
        self.assertEqual(answer.pose_sensor, "DEPTH")
        self.assertEqual((answer.inliers, answer.samples), (321, 500))
        self.assertEqual(answer.inlier_ratio, 0.642)
        self.assertEqual((answer.confidence, answer.confidence_threshold),
                         (0.97, 0.9))
        self.assertEqual(answer.focal_scale, 0.955)
        self.assertEqual(answer.camera.model, "SIMPLE_PINHOLE")
        self.assertEqual(tuple(answer.camera.parameters), (31, 19.5, 14.5))
        self.assertEqual(answer.depth_scale, 1.035)
        self.assertEqual((answer.scene, answer.model_version), ("kitchen", "7"))
        self.assertEqual(answer.timings,
                         treeline.Timings(1, 2, 3, 4, 5, 6, 7))
        np.testing.assert_array_equal(answer.inlier_pixels, [[12.5, 3]])
        samples = answer.correspondences
        np.testing.assert_array_equal(samples.inlier, [True, False])
        np.testing.assert_array_equal(samples.points_in_camera_m,
                                      [[0, 0, 2], [0, 0, 0]])
        np.testing.assert_array_equal(samples.points_in_world_m,
                                      [[4, 0, 0], [0, 0, 0]])
        self.assertEqual(answer.candidates, (
            treeline.SceneCandidate("kitchen", 0.75, True, True, 0.5, 321),
            treeline.SceneCandidate("office", 0, False, False, 0, 0)))
        self.assertGreater(answer.round_trip_ms, 0)

    def test_the_scene_is_named_for_balancers(self):
        self.client.localize(JPEG, scene="kitchen-2.new_1")
        self.client.scene("office")
        self.assertEqual([m.get("x-treeline-scene")
                          for m in self.service.metadata],
                         ["kitchen-2.new_1", "office"])

    def test_calls_belong_to_the_trace_of_their_program(self):
        told = ["", "odd\n", None, TRACEPARENT + "\n",
                treeline.tracing.new_traceparent(), TRACEPARENT]
        given = iter(told)
        with treeline.Client(self.server.address,
                             traceparent=lambda: next(given)) as client:
            for _ in told:
                client.localize(JPEG, scene="kitchen")
        self.assertEqual([m.get("traceparent") for m in self.service.metadata],
                         [None] * 4 + told[4:])

    def test_opentelemetrys_current_span_is_told_where_there_is_one(self):
        self.client.localize(JPEG, scene="kitchen")
        # As the package opentelemetry-api has it.
        propagate = types.ModuleType("opentelemetry.propagate")
        propagate.inject = lambda carrier: carrier.update(
            traceparent=TRACEPARENT)
        with mock.patch.dict(sys.modules,
                             {"opentelemetry.propagate": propagate}):
            self.client.localize(JPEG, scene="kitchen")
        self.assertEqual([m.get("traceparent") for m in self.service.metadata],
                         [None, TRACEPARENT])

    def test_new_traces_are_new(self):
        made = {treeline.tracing.new_traceparent() for _ in range(100)}
        self.assertEqual(len(made), 100)
        for traceparent in made:
            self.assertTrue(treeline.tracing.is_traceparent(traceparent))
            self.assertTrue(traceparent.endswith("-01"))
        self.assertTrue(
            treeline.tracing.new_traceparent(sampled=False).endswith("-00"))

    def test_what_is_no_scene_name_is_in_the_request_alone(self):
        for scene in (None, "", "a b", "k\u00fcche", "a\nb", "x" * 129):
            self.client.localize(JPEG, scene=scene)
            self.assertNotIn("x-treeline-scene", self.service.metadata[-1])
            self.assertEqual(self.service.requests[-1].scene, scene or "")

    def test_not_localized_is_an_answer(self):
        answer = self.client.localize(JPEG, scene="kitchen")
        self.assertFalse(answer)
        self.assertEqual(answer.reason, "TOO_FEW_INLIERS")
        self.assertEqual(answer.scene, "kitchen")
        self.assertIsNone(answer.world_from_camera)
        self.assertIsNone(answer.covariance)
        self.assertIsNone(answer.inlier_pixels)

    def test_a_reason_of_a_newer_server_is_its_number(self):
        self.service.response = relocalization_pb2.LocalizeResponse(
            outcome=2, reason=42)
        self.assertEqual(self.client.localize(JPEG).reason, "42")

    # A pose that is none must never reach a robot as if it were one.
    def test_a_server_that_breaks_the_contract_is_an_error(self):
        def nan_position(r):
            r.world_from_camera.translation_m.x = float("nan")

        def nan_covariance(r):
            r.covariance[0] = float("nan")

        for field, change in (
                ("world_from_camera", lambda r: r.ClearField(
                    "world_from_camera")),
                ("world_from_camera", nan_position),
                ("covariance", lambda r: r.covariance.pop()),
                ("covariance", nan_covariance),
                ("pose_sensor", lambda r: r.ClearField("pose_sensor")),
                ("outcome", lambda r: r.ClearField("outcome"))):
            self.service.response = localized()
            change(self.service.response)
            with self.assertRaisesRegex(errors.InternalError, field):
                self.client.localize(JPEG)

    def test_scenes_keep_every_field(self):
        info = scenes_pb2.SceneInfo(
            scene="kitchen", state=3, model_version="2",
            display_name="The kitchen", resident_bytes=6_000_000_000,
            versions=[scenes_pb2.ModelVersion(version=v) for v in "21"])
        info.geo_anchor.latitude_deg = 48
        info.geo_anchor.height_m = 520
        model = info.model
        model.method, model.dataset = "rgbd", "7scenes:kitchen"
        model.leaves, model.training_frames = 500_001, 500
        calibration = model.calibration
        calibration.color_from_depth.rotation.w = 1
        calibration.color_from_depth.translation_m.x = 0.025
        calibration.depth_scale, calibration.pose_sensor = 1.01, 2
        camera = calibration.color
        camera.model, camera.width_px, camera.height_px = "PINHOLE", 640, 480
        camera.parameters.extend([525, 526, 319.5, 239.5])
        model.bounds_max_in_world_m.z = 2.5
        self.service.scene = info
        scene, = self.client.scenes()
        self.assertEqual((scene.name, scene.state, scene.failure),
                         ("kitchen", "READY", ""))
        self.assertEqual((scene.model_version, scene.versions),
                         ("2", ("2", "1")))
        self.assertEqual(scene.display_name, "The kitchen")
        self.assertEqual(scene.resident_bytes, 6_000_000_000)
        self.assertEqual(scene.geo_anchor, treeline.GeoAnchor(48, 0, 520))
        self.assertIsNone(scene.default_camera)
        self.assertEqual((scene.model.method, scene.model.leaves,
                          scene.model.training_frames), ("rgbd", 500_001, 500))
        calibration = scene.model.calibration
        self.assertEqual(calibration.color, treeline.Camera(
            "PINHOLE", 640, 480, (525, 526, 319.5, 239.5)))
        self.assertIsNone(calibration.depth)
        self.assertEqual(calibration.color_from_depth[0, 3], 0.025)
        self.assertEqual((calibration.depth_scale, calibration.pose_sensor),
                         (1.01, "DEPTH"))
        self.assertEqual(scene.model.bounds_max_in_world_m, (0, 0, 2.5))

    def test_the_colour_cameras_pose_is_that_of_either_sensor(self):
        calibration = treeline.Calibration(
            treeline.cameras.pinhole(1, 1, 1, 1, 2, 2), None,
            treeline.geometry.pose([1, 0, 0, 0], [0.025, 0, 0]), 1, "DEPTH")
        self.service.response = localized()
        answer = self.client.localize(JPEG)
        expected = answer.world_from_camera.copy()
        expected[:3, 3] -= 0.025 * expected[:3, 0]
        np.testing.assert_allclose(calibration.color_pose(answer), expected)
        self.service.response.pose_sensor = 1
        answer = self.client.localize(JPEG)
        np.testing.assert_array_equal(calibration.color_pose(answer),
                                      answer.world_from_camera)
        self.service.response = None
        with self.assertRaisesRegex(ValueError, "not localized"):
            calibration.color_pose(self.client.localize(JPEG))

    def test_scenes_that_failed_say_why(self):
        self.service.scene = scenes_pb2.SceneInfo(
            scene="kitchen", state=4, failure=scenes_pb2.LoadFailure(
                code="DATA_LOSS", message="checksum differs"))
        scene, = self.client.scenes()
        self.assertEqual(scene.state, "FAILED")
        self.assertEqual(scene.failure, "DATA_LOSS: checksum differs")
        self.assertIsNone(scene.model)

    def test_one_scene_is_asked_for_loaded_and_unloaded(self):
        self.assertEqual(self.client.scene("attic").name, "attic")
        self.assertEqual(self.client.load_scene("attic", "3").model_version,
                         "3")
        self.assertEqual(self.client.unload_scene("attic").name, "attic")

    def test_health_is_asked_under_the_standard_name(self):
        asked = []

        class Health(grpc.GenericRpcHandler):
            def service(self, details):
                if details.method != "/grpc.health.v1.Health/Check":
                    return None

                def check(request, _):
                    asked.append(request)
                    return b"\x08\x01" if request == b"" else b"\x08\x02"
                return grpc.unary_unary_rpc_method_handler(check)

        server = Server(health=Health())
        self.addCleanup(server.stop)
        client = self.connect(server.address)
        self.assertEqual(client.health(), "SERVING")
        self.assertEqual(client.health("room"), "NOT_SERVING")
        # Field 1, a text of 19 bytes, as grpc.health.v1 has it.
        self.assertEqual(asked, [b"", b"\x0a\x13treeline.scene.room"])


class Tries(WithServer):

    def test_again_while_the_server_is_unavailable(self):
        self.service.failures = [OVERLOADED, OVERLOADED]
        self.assertFalse(self.client.localize(JPEG))
        self.assertEqual(len(self.service.calls), 3)

    def test_again_when_the_server_cancels(self):
        self.service.failures = [Failure(grpc.StatusCode.CANCELLED, "down")]
        self.assertFalse(self.client.localize(JPEG))
        self.assertEqual(len(self.service.calls), 2)

    def test_again_with_large_requests_too(self):
        self.service.failures = [OVERLOADED]
        self.client.localize(JPEG + bytes(8 << 20))
        self.assertEqual(len(self.service.calls), 2)

    def test_again_after_the_servers_pushback(self):
        self.service.failures = [Failure(
            grpc.StatusCode.UNAVAILABLE, "overloaded", "QUEUE_FULL", 700)]
        self.client.localize(JPEG)
        first, second = self.service.calls
        # Without the pushback it would be 50 ms, give or take a fifth.
        self.assertGreaterEqual(second - first, 0.69)

    def test_not_at_all_if_the_server_says_so(self):
        self.service.failures = [Failure(
            grpc.StatusCode.UNAVAILABLE, "overloaded", "QUEUE_FULL", -1)]
        with self.assertRaises(errors.Unavailable):
            self.client.localize(JPEG)
        self.assertEqual(len(self.service.calls), 1)

    def test_end_after_four(self):
        self.service.failures = [Failure(
            grpc.StatusCode.UNAVAILABLE, "overloaded", "QUEUE_FULL", 20)] * 9
        with self.assertRaises(errors.Unavailable) as caught:
            self.client.localize(JPEG)
        self.assertEqual(len(self.service.calls), 4)
        self.assertEqual(caught.exception.message, "overloaded")
        self.assertEqual(caught.exception.reason, "QUEUE_FULL")
        self.assertEqual(caught.exception.metadata, {"queue": "64"})
        self.assertAlmostEqual(caught.exception.retry_after_s, 0.02)
        self.assertEqual(str(caught.exception),
                         "UNAVAILABLE (QUEUE_FULL): overloaded")

    def test_one_is_one(self):
        client = self.connect(max_attempts=1)
        self.service.failures = [OVERLOADED]
        with self.assertRaises(errors.Unavailable):
            client.localize(JPEG)
        self.assertEqual(len(self.service.calls), 1)

    def test_not_again_after_other_errors(self):
        for code, kind in (
                (grpc.StatusCode.INVALID_ARGUMENT, errors.InvalidRequest),
                (grpc.StatusCode.NOT_FOUND, errors.NotFound),
                (grpc.StatusCode.FAILED_PRECONDITION,
                 errors.FailedPrecondition),
                (grpc.StatusCode.DATA_LOSS, errors.DataLoss),
                (grpc.StatusCode.RESOURCE_EXHAUSTED, errors.ResourceExhausted),
                (grpc.StatusCode.UNAUTHENTICATED, errors.Unauthenticated),
                (grpc.StatusCode.PERMISSION_DENIED, errors.PermissionDenied),
                (grpc.StatusCode.ABORTED, errors.Aborted),
                (grpc.StatusCode.INTERNAL, errors.InternalError),
                (grpc.StatusCode.OUT_OF_RANGE, errors.TreelineError)):
            self.service.calls.clear()
            self.service.failures = [Failure(code, "frame.color: missing")]
            with self.assertRaises(errors.TreelineError) as caught:
                self.client.localize(JPEG)
            self.assertIs(type(caught.exception), kind)
            self.assertEqual(caught.exception.code, code.name)
            self.assertEqual(caught.exception.message, "frame.color: missing")
            self.assertEqual(len(self.service.calls), 1)

    def test_the_timeout_is_of_all_tries_together(self):
        self.service.failures = [Failure(
            grpc.StatusCode.UNAVAILABLE, "overloaded", "QUEUE_FULL", 400)] * 9
        start = time.monotonic()
        with self.assertRaises(errors.TreelineError) as caught:
            self.client.localize(JPEG, timeout_s=0.6)
        self.assertIn(caught.exception.code, ("DEADLINE_EXCEEDED",
                                              "UNAVAILABLE"))
        self.assertLess(time.monotonic() - start, 3)
        self.assertLessEqual(len(self.service.calls), 2)

    def test_the_timeout_ends_the_call_and_says_so(self):
        gave_up = threading.Event()
        self.service.during = lambda context: gave_up.wait(30)
        with self.assertRaisesRegex(
                errors.DeadlineExceeded,
                f"no answer from {self.server.address} within 0.2 s"):
            self.connect(timeout_s=0.2).localize(JPEG)
        gave_up.set()

    def test_a_request_over_the_limit_is_not_sent(self):
        client = self.connect(max_message_mib=1)
        with self.assertRaises(errors.ResourceExhausted):
            client.localize(JPEG + bytes(2 << 20))
        self.assertEqual(self.service.calls, [])


class Replicas(WithServer):

    def setUp(self):
        super().setUp()
        self.other = Server()
        self.addCleanup(self.other.stop)

    def test_are_asked_in_turn(self):
        client = self.connect(self.server.address, self.other.address)
        self.wait_for_both(client)
        before = len(self.service.calls), len(self.other.service.calls)
        for _ in range(10):
            client.localize(JPEG)
        self.assertEqual(len(self.service.calls) - before[0], 5)
        self.assertEqual(len(self.other.service.calls) - before[1], 5)

    def wait_for_both(self, client):
        for _ in range(1000):
            client.localize(JPEG)
            if self.service.calls and self.other.service.calls:
                return
        self.fail("one of two servers was never asked")

    def test_one_that_fails_is_replaced_by_the_other(self):
        client = self.connect(f"{self.server.address},{self.other.address}")
        self.wait_for_both(client)
        self.service.failures = [OVERLOADED] * 100
        before = len(self.other.service.calls)
        for _ in range(10):
            client.localize(JPEG)
        self.assertEqual(len(self.other.service.calls) - before, 10)

    def test_one_that_is_gone_is_replaced_by_the_other(self):
        client = self.connect(self.server.address, self.other.address)
        self.wait_for_both(client)
        self.server.stop()
        for _ in range(10):
            client.localize(JPEG)

    def test_none_is_unavailable_and_named(self):
        self.server.stop()
        with self.assertRaisesRegex(errors.Unavailable, self.server.address):
            self.client.localize(JPEG)


class Tokens(WithServer):

    def shown(self, client):
        client.localize(JPEG)
        return self.service.metadata[-1].get("authorization")

    def test_none_a_fixed_one_and_one_for_each_call(self):
        self.assertIsNone(self.shown(self.client))
        self.assertEqual(self.shown(self.connect(token=" abc\n")), "Bearer abc")
        tokens = iter(["one", "two"])
        client = self.connect(token=lambda: next(tokens))
        self.assertEqual(self.shown(client), "Bearer one")
        self.assertEqual(self.shown(client), "Bearer two")

    def test_a_file_is_read_again_when_it_changes(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "token"
            path.write_text("first\n")
            client = self.connect(token=path)
            self.assertEqual(self.shown(client), "Bearer first")
            path.write_text("second token".replace(" ", "-"))
            self.assertEqual(self.shown(client), "Bearer second-token")
            # Whoever renews it may be in the middle of it.
            path.write_text("")
            self.assertEqual(self.shown(client), "Bearer second-token")
            path.unlink()
            self.assertEqual(self.shown(client), "Bearer second-token")
            path.write_text("third")
            self.assertEqual(self.shown(client), "Bearer third")

    def test_what_is_no_token_is_refused_without_showing_it(self):
        for token, why in (("", "no token"), ("se cret", "not one token")):
            with self.assertRaisesRegex(ValueError, why) as caught:
                self.connect(token=token)
            self.assertNotIn("cret", str(caught.exception))
        with self.assertRaises(FileNotFoundError):
            self.connect(token=pathlib.Path("/nowhere/token"))
        with self.assertRaisesRegex(TypeError, "not bytes"):
            self.connect(token=b"abc")

    def test_are_not_sent_in_the_clear_to_other_machines(self):
        for target in ("example.org:1", "dns:///example.org:1", "10.0.0.1:1",
                       ["127.0.0.1:1", "10.0.0.1:1"], "127.evil.org:1"):
            with self.assertRaisesRegex(ValueError, "in the clear; use TLS"):
                treeline.Client(target, token="abc")
        for target in ("localhost:1", "[::1]:1", "dns:///localhost:1",
                       "unix:/tmp/a", "127.0.0.1:1,127.0.0.2:1"):
            treeline.Client(target, token="abc").close()


class Proxies(WithServer):

    def test_are_not_asked_for_this_machine(self):
        self.service.response = localized()
        with mock.patch.dict("os.environ", http_proxy="http://127.0.0.1:1"):
            self.assertTrue(self.connect().localize(JPEG))


class Options(unittest.TestCase):

    def test_of_several_servers_only_addresses_are_taken(self):
        for targets, why in (("", "no server given"), ([], "no server given"),
                             ("127.0.0.1:1,", "no server given"),
                             ("127.0.0.1,127.0.0.2:1", "has no port"),
                             ("a:1,b:1", "dns:///NAME:PORT"),
                             ("127.0.0.1:1,[::1]:1", "one family")):
            with self.assertRaisesRegex(ValueError, why):
                treeline.Client(targets)
        treeline.Client("[::1]:1,[::2]:1").close()

    def test_one_server_has_a_port_and_is_no_web_address(self):
        for target, why in (("127.0.0.1", "127.0.0.1:50051"),
                            ("robot:", "robot:50051"),
                            ("http://127.0.0.1:8080", "a web address")):
            with self.assertRaisesRegex(ValueError, why):
                treeline.Client(target)
        for target in ("robot:1", "dns:///robot", "unix:///tmp/a"):
            treeline.Client(target).close()

    def test_numbers_have_ranges(self):
        for options in ({"timeout_s": 0}, {"max_attempts": 0},
                        {"max_attempts": 6}, {"max_message_mib": 0}):
            with self.assertRaisesRegex(ValueError, next(iter(options))):
                treeline.Client("127.0.0.1:1", **options)


class Closing(WithServer):

    def test_a_closed_client_refuses_calls(self):
        with self.connect() as client:
            client.localize(JPEG)
        client.close()
        with self.assertRaisesRegex(RuntimeError, "closed"):
            client.localize(JPEG)

    def test_closing_cancels_what_waits(self):
        begun, gave_up = threading.Event(), threading.Event()

        def during(_):
            begun.set()
            gave_up.wait(30)

        self.service.during = during
        raised = []

        def ask():
            try:
                self.client.localize(JPEG)
            except errors.TreelineError as error:
                raised.append(error)

        thread = threading.Thread(target=ask)
        thread.start()
        begun.wait(30)
        self.client.close()
        thread.join(30)
        gave_up.set()
        self.assertEqual([type(e) for e in raised], [errors.Cancelled])

    def test_threads_share_a_client(self):
        answers = []

        def ask(size):
            for _ in range(20):
                answer = self.client.localize(JPEG + bytes(size))
                answers.append(answer.samples == len(JPEG) + size)

        threads = [threading.Thread(target=ask, args=(n,)) for n in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(answers, [True] * 160)


if __name__ == "__main__":
    unittest.main()
