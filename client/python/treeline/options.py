"""How a server is reached, and what is shown to it."""

from __future__ import annotations

import dataclasses
import ipaddress
import os
import threading
from collections.abc import Callable, Sequence
from typing import Union

# A token as it is; a file that holds it; or what gives it for each call.
Token = Union[str, "os.PathLike[str]", Callable[[], str]]

# Far more than servers accept in a header.
_MAX_TOKEN_BYTES = 64 << 10


@dataclasses.dataclass(frozen=True)
class Tls:
    """TLS, and for mutual TLS the client's own certificate. Files are PEM and
    are read again when they change, at most a second later; calls that are
    made then use the new ones."""

    # Certificates that are trusted to sign the server's; the system's are
    # /etc/ssl/certs/ca-certificates.crt.
    ca_file: str | os.PathLike[str]
    # The client's certificate chain and its private key: both or neither.
    certificate_file: str | os.PathLike[str] | None = None
    key_file: str | os.PathLike[str] | None = None
    # The name that the server's certificate must have; None: the host that is
    # asked for. Several servers on several hosts need one.
    server_name: str | None = None

    def __post_init__(self) -> None:
        if (self.certificate_file is None) != (self.key_file is None):
            raise ValueError("a client's certificate and its key go together")


def _split(address: str) -> tuple[str, str]:
    """Host without brackets, and port; "" if it has none."""
    colon = address.rfind(":")
    if colon < 0 or colon < address.rfind("]"):
        return address, ""
    host, port = address[:colon], address[colon + 1:]
    return host.removeprefix("[").removesuffix("]"), port


def _check_listed(address: str, version: int) -> None:
    host, port = _split(address)
    if not port.isdecimal() or not 1 <= int(port) <= 65535:
        raise ValueError(f"{address!r} has no port; several servers are given"
                         " as ADDRESS:PORT")
    try:
        is_address = ipaddress.ip_address(host).version == version
    except ValueError:
        is_address = False
    if not is_address:
        raise ValueError(
            f"{address!r}: several servers are given by their IP addresses, all"
            " of one family; one name for all of them is dns:///NAME:PORT")


def _check_single(address: str) -> None:
    """gRPC would look for a host of the whole name, or for the port 0."""
    if address.lower().startswith(("http://", "https://", "grpc://",
                                   "grpcs://")):
        raise ValueError(f"{address!r} is a web address; a server is given as"
                         " HOST:PORT, the port that it says it is \"listening"
                         " on\"")
    if ":///" not in address and not _split(address)[1]:
        raise ValueError(f"{address!r} has no port; give HOST:PORT, for"
                         f" instance {address.removesuffix(':')}:50051")


def addresses_of(targets: str | Sequence[str]) -> list[str]:
    """Of a text with commas or a sequence. ValueError: none, one without a
    port, or several that are no IP addresses with ports."""
    text = targets if isinstance(targets, str) else ",".join(targets)
    listed = text.split(",")
    if not all(listed):
        raise ValueError("no server given; for instance 127.0.0.1:50051")
    if len(listed) > 1:
        version = 6 if listed[0].startswith("[") else 4
        for address in listed:
            _check_listed(address, version)
    else:
        _check_single(listed[0])
    return listed


def grpc_target(addresses: Sequence[str]) -> str:
    """The target that gRPC understands."""
    if len(addresses) == 1:
        return addresses[0]
    scheme = "ipv6:" if addresses[0].startswith("[") else "ipv4:"
    return scheme + ",".join(addresses)


def is_on_this_machine(addresses: Sequence[str]) -> bool:
    """Whether each is 127.*, [::1], localhost or a socket file."""
    def one(address: str) -> bool:
        if address.startswith("unix:"):
            return True
        for scheme in ("ipv4:", "ipv6:", "dns:///"):
            address = address.removeprefix(scheme)
        host = _split(address)[0]
        return host in ("localhost", "::1") or (
            host.startswith("127.") and host.replace(".", "").isdecimal())

    return all(one(address) for address in addresses)


def name_in_certificate(addresses: Sequence[str], tls: Tls) -> str | None:
    """The name to look for; None: gRPC's own choice. Of a list gRPC would look
    for the whole text."""
    if tls.server_name or len(addresses) == 1:
        return tls.server_name
    hosts = {_split(address)[0] for address in addresses}
    if len(hosts) > 1:
        raise ValueError("several servers: say which name all their"
                         " certificates have (Tls.server_name)")
    return hosts.pop()


def _clean_token(text: str, source: str) -> str:
    """No error says what was in it."""
    token = text.strip()
    if not token:
        raise ValueError(f"{source}: there is no token in it")
    if not all("!" <= c <= "~" for c in token):
        raise ValueError(f"{source}: what it holds is not one token")
    return token


class TokenSource:
    """The token that each call carries. Thread-safe."""

    def __init__(self, token: Token) -> None:
        """ValueError or OSError: there is no token in it."""
        self._lock = threading.Lock()
        self._path: str | None = None
        self._call: Callable[[], str] | None = None
        if isinstance(token, os.PathLike):
            self._path = os.fspath(token)
            self._state = self._state_of_file()
            self._token = self._read()
        elif callable(token):
            self._call = token
        elif isinstance(token, str):
            self._token = _clean_token(token, "token")
        else:
            raise TypeError("token: a str (the token), a pathlib.Path (a file"
                            " that holds it) or a callable is expected, not "
                            + type(token).__name__)

    def _state_of_file(self) -> tuple[int, ...] | None:
        assert self._path is not None
        try:
            info = os.stat(self._path)
        except OSError:
            return None
        return info.st_dev, info.st_ino, info.st_size, info.st_mtime_ns

    def _read(self) -> str:
        assert self._path is not None
        with open(self._path, encoding="ascii", errors="replace") as file:
            return _clean_token(file.read(_MAX_TOKEN_BYTES), self._path)

    def get(self) -> str:
        """The token as it is now. If the file has become unreadable or empty,
        the last good one: it may be about to be replaced, and the server
        decides whether it still counts. What a callable raises is passed on."""
        if self._call is not None:
            return _clean_token(self._call(), "token")
        if self._path is None:
            return self._token
        with self._lock:
            now = self._state_of_file()
            if now != self._state:
                # The state is of before: a change in between is seen next time.
                try:
                    self._token = self._read()
                    self._state = now
                except (OSError, ValueError):
                    pass
            return self._token
