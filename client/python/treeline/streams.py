"""Frames one after the other: all of them, or always the newest."""

from __future__ import annotations

import collections
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import grpc

from treeline import errors
from treeline.answer import Answer, StreamAnswer, answer_of
from treeline.channel import Connection
from treeline.images import Image
from treeline.query import Query, query_of, request_of
from treeline.v1 import relocalization_pb2


class _Requests:
    """The requests of a stream, made of frames in gRPC's own thread, and what
    of them has no answer yet."""

    def __init__(self, frames: Iterable[Query | Image], fields: dict[str, Any],
                 settings: relocalization_pb2.StreamSettings) -> None:
        self._frames = frames
        self._fields = fields
        self._settings = settings
        # (time of sending, whether correspondences are wanted)
        self.unanswered: collections.deque[tuple[float, bool]] = (
            collections.deque())
        # What `frames` raised, or what was wrong with one of them.
        self.failure: BaseException | None = None

    def __iter__(self) -> Iterator[relocalization_pb2.LocalizeStreamRequest]:
        try:
            for index, frame in enumerate(self._frames):
                query = query_of(frame, self._fields)
                request = relocalization_pb2.LocalizeStreamRequest(
                    id=index, localize=request_of(query),
                    settings=self._settings if index == 0 else None)
                self.unanswered.append((time.monotonic(),
                                        query.want_correspondences))
                yield request
        except GeneratorExit:
            raise
        except BaseException as failure:  # for the thread that reads answers
            self.failure = failure


def _answer_to(index: int, response: relocalization_pb2.LocalizeStreamResponse,
               sent_at: float, with_correspondences: bool) -> StreamAnswer:
    if response.HasField("error"):
        return StreamAnswer(index, None, errors.from_status(response.error))
    round_trip_ms = (time.monotonic() - sent_at) * 1e3
    try:
        # Neither an answer nor an error is an answer without an outcome.
        return StreamAnswer(index, answer_of(
            response.response, round_trip_ms, with_correspondences), None)
    except errors.InternalError as broken:
        return StreamAnswer(index, None, broken)


def stream(connection: Connection, frames: Iterable[Query | Image],
           fields: dict[str, Any], drop_oldest: bool, max_pending: int,
           timeout_s: float | None) -> Iterator[StreamAnswer]:
    """See Client.stream."""
    requests = _Requests(frames, fields, relocalization_pb2.StreamSettings(
        drop_oldest=drop_oldest, max_pending=max_pending))
    with connection.stubs() as stubs:
        call = stubs.relocalization.LocalizeStream(
            iter(requests), timeout=timeout_s,
            metadata=connection.metadata(fields.get("scene")))
        try:
            for index, response in enumerate(call):
                if response.id != index or not requests.unanswered:
                    raise errors.InternalError(
                        "the server's answer is not valid: it is to frame"
                        f" {response.id}, which is not the next one")
                yield _answer_to(index, response,
                                 *requests.unanswered.popleft())
        except grpc.RpcError as error:
            if requests.failure is None:
                raise errors.from_rpc_error(error, connection.servers,
                                            timeout_s) from None
        finally:
            call.cancel()
    if requests.failure is not None:
        raise requests.failure


class _Newest:
    """The newest frame of an iterable, which a thread of its own reads."""

    def __init__(self, frames: Iterable[Query | Image]) -> None:
        self._frames = frames
        self._changed = threading.Condition()
        self._frame: tuple[int, Query | Image] | None = None
        self._ended = False
        self._failure: BaseException | None = None
        self._stopped = False
        # A camera that blocks must not keep the program from ending.
        threading.Thread(target=self._read, daemon=True,
                         name="treeline-frames").start()

    def _read(self) -> None:
        failure: BaseException | None = None
        try:
            for numbered in enumerate(self._frames):
                with self._changed:
                    if self._stopped:
                        return
                    self._frame = numbered
                    self._changed.notify()
        except BaseException as problem:  # for the thread that localizes
            failure = problem
        with self._changed:
            self._failure = failure
            self._ended = True
            self._changed.notify()

    def take(self) -> tuple[int, Query | Image] | None:
        """Waits for a frame that was not taken. None: there will be none.
        Raises what the iterable raised."""
        with self._changed:
            self._changed.wait_for(lambda: self._frame is not None
                                   or self._ended)
            frame, self._frame = self._frame, None
            if frame is None and self._failure is not None:
                raise self._failure
            return frame

    def stop(self) -> None:
        """No further frame is kept; the thread ends with the next one."""
        with self._changed:
            self._stopped = True


def localize_latest(ask: Callable[[Query], Answer],
                    frames: Iterable[Query | Image],
                    fields: dict[str, Any]) -> Iterator[StreamAnswer]:
    """See Client.localize_latest."""
    newest = _Newest(frames)
    try:
        while (numbered := newest.take()) is not None:
            index, frame = numbered
            query = query_of(frame, fields)
            try:
                result = StreamAnswer(index, ask(query), None)
            except errors.TreelineError as error:
                result = StreamAnswer(index, None, error)
            yield result
    finally:
        newest.stop()
