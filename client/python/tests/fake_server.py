"""A server that misbehaves on demand, in this process."""

import concurrent.futures
import threading
import time

import grpc

from treeline.rpc import status_pb2
from treeline.v1 import (camera_pb2, relocalization_pb2, relocalization_pb2_grpc,
                         scenes_pb2, scenes_pb2_grpc)


def error_status(code, message, reason="", retry_after_s=None):
    """google.rpc.Status as servers send it."""
    status = status_pb2.Status(code=code.value[0], message=message)
    if reason:
        info = status_pb2.ErrorInfo(reason=reason, domain="treeline",
                                    metadata={"queue": "64"})
        status.details.add(type_url="type.googleapis.com/google.rpc.ErrorInfo",
                           value=info.SerializeToString())
    if retry_after_s is not None:
        retry = status_pb2.RetryInfo()
        retry.retry_delay.FromNanoseconds(round(retry_after_s * 1e9))
        status.details.add(type_url="type.googleapis.com/google.rpc.RetryInfo",
                           value=retry.SerializeToString())
    return status


class Failure:
    """How a call ends."""

    def __init__(self, code, message, reason="", pushback_ms=None):
        self.code = code
        self.message = message
        retry_after_s = None if pushback_ms is None else pushback_ms / 1e3
        self.trailers = [("grpc-status-details-bin", error_status(
            code, message, reason, retry_after_s).SerializeToString())]
        if pushback_ms is not None:
            self.trailers.append(("grpc-retry-pushback-ms", str(pushback_ms)))

    def end(self, context):
        context.set_trailing_metadata(self.trailers)
        context.abort(self.code, self.message)


def localized():
    """A LocalizeResponse with everything in it."""
    v1 = relocalization_pb2
    response = v1.LocalizeResponse(
        outcome=v1.OUTCOME_LOCALIZED, covariance=[1e-7 * i for i in range(36)],
        pose_sensor=2, inliers=321, samples=500, inlier_ratio=0.642,
        scene="kitchen", model_version="7", confidence=0.97,
        confidence_threshold=0.9, focal_scale=0.955,
        depth_scale=1.035,
        camera=camera_pb2.Camera(model="SIMPLE_PINHOLE", width_px=40,
                                 height_px=30, parameters=[31, 19.5, 14.5]),
        timings=v1.Timings(queue_ms=1, decode_ms=2, sample_ms=3, forest_ms=4,
                           pose_ms=5, localize_ms=6, total_ms=7))
    rotation = response.world_from_camera.rotation
    rotation.w, rotation.x, rotation.y, rotation.z = (
        0.6514121155060778, -0.75854369050178, -0.0012354997405219375,
        0.016498451813040816)
    translation = response.world_from_camera.translation_m
    translation.x, translation.y, translation.z = 1.25, 0.1, -3
    inlier = response.correspondences.add(inlier=True)
    inlier.color_pixel.x_px, inlier.color_pixel.y_px = 12.5, 3
    inlier.point_in_camera_m.z = 2
    inlier.point_in_world_m.x = 4
    response.correspondences.add().color_pixel.x_px = 99
    response.candidates.add(scene="kitchen", similarity=0.75, tried=True,
                            outcome=v1.OUTCOME_LOCALIZED, confidence=0.5,
                            inliers=321)
    response.candidates.add(scene="office")
    return response


class Service(relocalization_pb2_grpc.RelocalizationServiceServicer,
              scenes_pb2_grpc.SceneServiceServicer):
    """Ends calls with the `failures`, one a call, and then answers."""

    def __init__(self):
        self.failures = []
        self.calls = []  # time.monotonic() of each
        self.metadata = []
        self.requests = []
        self.response = None
        self.scene = None
        # Of streams: what is done before the answer to each request.
        self.before_answer = lambda request: None
        self.stream_end = None
        self.stream_ended = threading.Event()
        # Called in the middle of a call.
        self.during = lambda context: None

    def _begin(self, request, context):
        self.calls.append(time.monotonic())
        self.metadata.append(dict(context.invocation_metadata()))
        self.requests.append(request)
        self.during(context)
        if self.failures:
            self.failures.pop(0).end(context)

    def Localize(self, request, context):
        self._begin(request, context)
        if self.response is not None:
            return self.response
        return relocalization_pb2.LocalizeResponse(
            outcome=relocalization_pb2.OUTCOME_NOT_LOCALIZED, reason=2,
            scene=request.scene,
            samples=len(request.frame.color.encoded))

    def LocalizeStream(self, requests, context):
        context.add_callback(self.stream_ended.set)
        self.metadata.append(dict(context.invocation_metadata()))
        for request in requests:
            self.requests.append(request)
            result = self.before_answer(request)
            if result is None:
                result = relocalization_pb2.LocalizeStreamResponse(
                    id=request.id)
                result.response.outcome = (
                    relocalization_pb2.OUTCOME_NOT_LOCALIZED)
                result.response.samples = len(
                    request.localize.frame.color.encoded)
            yield result
        if self.stream_end is not None:
            self.stream_end.end(context)

    def ListScenes(self, request, context):
        self._begin(request, context)
        return scenes_pb2.ListScenesResponse(
            scenes=[self.scene] if self.scene else [])

    def GetScene(self, request, context):
        self._begin(request, context)
        return scenes_pb2.GetSceneResponse(
            scene=scenes_pb2.SceneInfo(scene=request.scene))

    def LoadScene(self, request, context):
        self._begin(request, context)
        return scenes_pb2.LoadSceneResponse(scene=scenes_pb2.SceneInfo(
            scene=request.scene, model_version=request.model_version))

    def UnloadScene(self, request, context):
        self._begin(request, context)
        return scenes_pb2.UnloadSceneResponse(
            scene=scenes_pb2.SceneInfo(scene=request.scene))


class Server:
    """The service on a port of 127.0.0.1."""

    def __init__(self, service=None, credentials=None, health=None):
        self.service = service or Service()
        self._grpc = grpc.server(
            concurrent.futures.ThreadPoolExecutor(8),
            options=[("grpc.so_reuseport", 0),
                     ("grpc.max_receive_message_length", 64 << 20)])
        relocalization_pb2_grpc.add_RelocalizationServiceServicer_to_server(
            self.service, self._grpc)
        scenes_pb2_grpc.add_SceneServiceServicer_to_server(self.service,
                                                           self._grpc)
        if health is not None:
            self._grpc.add_generic_rpc_handlers([health])
        if credentials is None:
            self.port = self._grpc.add_insecure_port("127.0.0.1:0")
        else:
            self.port = self._grpc.add_secure_port("127.0.0.1:0", credentials)
        self.address = f"127.0.0.1:{self.port}"
        self._grpc.start()

    def stop(self):
        self._grpc.stop(0).wait()
