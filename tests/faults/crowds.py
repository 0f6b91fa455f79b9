"""Clients that wait: crowds of connections that hold on to what they have, and
calls whose answers nobody takes."""

import base64
import select
import socket
import struct
import threading
import time

import http2_attack as attack
from harness import Bench, Server, bench, explain_losses, fault, first_frame, lost

# Loopback addresses of those who attack; honest clients have 127.0.0.1.
CROWD = tuple(f"127.0.0.{i}" for i in range(2, 10))
# What each of them holds or tries to: as many as an address may have.
EACH = 128
STEP_S = 0.2
# Of 230 kB each, where all requests may hold 128 MiB.
ANSWERS = 620
SCENES = "/treeline.v1.SceneService/ListScenes"


# --- HTTP -------------------------------------------------------------------
class SlowHead:
    """A head without end."""
    begin = f"POST {SCENES} HTTP/1.1\r\nHost: x\r\nX: ".encode()
    step = b"a"


class SlowBody:
    """A body that comes just fast enough: 8 KiB/s are asked for."""
    begin = (f"POST {SCENES} HTTP/1.1\r\nHost: x\r\nContent-Type: "
             "application/json\r\nContent-Length: 8000000\r\n\r\n").encode()
    step = bytes(int(10000 * STEP_S))


class SilentWebSocket:
    """A stream that is opened, and nothing else."""
    begin = ("GET /treeline.v1.RelocalizationService/LocalizeStream HTTP/1.1\r\n"
             "Host: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
             "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: "
             + base64.b64encode(bytes(16)).decode()
             + "\r\nSec-WebSocket-Protocol: treeline.v1\r\n\r\n").encode()
    step = b""


class Unread:
    """Large answers, which are asked for and not read."""
    begin = (b"POST /treeline.v1.SceneService/GetSceneMap HTTP/1.1\r\nHost: x\r\n"
             b"Content-Type: application/json\r\nContent-Length: 36\r\n\r\n"
             b'{"scene": "room", "maxPoints": 9999}') * 200
    step = b""
    receive_buffer = 2048
    # What the system takes for them is computed first: no more than are enough.
    sources = 2


HTTP_CROWDS = {"heads without end": SlowHead, "slow bodies": SlowBody,
               "silent WebSockets": SilentWebSocket,
               "answers that nobody reads": Unread}


class Crowd:
    """Keeps so many connections of a kind, and makes new ones for those that
    it loses, until stopped."""

    def __init__(self, port, kind):
        self.port = port
        self.kind = kind
        self.made = 0
        sources = CROWD[:getattr(kind, "sources", len(CROWD))]
        self.held = {source: [] for source in sources}
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def settle(self):
        """Waits until they have what they want, or 10 s."""
        made, begin = -1, time.monotonic()
        while made != self.made and time.monotonic() - begin < 10:
            made = self.made
            time.sleep(1.5)

    def _run(self):
        while not self._stop.is_set():
            for source, held in self.held.items():
                held[:] = [each for each in held if self._goes_on(each)]
                while len(held) < EACH and not self._stop.is_set():
                    try:
                        held.append(self._connect(source))
                    except OSError:
                        break
            self._stop.wait(STEP_S)

    def _connect(self, source):
        connection = socket.socket()
        if hasattr(self.kind, "receive_buffer"):
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF,
                                  self.kind.receive_buffer)
        try:
            connection.settimeout(1)
            connection.bind((source, 0))
            connection.connect(("127.0.0.1", self.port))
            connection.send(self.kind.begin)
        except OSError:
            connection.close()
            raise
        self.made += 1
        return connection

    def _goes_on(self, connection):
        poll = select.poll()
        poll.register(connection, select.POLLRDHUP)
        try:
            if not poll.poll(0):
                if self.kind.step:
                    connection.send(self.kind.step)
                return True
        except OSError:
            pass
        connection.close()
        return False

    def stop(self):
        self._stop.set()
        self._thread.join()
        for held in self.held.values():
            for connection in held:
                connection.close()


class HonestCalls:
    """A call on a connection of its own, again and again, for so long."""

    def __init__(self, server, seconds):
        self.answered = 0
        self.failures = []
        self.slowest_s = 0.0
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            begin = time.monotonic()
            said = self._call(server.http_port)
            if said.startswith(b"HTTP/1.1 200"):
                self.answered += 1
                self.slowest_s = max(self.slowest_s, time.monotonic() - begin)
            else:
                self.failures.append(said[:12].decode(errors="replace"))
            time.sleep(0.05)

    @staticmethod
    def _call(port):
        try:
            with socket.create_connection(("127.0.0.1", port), 5) as connection:
                connection.sendall(
                    f"POST {SCENES} HTTP/1.1\r\nHost: x\r\nConnection: close\r\n"
                    "Content-Type: application/json\r\nContent-Length: 2\r\n\r\n"
                    "{}".encode())
                return connection.recv(4096) or b"closed"
        except OSError as error:
            return type(error).__name__.encode()


@fault("http-crowds", "eight addresses take all HTTP connections, and keep them: "
                      "others are answered as before")
def http_crowds(setup, row):
    setup.need("--http-listen")
    server = Server(setup, setup.models())
    bench(setup, [server], "--duration", "0.5", "--no-reference")
    seconds = setup.seconds(15, 4)
    usual = HonestCalls(server, 2)
    row.figure("slowest before (ms)", round(1000 * usual.slowest_s, 1))
    for name, kind in HTTP_CROWDS.items():
        before_kib = server.status_kib("VmRSS")
        crowd = Crowd(server.http_port, kind)
        crowd.settle()
        honest = HonestCalls(server, seconds)
        crowd.stop()
        row.figure(f"{name}: made", crowd.made)
        row.figure(f"{name}: slowest (ms)", round(1000 * honest.slowest_s, 1))
        if honest.failures:
            row.figure(f"{name}: failures", {
                why: honest.failures.count(why) for why in set(honest.failures)})
        row.require(f"{name}: calls that failed (%)", round(
            100 * len(honest.failures)
            / (honest.answered + len(honest.failures)), 1), "<=", 2)
        row.require(f"{name}: MiB more", round(
            (server.status_kib("VmHWM") - before_kib) / 1024, 1), "<=", 256)
        row.require(f"{name}: health", server.get("/healthz", 5)[0], "==", 200)


# --- gRPC -------------------------------------------------------------------
def varint(value):
    out = b""
    while value >= 128:
        out += bytes([value & 127 | 128])
        value >>= 7
    return out + bytes([value])


def field(number, value):
    """Of Protocol Buffers, with a length."""
    return varint(number << 3 | 2) + varint(len(value)) + value


def localize_request(setup):
    """treeline.v1.LocalizeRequest with a frame that the scene knows."""
    color, depth = (path.read_bytes() for path in first_frame(setup))
    unit = varint(3 << 3 | 1) + struct.pack("<d", 0.001)
    of_the_scene = varint(4 << 3) + varint(2)
    return field(1, b"room") + field(3, field(1, field(1, color)) + field(
        3, field(1, depth) + unit + of_the_scene))


class Untaken:
    """A connection that asks properly, sending no more than the server has room
    for (RFC 9113, section 5.2), and gives its own streams no window: answers
    cannot be sent."""

    LARGEST = 16384
    INITIAL_WINDOW = 4  # of the settings

    def __init__(self, address, path, message):
        self.calls = attack.Calls(path)
        self.message = b"\0" + struct.pack(">I", len(message)) + message
        self.window = self.initial = 65535
        self.of_stream = 0
        self.received = b""
        host, port = address.rsplit(":", 1)
        self.socket = socket.create_connection((host, int(port)), 10,
                                               (CROWD[0], 0))
        self.socket.sendall(attack.PREFACE + attack.frame(
            attack.SETTINGS, 0, 0, struct.pack(">HI", self.INITIAL_WINDOW, 0)))

    def close(self):
        self.socket.close()

    def ask(self):
        """One more call, whole. ConnectionError if the server closed it."""
        self.socket.sendall(self.calls.open())
        self.of_stream = self.initial
        left = self.message
        while left:
            self._listen(0)
            while min(self.window, self.of_stream) <= 0:
                self._listen(10)
            size = min(len(left), self.LARGEST, self.window, self.of_stream)
            part, left = left[:size], left[size:]
            self.socket.sendall(attack.frame(
                attack.DATA, 0 if left else attack.END_STREAM,
                self.calls.stream, part))
            self.window -= size
            self.of_stream -= size

    def _listen(self, seconds):
        """What the server says, waiting so long for the first of it."""
        while select.select([self.socket], [], [], seconds)[0]:
            seconds = 0
            said = self.socket.recv(1 << 16)
            if not said:
                raise ConnectionError("closed")
            self.received += said
            self._take_frames()

    def _take_frames(self):
        while len(self.received) >= 9:
            length = int.from_bytes(self.received[:3], "big")
            if len(self.received) < 9 + length:
                return
            kind, flags, stream = struct.unpack(">BBI", self.received[3:9])
            payload = self.received[9:9 + length]
            self.received = self.received[9 + length:]
            if flags & attack.ACK and kind in (attack.SETTINGS, attack.PING):
                continue
            if kind == attack.SETTINGS:
                self._take_settings(payload)
            elif kind == attack.PING:
                self.socket.sendall(attack.frame(attack.PING, attack.ACK, 0,
                                                 payload))
            elif kind == attack.WINDOW_UPDATE:
                more = int.from_bytes(payload, "big")
                if stream == 0:
                    self.window += more
                elif stream == self.calls.stream:
                    self.of_stream += more

    def _take_settings(self, payload):
        for name, value in struct.iter_unpack(">HI", payload):
            if name == self.INITIAL_WINDOW:
                self.of_stream += value - self.initial
                self.initial = value
        self.socket.sendall(attack.frame(attack.SETTINGS, attack.ACK))


def answered(server, rpc):
    return server.metrics().sum("treeline_requests_total", rpc=rpc, status="OK")


@fault("untaken-answers", "one address asks properly, and takes no answer: "
                          "others are answered as before, and little memory is "
                          "taken")
def untaken(setup, row):
    server = Server(setup, setup.models())
    bench(setup, [server], "--duration", "0.5", "--no-reference")
    before_kib = server.status_kib("VmRSS")
    kinds = {
        "Localize": (attack.LOCALIZE, localize_request(setup)),
        "GetSceneMap": (
            "/treeline.v1.SceneService/GetSceneMap",
            field(1, b"room") + varint(2 << 3) + varint(200000))}
    for name, (path, message) in kinds.items():
        connections = [Untaken(server.address, path, message)
                       for _ in range(10)]
        # A queue takes no more at a time; and if requests were held until
        # their answers are taken, these would be more than all may hold.
        begin, first = time.monotonic(), answered(server, name)
        while (answered(server, name) - first < ANSWERS and
               time.monotonic() - begin < 30):
            for connection in connections:
                connection.ask()
            time.sleep(0.1)
        untaken_calls = answered(server, name) - first
        load = Bench(setup, [server], "--rate", "10", "--duration",
                     setup.seconds(8, 3), "--no-reference")
        run = load.result()["runs"][0]
        row.require(f"{name}: answered", untaken_calls, ">=", ANSWERS)
        row.figure(f"{name}: p99 (ms)",
                   run["latency_ms"]["p99"] if run["latency_ms"] else None)
        row.require(f"{name}: others' lost calls", lost(run), "==", 0)
        explain_losses(row, run)
        for connection in connections:
            connection.close()
    row.require("MiB more", round(
        (server.status_kib("VmHWM") - before_kib) / 1024, 1), "<=", 384)


@fault("held-calls", "forty addresses begin calls, as many as one may, and leave "
                     "them at that: others are answered as before")
def held_calls(setup, row):
    setup.need("--flood-limit")
    server = Server(setup, setup.models())
    bench(setup, [server], "--duration", "0.5", "--no-reference")
    before_kib = server.status_kib("VmRSS")
    connections = [attack.Attack(server.address, attack.calls_without_end,
                                 source=f"127.0.1.{i + 1}") for i in range(40)]
    for connection in connections:
        connection.send(900)
    run = bench(setup, [server], "--rate", "10", "--duration",
                setup.seconds(8, 3), "--no-reference")["runs"][0]
    for connection in connections:
        connection.send(1)
    row.figure("calls begun", sum(c.index for c in connections))
    row.figure("connections cut", sum(c.wait_cut(0.05) for c in connections))
    row.figure("p99 (ms)",
               run["latency_ms"]["p99"] if run["latency_ms"] else None)
    row.require("others' lost calls", lost(run), "==", 0)
    row.require("MiB more", round(
        (server.status_kib("VmHWM") - before_kib) / 1024, 1), "<=", 256)
    explain_losses(row, run)
    for connection in connections:
        connection.close()
