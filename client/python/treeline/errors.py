"""What goes wrong with a call, as exceptions.

"Not localized" is none of these: it is an answer. What this package itself
refuses (a wrong shape, a wrong option) is a ValueError or a TypeError, before
anything is sent.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from typing import Any

import grpc
from google.protobuf.message import DecodeError

from treeline.rpc import status_pb2

_DETAILS = "grpc-status-details-bin"
_DOMAIN = "treeline"


class TreelineError(Exception):
    """A call that failed. `code` is the name of gRPC's status code, `reason`
    the stable word for programs ("QUEUE_FULL"; docs/reference/service.md of
    Treeline has the table) or "" if the server gave none, `message` is for
    people and may change, `metadata` belongs to the reason, and
    `retry_after_s` is when the server wants to be asked again, if it says so.
    """

    code = "UNKNOWN"

    def __init__(self, message: str, *, code: str | None = None,
                 reason: str = "", metadata: Mapping[str, str] | None = None,
                 retry_after_s: float | None = None) -> None:
        if code is not None:
            self.code = code
        self.message = message
        self.reason = reason
        self.metadata = dict(metadata or {})
        self.retry_after_s = retry_after_s
        super().__init__(f"{self.code} ({reason}): {message}" if reason else
                         f"{self.code}: {message}")


class InvalidRequest(TreelineError):
    """The request; the message starts with the field, as in
    "frame.depth.unit_m: ..."."""
    code = "INVALID_ARGUMENT"


class NotFound(TreelineError):
    """No such scene, or no such version of it."""
    code = "NOT_FOUND"


class FailedPrecondition(TreelineError):
    """The model cannot be opened, or no scene can be recognized."""
    code = "FAILED_PRECONDITION"


class DataLoss(TreelineError):
    """The scene's model file is corrupt."""
    code = "DATA_LOSS"


class Unavailable(TreelineError):
    """Overloaded, stopping, or not reached; all tries are used up."""
    code = "UNAVAILABLE"


class DeadlineExceeded(TreelineError):
    """No answer within the timeout, all tries together."""
    code = "DEADLINE_EXCEEDED"


class Cancelled(TreelineError):
    """Cancelled: here by close(), or by a server that goes down."""
    code = "CANCELLED"


class ResourceExhausted(TreelineError):
    """This client's rate is used up, or a message is too large."""
    code = "RESOURCE_EXHAUSTED"


class Unauthenticated(TreelineError):
    """No token, or one that is not (or no longer) valid."""
    code = "UNAUTHENTICATED"


class PermissionDenied(TreelineError):
    """The token does not allow it, or only the admin listener answers it."""
    code = "PERMISSION_DENIED"


class Aborted(TreelineError):
    """A frame of a stream that was dropped for newer ones."""
    code = "ABORTED"


class InternalError(TreelineError):
    """A fault of the server, or an answer that breaks the contract."""
    code = "INTERNAL"


_CLASSES = {kind.code: kind for kind in TreelineError.__subclasses__()}
_CODES = {code.value[0]: code.name for code in grpc.StatusCode}


def make_error(code: str, message: str, **details: Any) -> TreelineError:
    """The exception of a status code's name; TreelineError itself for those
    that Treeline does not give."""
    kind = _CLASSES.get(code)
    if kind is None:
        return TreelineError(message, code=code, **details)
    return kind(message, **details)


def _details_of(status: Any) -> dict[str, Any]:
    """Reason, metadata and time to retry out of a status' details; what is not
    ours or does not parse is passed over, as in C++."""
    found: dict[str, Any] = {}
    for detail in status.details:
        name = detail.type_url.rpartition("/")[2]
        try:
            if name == "google.rpc.ErrorInfo":
                info = status_pb2.ErrorInfo.FromString(detail.value)
                if info.domain == _DOMAIN:
                    found["reason"] = info.reason
                    found["metadata"] = dict(info.metadata)
            elif name == "google.rpc.RetryInfo":
                delay = status_pb2.RetryInfo.FromString(
                    detail.value).retry_delay
                found["retry_after_s"] = delay.seconds + delay.nanos * 1e-9
        except DecodeError:
            continue
    return found


def from_status(status: Any) -> TreelineError:
    """Of a google.rpc.Status, as streams carry it for each frame. INTERNAL if
    it is no error at all."""
    code = _CODES.get(status.code, "UNKNOWN")
    if code == "OK":
        return InternalError("the server's answer is not valid: neither an"
                             " answer nor an error")
    return make_error(code, status.message, **_details_of(status))


def from_rpc_error(error: grpc.RpcError, servers: str,
                   timeout_s: float | None) -> TreelineError:
    """Of a call that gRPC ended. `servers` and `timeout_s` are for the text of
    errors that no server gave."""
    code = error.code().name
    message = error.details() or ""
    details: dict[str, Any] = {}
    for key, value in error.trailing_metadata() or ():
        if key == _DETAILS:
            with contextlib.suppress(DecodeError):
                details = _details_of(status_pb2.Status.FromString(value))
    if not details.get("reason"):
        if code == "DEADLINE_EXCEEDED" and timeout_s is not None:
            message = f"no answer from {servers} within {timeout_s:g} s"
        elif code == "UNAVAILABLE":
            message = f"{servers}: {message}"
    return make_error(code, message, **details)
