"""Streams, and the newest frame of a camera."""

import os
import pathlib
import queue
import subprocess
import sys
import threading
import time
import unittest

import grpc
from fake_server import Failure, Server, error_status

import treeline
from treeline import errors
from treeline.v1 import relocalization_pb2

PATIENCE_S = 30


def jpeg(size):
    """A picture that the fake server answers with its size."""
    return b"\xff\xd8\xff" + bytes(size - 3)


class WithServer(unittest.TestCase):

    def setUp(self):
        self.server = Server()
        self.addCleanup(self.server.stop)
        self.service = self.server.service
        self.client = treeline.Client(self.server.address)
        self.addCleanup(self.client.close)


class Streams(WithServer):

    def test_all_frames_are_answered_in_their_order(self):
        answers = list(self.client.stream(
            (jpeg(3 + n) for n in range(20)), scene="room"))
        self.assertEqual([a.index for a in answers], list(range(20)))
        self.assertEqual([a.get().samples for a in answers],
                         list(range(3, 23)))
        self.assertTrue(all(a.get().round_trip_ms > 0 for a in answers))
        first, second = self.service.requests[:2]
        self.assertEqual(first.localize.scene, "room")
        self.assertEqual(self.service.metadata[0]["x-treeline-scene"], "room")
        self.assertTrue(first.HasField("settings"))
        self.assertFalse(second.HasField("settings"))

    def test_settings_and_queries_are_handed_on(self):
        list(self.client.stream(
            [treeline.Query(jpeg(3), scene="hall", seed=5), jpeg(4)],
            drop_oldest=True, max_pending=7, scene="room"))
        first, second = self.service.requests
        self.assertTrue(first.settings.drop_oldest)
        self.assertEqual(first.settings.max_pending, 7)
        self.assertEqual(first.localize.scene, "hall")
        self.assertEqual(first.localize.options.seed, 5)
        self.assertEqual(second.localize.scene, "room")

    def test_no_frames_no_answers(self):
        self.assertEqual(list(self.client.stream([])), [])

    def test_a_frame_that_fails_ends_nothing_but_itself(self):
        def before(request):
            if request.id != 1:
                return None
            response = relocalization_pb2.LocalizeStreamResponse(id=1)
            response.error.CopyFrom(error_status(
                grpc.StatusCode.ABORTED, "dropped", "FRAME_DROPPED"))
            return response

        self.service.before_answer = before
        answers = list(self.client.stream([jpeg(3)] * 3))
        self.assertEqual([a.error is None for a in answers],
                         [True, False, True])
        self.assertIsNone(answers[1].answer)
        with self.assertRaises(errors.Aborted) as caught:
            answers[1].get()
        self.assertEqual(caught.exception.reason, "FRAME_DROPPED")

    def test_an_answer_that_is_none_is_an_error_of_its_frame(self):
        self.service.before_answer = lambda request: (
            relocalization_pb2.LocalizeStreamResponse(id=request.id))
        answer, = self.client.stream([jpeg(3)])
        self.assertIsInstance(answer.error, errors.InternalError)

    def test_an_answer_to_another_frame_ends_the_stream(self):
        self.service.before_answer = lambda request: (
            relocalization_pb2.LocalizeStreamResponse(id=7))
        with self.assertRaisesRegex(errors.InternalError, "frame 7"):
            list(self.client.stream([jpeg(3)]))

    def test_a_server_that_stops_ends_the_stream_after_its_answers(self):
        self.service.stream_end = Failure(
            grpc.StatusCode.UNAVAILABLE, "stopping", "DRAINING")
        stream = self.client.stream([jpeg(3)] * 2)
        self.assertEqual([next(stream).index, next(stream).index], [0, 1])
        with self.assertRaises(errors.Unavailable) as caught:
            next(stream)
        self.assertEqual(caught.exception.reason, "DRAINING")

    def test_what_the_frames_raise_comes_after_their_answers(self):
        def frames():
            yield jpeg(3)
            raise OSError("the camera is gone")

        stream = self.client.stream(frames())
        self.assertEqual(next(stream).index, 0)
        with self.assertRaisesRegex(OSError, "the camera is gone"):
            next(stream)

    def test_a_frame_that_is_none_is_refused(self):
        stream = self.client.stream([jpeg(3), b"GIF89a"])
        self.assertEqual(next(stream).index, 0)
        with self.assertRaisesRegex(ValueError, "not a JPEG"):
            next(stream)

    def test_closing_cancels_on_the_server(self):
        left = threading.Event()

        def frames():
            yield jpeg(3)
            left.wait(PATIENCE_S)
            yield jpeg(3)

        stream = self.client.stream(frames())
        next(stream)
        stream.close()
        self.assertTrue(self.service.stream_ended.wait(PATIENCE_S))
        left.set()
        self.assertEqual(list(stream), [])

    def test_the_timeout_is_of_the_whole_stream(self):
        left = threading.Event()

        def frames():
            yield jpeg(3)
            left.wait(PATIENCE_S)

        stream = self.client.stream(frames(), timeout_s=0.3)
        next(stream)
        with self.assertRaisesRegex(errors.DeadlineExceeded, "within 0.3 s"):
            next(stream)
        left.set()

    def test_frames_are_not_read_far_ahead(self):
        # 64 frames of 1 MiB to a server that takes none.
        taken, hold = [], threading.Event()

        def frames():
            for n in range(64):
                taken.append(n)
                yield jpeg(1 << 20)

        self.service.before_answer = lambda request: (
            hold.wait(PATIENCE_S) and None)
        stream = self.client.stream(frames())
        threading.Timer(1.0, hold.set).start()
        next(stream)
        self.assertLess(len(taken), 64)
        stream.close()


class Latest(WithServer):

    def test_frames_that_come_meanwhile_are_dropped(self):
        camera = queue.Queue()
        asked, answered = threading.Event(), threading.Event()

        def during(_):
            asked.set()
            answered.wait(PATIENCE_S)

        self.service.during = during
        seen = []

        def frames():
            yield jpeg(3)
            asked.wait(PATIENCE_S)
            for size in range(4, 9):
                yield jpeg(size)
            # All were taken; only the last of them is kept.
            answered.set()
            camera.get(timeout=PATIENCE_S)

        for answer in self.client.localize_latest(frames(), scene="room"):
            seen.append((answer.index, answer.get().samples))
            if len(seen) == 2:
                camera.put(None)
        self.assertEqual(seen, [(0, 3), (5, 8)])
        self.assertEqual(len(self.service.requests), 2)

    def test_the_last_frame_is_answered(self):
        answers = list(self.client.localize_latest([jpeg(3), jpeg(4)]))
        self.assertEqual(answers[-1].index, 1)
        self.assertEqual(answers[-1].get().samples, 4)

    def test_calls_are_tried_again_and_failures_are_answers(self):
        self.service.failures = [
            Failure(grpc.StatusCode.UNAVAILABLE, "overloaded"),
            Failure(grpc.StatusCode.NOT_FOUND, "no such scene",
                    "SCENE_NOT_FOUND")]
        answer, = self.client.localize_latest([jpeg(3)])
        self.assertIsInstance(answer.error, errors.NotFound)
        self.assertEqual(len(self.service.calls), 2)

    def test_what_the_frames_raise_is_raised(self):
        def frames():
            yield jpeg(3)
            raise OSError("the camera is gone")

        with self.assertRaisesRegex(OSError, "the camera is gone"):
            list(self.client.localize_latest(frames()))

    def test_closing_ends_the_thread_with_the_next_frame(self):
        go_on, ended = threading.Event(), threading.Event()

        def frames():
            try:
                yield jpeg(3)
                go_on.wait(PATIENCE_S)
                yield jpeg(3)
                self.fail("a further frame was read")
            finally:
                ended.set()

        latest = self.client.localize_latest(frames())
        self.assertEqual(next(latest).index, 0)
        latest.close()
        go_on.set()
        self.assertTrue(ended.wait(PATIENCE_S))

    def test_a_program_ends_while_a_camera_blocks(self):
        code = ("import treeline, time\n"
                "def frames():\n"
                f"    yield {jpeg(3)!r}\n"
                "    time.sleep(600)\n"
                f"with treeline.Client({self.server.address!r}) as client:\n"
                "    for kind in (client.localize_latest, client.stream):\n"
                "        for answer in kind(frames()):\n"
                "            print(answer.index)\n"
                "            break\n")
        start = time.monotonic()
        done = subprocess.run([sys.executable, "-c", code], text=True,
                              stdout=subprocess.PIPE, timeout=PATIENCE_S,
                              check=True, env={**os.environ, "PYTHONPATH": str(
                                  pathlib.Path(treeline.__file__).parents[1])})
        self.assertEqual(done.stdout, "0\n0\n")
        self.assertLess(time.monotonic() - start, PATIENCE_S)


if __name__ == "__main__":
    unittest.main()
