"""Asking Treeline servers where a camera is."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

import grpc
from google.protobuf import wrappers_pb2

from treeline import errors, streams
from treeline.answer import (Answer, Scene, StreamAnswer, answer_of, scene_of)
from treeline.channel import Connection, Stubs
from treeline.images import Image
from treeline.options import Tls, Token
from treeline.query import Depth, Query, request_of
from treeline.v1 import scenes_pb2

# grpc.health.v1, whose .proto Debian does not ship: its request is one string
# and its answer one number, as these are on the wire.
_HEALTH_CHECK = "/grpc.health.v1.Health/Check"
_HEALTH_STATES = ("UNKNOWN", "SERVING", "NOT_SERVING", "SERVICE_UNKNOWN")


class Client:
    """A connection to one or several servers. It connects when it is first
    needed, and again whenever it breaks: that a server is not there yet is no
    error here.

    targets: "HOST:PORT"; several servers by their IP addresses with ports, as a
      list or with commas, in turn; one name with several addresses:
      "dns:///NAME:PORT".
    token: a bearer token (str), a file that holds it (pathlib.Path, read again
      when it changes), or a callable that gives it for each call. It is not
      sent without TLS, but to this machine.
    tls: certificates; None: no TLS.
    timeout_s: for each whole call, tries included, unless the call has its own.
    max_attempts: how often a call is tried, 1 to 5, while the server answers
      UNAVAILABLE or cancels. The waits grow from 50 ms to 1 s, or are what the
      server asks for. Requests over 16 MiB are not tried again.
    max_message_mib: largest request and answer, 1 to 1024.
    traceparent: gives the span that a call belongs to, as W3C has it
      (treeline.tracing.new_traceparent() makes one); asked at each call, and
      what is none is left out. None: OpenTelemetry's current span, where the
      program uses that.

    ValueError, OSError: what is wrong with an option or with a file of a
    certificate or token. All methods raise errors.TreelineError, block, and may
    be called by several threads at once. Use it in a `with`, or close() it.
    """

    def __init__(self, targets: str | Sequence[str], *,
                 token: Token | None = None, tls: Tls | None = None,
                 timeout_s: float = 10.0, max_attempts: int = 4,
                 max_message_mib: int = 32,
                 traceparent: Callable[[], str | None] | None = None) -> None:
        if not timeout_s > 0:
            raise ValueError(f"timeout_s is {timeout_s}; it must be positive")
        self._timeout_s = timeout_s
        self._connection = Connection(targets, token, tls, max_attempts,
                                      max_message_mib, traceparent)

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the connections; calls that wait raise errors.Cancelled, and
        later ones RuntimeError."""
        self._connection.close()

    def _call(self, method: Callable[[Stubs], Any], request: Any,
              timeout_s: float | None, scene: str | None = None) -> Any:
        timeout_s = self._timeout_s if timeout_s is None else timeout_s
        with self._connection.stubs() as stubs:
            try:
                return method(stubs)(request, timeout=timeout_s,
                                     metadata=self._connection.metadata(scene))
            except grpc.RpcError as error:
                raise errors.from_rpc_error(error, self._connection.servers,
                                            timeout_s) from None

    def localize(self, image: Image, depth: Depth | Image | None = None, *,
                 timeout_s: float | None = None, **fields: Any) -> Answer:
        """Where was this image taken? The fields are those of Query:

            answer = client.localize(rgb, depth, scene="room")
            if answer:
                print(answer.world_from_camera, answer.confidence)
            else:
                print(answer.reason)

        "Not localized" is an answer, not an error."""
        return self.ask(Query(image, depth, **fields), timeout_s=timeout_s)

    def ask(self, query: Query, *, timeout_s: float | None = None) -> Answer:
        """localize() of a Query."""
        start = time.monotonic()
        response = self._call(lambda stubs: stubs.relocalization.Localize,
                              request_of(query), timeout_s, query.scene)
        return answer_of(response, (time.monotonic() - start) * 1e3,
                         query.want_correspondences)

    def stream(self, frames: Iterable[Query | Image], *,
               drop_oldest: bool = False, max_pending: int = 0,
               timeout_s: float | None = None,
               **fields: Any) -> Iterator[StreamAnswer]:
        """Answers all frames over one call, in their order; up to max_pending
        of them (1 to 64; 0: 4) are computed side by side.

        frames: Query objects, or images that all have the `fields` of Query. It
          is read by a thread of gRPC, as fast as the server takes frames. With
          drop_oldest the server always takes them, and of those that wait it
          drops the oldest: errors.Aborted, reason FRAME_DROPPED.
        timeout_s: of the whole stream; None: none.

        A generator: the stream begins with the first next() and is cancelled by
        close(), also if the loop is left. A frame that fails ends nothing but
        itself; StreamAnswer.get() raises its error. A stream that breaks raises
        errors.TreelineError, and is not tried again. What `frames` raises is
        raised after the answers to what it gave before."""
        return streams.stream(self._connection, frames, fields, drop_oldest,
                              max_pending, timeout_s)

    def localize_latest(self, frames: Iterable[Query | Image], *,
                        timeout_s: float | None = None,
                        **fields: Any) -> Iterator[StreamAnswer]:
        """Always answers the newest frame; those that come while it waits for
        an answer are dropped, and never sent. For live cameras: `index` of an
        answer says which frame it belongs to. The last frame is always
        answered.

        frames, fields: as in stream(); read by a thread of its own.
        timeout_s: of each call. Calls are tried again like those of localize();
          those that fail are StreamAnswers with an error.

        A generator; after close() that thread ends with the next frame."""
        return streams.localize_latest(
            lambda query: self.ask(query, timeout_s=timeout_s), frames, fields)

    def scenes(self, *, timeout_s: float | None = None) -> list[Scene]:
        """Every scene of the server, by name."""
        response = self._call(lambda stubs: stubs.scenes.ListScenes,
                              scenes_pb2.ListScenesRequest(), timeout_s)
        return [scene_of(info) for info in response.scenes]

    def scene(self, name: str, *, timeout_s: float | None = None) -> Scene:
        """One scene; errors.NotFound."""
        return scene_of(self._call(
            lambda stubs: stubs.scenes.GetScene,
            scenes_pb2.GetSceneRequest(scene=name), timeout_s, name).scene)

    def load_scene(self, name: str, model_version: str = "", *,
                   timeout_s: float | None = None) -> Scene:
        """Loads a version now ("": the newest). For administrators."""
        return scene_of(self._call(
            lambda stubs: stubs.scenes.LoadScene, scenes_pb2.LoadSceneRequest(
                scene=name, model_version=model_version), timeout_s,
            name).scene)

    def unload_scene(self, name: str, model_version: str = "", *,
                     timeout_s: float | None = None) -> Scene:
        """Takes a version ("": all) out of memory. For administrators."""
        return scene_of(self._call(
            lambda stubs: stubs.scenes.UnloadScene,
            scenes_pb2.UnloadSceneRequest(
                scene=name, model_version=model_version), timeout_s,
            name).scene)

    def health(self, scene: str | None = None, *,
               timeout_s: float | None = None) -> str:
        """"SERVING", "NOT_SERVING" or "UNKNOWN", of the whole server or of one
        scene; errors.NotFound for a scene that is not there. It is asked once,
        without further tries."""
        service = "" if scene is None else f"treeline.scene.{scene}"
        response = self._call(
            lambda stubs: stubs.channel.unary_unary(
                _HEALTH_CHECK,
                request_serializer=wrappers_pb2.StringValue.SerializeToString,
                response_deserializer=wrappers_pb2.Int32Value.FromString),
            wrappers_pb2.StringValue(value=service), timeout_s)
        if not 0 <= response.value < len(_HEALTH_STATES):
            return str(response.value)
        return _HEALTH_STATES[response.value]
