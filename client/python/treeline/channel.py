"""gRPC channels with the retries, credentials and checks of a Treeline client.

Figures and reasons are those of the C++ client (client/relocalizer/channel.cc
of Treeline, decision 16).
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import threading
import time
from collections.abc import Callable, Iterator, Sequence

import grpc

from treeline import options, tracing
from treeline.v1 import relocalization_pb2_grpc, scenes_pb2_grpc

# A request larger than this buffer is sent once and never retried; gRPC's
# default of 256 KiB is less than an ordinary frame with depth.
_RETRY_BUFFER_BYTES = 16 << 20

# A server that hangs goes on holding its connections. A ping that is not
# answered ends the connection, and its calls go elsewhere: within 4 s. Pings
# are sent while calls wait only.
_PING_AFTER_MS = 2000
_PING_TIMEOUT_MS = 2000

# gRPC would wait up to two minutes before it tries a lost server again.
_FIRST_RECONNECT_MS = 100
_LAST_RECONNECT_MS = 2000

# gRPC would look a name up again only 30 s after the last time, whatever went
# meanwhile; servers that are restarted in turn may all be others by then.
_LOOK_UP_AGAIN_MS = 1000

_CERTIFICATE_REFRESH_S = 1.0

# What is no name goes to the server in the request alone: gRPC would end the
# call for a character that no header may hold.
_SCENE_METADATA = "x-treeline-scene"
_SCENE_NAME = re.compile(r"[A-Za-z0-9._-]{1,128}")


def _service_config(max_attempts: int) -> str:
    """Calls go to every address in turn, and are tried again while the answer
    is UNAVAILABLE, or CANCELLED by a server that goes down. gRPC waits as long
    as the server's pushback says, and ends with the call's deadline."""
    method: dict = {"name": [{"service": "treeline.v1.RelocalizationService"},
                             {"service": "treeline.v1.SceneService"}]}
    if max_attempts > 1:
        method["retryPolicy"] = {
            "maxAttempts": max_attempts, "initialBackoff": "0.05s",
            "maxBackoff": "1s", "backoffMultiplier": 3,
            "retryableStatusCodes": ["UNAVAILABLE", "CANCELLED"]}
    return json.dumps({"loadBalancingConfig": [{"round_robin": {}}],
                       "methodConfig": [method]})


def _read_pem(path: str | os.PathLike[str], what: str) -> bytes:
    with open(path, "rb") as file:
        text = file.read()
    if b"-----BEGIN " not in text:
        raise ValueError(f"{os.fspath(path)}: there is no {what} in PEM format"
                         " in it")
    return text


def _credentials(tls: options.Tls) -> grpc.ChannelCredentials:
    if tls.certificate_file is None or tls.key_file is None:
        return grpc.ssl_channel_credentials(
            _read_pem(tls.ca_file, "certificate"))
    return grpc.ssl_channel_credentials(
        _read_pem(tls.ca_file, "certificate"), _read_pem(tls.key_file, "key"),
        _read_pem(tls.certificate_file, "certificate"))


class Stubs:
    """A channel, and what is called on it."""

    def __init__(self, channel: grpc.Channel) -> None:
        self.channel = channel
        self.relocalization = (
            relocalization_pb2_grpc.RelocalizationServiceStub(channel))
        self.scenes = scenes_pb2_grpc.SceneServiceStub(channel)
        # Calls that use it.
        self.users = 0


class Connection:
    """To one or several servers; connects when it is first needed, and again
    whenever it breaks. Thread-safe."""

    def __init__(self, targets: str | Sequence[str],
                 token: options.Token | None, tls: options.Tls | None,
                 max_attempts: int, max_message_mib: int,
                 traceparent: Callable[[], str | None] | None = None) -> None:
        addresses = options.addresses_of(targets)
        if not 1 <= max_attempts <= 5:
            raise ValueError(f"max_attempts is {max_attempts}; it must be 1..5")
        if not 1 <= max_message_mib <= 1024:
            raise ValueError(f"max_message_mib is {max_message_mib}; it must be"
                             " 1..1024")
        self.servers = ", ".join(addresses)
        if (token is not None and tls is None
                and not options.is_on_this_machine(addresses)):
            raise ValueError(f"a token would travel to {self.servers} in the"
                             " clear; use TLS")
        self._token = None if token is None else options.TokenSource(token)
        self._traceparent = traceparent or tracing.current_traceparent
        self._target = options.grpc_target(addresses)
        self._tls = tls
        self._arguments = [
            ("grpc.service_config", _service_config(max_attempts)),
            ("grpc.per_rpc_retry_buffer_size", _RETRY_BUFFER_BYTES),
            ("grpc.max_receive_message_length", max_message_mib << 20),
            ("grpc.max_send_message_length", max_message_mib << 20),
            ("grpc.keepalive_time_ms", _PING_AFTER_MS),
            ("grpc.keepalive_timeout_ms", _PING_TIMEOUT_MS),
            ("grpc.initial_reconnect_backoff_ms", _FIRST_RECONNECT_MS),
            ("grpc.max_reconnect_backoff_ms", _LAST_RECONNECT_MS),
            ("grpc.dns_min_time_between_resolutions_ms", _LOOK_UP_AGAIN_MS)]
        if options.is_on_this_machine(addresses):
            # gRPC would ask the proxy of http_proxy to connect to itself.
            self._arguments.append(("grpc.enable_http_proxy", 0))
        if tls is not None:
            # New certificates need connections of their own.
            self._arguments.append(("grpc.use_local_subchannel_pool", 1))
            name = options.name_in_certificate(addresses, tls)
            if name:
                self._arguments.append(("grpc.ssl_target_name_override", name))
        self._lock = threading.Lock()
        self._closed = False
        self._files = self._state_of_files()
        self._looked_at = time.monotonic()
        self._stubs = self._open()
        # With certificates of before, until their last call has ended.
        self._retired: set[Stubs] = set()

    def _open(self) -> Stubs:
        if self._tls is None:
            return Stubs(grpc.insecure_channel(self._target, self._arguments))
        return Stubs(grpc.secure_channel(
            self._target, _credentials(self._tls), self._arguments))

    def _state_of_files(self) -> list[tuple[int, ...] | None]:
        if self._tls is None:
            return []
        states: list[tuple[int, ...] | None] = []
        for path in (self._tls.ca_file, self._tls.certificate_file,
                     self._tls.key_file):
            try:
                info = os.stat(path) if path is not None else None
            except OSError:
                info = None
            states.append(info and (info.st_dev, info.st_ino, info.st_size,
                                    info.st_mtime_ns))
        return states

    def _refresh(self) -> Stubs | None:
        """With changed files, a new channel; the old one, if no call uses it
        and it must be closed. Broken files leave the old channel in place."""
        now = time.monotonic()
        if (self._tls is None
                or now - self._looked_at < _CERTIFICATE_REFRESH_S):
            return None
        self._looked_at = now
        files = self._state_of_files()
        if files == self._files:
            return None
        try:
            fresh = self._open()
        except (OSError, ValueError):
            return None
        old, self._stubs, self._files = self._stubs, fresh, files
        if old.users == 0:
            return old
        self._retired.add(old)
        return None

    @contextlib.contextmanager
    def stubs(self) -> Iterator[Stubs]:
        """For one call. RuntimeError after close()."""
        with self._lock:
            if self._closed:
                raise RuntimeError("the client is closed")
            unused = self._refresh()
            stubs = self._stubs
            stubs.users += 1
        if unused is not None:
            unused.channel.close()
        try:
            yield stubs
        finally:
            with self._lock:
                stubs.users -= 1
                is_last = stubs.users == 0 and stubs in self._retired
                if is_last:
                    self._retired.remove(stubs)
            if is_last:
                stubs.channel.close()

    def metadata(self, scene: str | None = None) -> list[tuple[str, str]]:
        """What every call carries: the token, the trace that it belongs to;
        with the scene that it is about, if it is about one, by which a balancer
        can choose the server."""
        metadata = []
        if self._token is not None:
            metadata.append(("authorization", f"Bearer {self._token.get()}"))
        if scene is not None and _SCENE_NAME.fullmatch(scene):
            metadata.append((_SCENE_METADATA, scene))
        traceparent = self._traceparent()
        if traceparent and tracing.is_traceparent(traceparent):
            metadata.append(("traceparent", traceparent))
        return metadata

    def close(self) -> None:
        """Cancels the calls that are not answered."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
            all_stubs = [self._stubs, *self._retired]
            self._retired.clear()
        for stubs in all_stubs:
            stubs.channel.close()
