#!/usr/bin/env python3
"""Spans as a collector gets them, and exemplars as Prometheus does.

    traces_test.py TREE PROGRAMS SCENE NODE_FOLDER
"""

import base64
import concurrent.futures
import http.client
import os
import pathlib
import socket
import struct
import sys
import tempfile
import time
import unittest
import urllib.request

TREE = pathlib.Path(sys.argv[1])
PROGRAMS, SCENE, NODE_FOLDER = sys.argv[2:5]
sys.path.insert(0, str(TREE / "tests" / "faults"))
from collector import PATH, Collector, is_fetched, spans_of  # noqa: E402
from harness import (TERM, Metrics, Program, Server, Setup,  # noqa: E402
                     client, first_frame, free_port, wait_until)

from prometheus_client.openmetrics.parser import (  # noqa: E402
    text_string_to_metric_families)

TRACE = "0af7651916cd43dd8448eb211c80319c"
CALLER = "b7ad6b7169203331"
TRACEPARENT = f"00-{TRACE}-{CALLER}-01"
SERVICE = "treeline.v1.RelocalizationService"
LOCALIZE = f"/{SERVICE}/Localize"
STREAM = f"/{SERVICE}/LocalizeStream"
STAGES = ["queue", "decode", "sample", "forest", "pose"]
INTERNAL, SERVER, CLIENT = ("SPAN_KIND_INTERNAL", "SPAN_KIND_SERVER",
                            "SPAN_KIND_CLIENT")
KINDS = {1: INTERNAL, 2: SERVER, 3: CLIENT}
# Nothing in it takes long to make.
WORLD = """
size: [4, 3, 2.5]
rooms:
  - {name: room, area: [0, 0, 4, 3], lamps: [1, 1]}
furniture:
  - {kind: bookcase, at: [3, 2.6], facing: south}
places:
  - {name: start, at: [1, 1], facing: east}
tour: [[1, 1], [2, 1], [1, 1.5]]
"""
# No stop may take longer; what makes it wait is 2 s.
LONGEST_STOP_S = 30


def environment(**more):
    kept = {k: v for k, v in os.environ.items()
            if not k.startswith(("OTEL_", "TRACEPARENT", "http_proxy"))}
    return {**kept, **more}


class Traced(unittest.TestCase):

    def setUp(self):
        work = tempfile.TemporaryDirectory()
        self.addCleanup(work.cleanup)
        self.setup = Setup(PROGRAMS, SCENE, work.name, True)
        self.addCleanup(self.setup.__exit__)

    def collector(self, behave=None):
        made = Collector(behave)
        self.addCleanup(made.close)
        return made

    def server(self, *flags, **variables):
        return Server(self.setup, self.setup.models(), "--drain-s", "0",
                      "--grace-s", "1", *flags,
                      environment=environment(**variables))

    def localize(self, server, scene="room", **variables):
        color, depth = first_frame(self.setup)
        return client(self.setup, "localize", server.address, "--scene", scene,
                      "--color", color, "--depth", depth,
                      environment=environment(**variables))

    def post(self, server, path, headers, body=b'{"scene":"nowhere"}'):
        connection = http.client.HTTPConnection("127.0.0.1", server.http_port,
                                                timeout=60)
        try:
            connection.request("POST", path, body, {
                "Content-Type": "application/json", **headers})
            answer = connection.getresponse()
            return answer.status, answer.read()
        finally:
            connection.close()

    def stop(self, program):
        """Ends it in order; the seconds that it took."""
        began = time.monotonic()
        program.send(TERM)
        self.assertEqual(program.wait(LONGEST_STOP_S), 0, program.log())
        return time.monotonic() - began

    def spans(self, collector):
        return spans_of(NODE_FOLDER, list(collector.bodies))

    def check_nested(self, outer, inner):
        self.assertEqual(inner.trace, outer.trace)
        self.assertEqual(inner.parent, outer.id)
        self.assertLessEqual(outer.start, inner.start)
        self.assertLessEqual(inner.start, inner.end)
        self.assertLessEqual(inner.end, outer.end)


def one(spans, name, service=None):
    found = [s for s in spans if s.name == name
             and service in (None, s.service)]
    assert len(found) == 1, [(s.service, s.name) for s in spans]
    return found[0]


class OneTrace(Traced):

    def test_client_and_server_are_one_trace(self):
        collector = self.collector()
        # The server by OpenTelemetry's variables, as the client.
        variables = {"OTEL_EXPORTER_OTLP_ENDPOINT": collector.base,
                     "OTEL_EXPORTER_OTLP_HEADERS": "api-key=open%20sesame"}
        server = self.server(
            OTEL_SERVICE_NAME="hall-server",
            OTEL_RESOURCE_ATTRIBUTES="deployment.environment=test",
            **variables)
        began = time.time_ns()
        done = self.localize(server, TRACEPARENT=TRACEPARENT, **variables)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        # Its spans are sent before it ends: nothing waits here.
        self.stop(server)
        ended = time.time_ns()
        for path, headers in collector.headers:
            self.assertEqual(path, PATH)
            self.assertEqual(headers["Content-Type"], "application/x-protobuf")
            self.assertEqual(headers["api-key"], "open sesame")

        spans = self.spans(collector)
        self.assertEqual({s.trace for s in spans}, {TRACE})
        self.assertEqual(len({s.id for s in spans}), len(spans))
        asked = one(spans, SERVICE + "/Localize", "treeline-client")
        answered = one(spans, SERVICE + "/Localize", "hall-server")
        self.assertEqual(asked.parent, CALLER)
        self.assertEqual(KINDS[asked.kind], CLIENT)
        self.assertEqual(KINDS[answered.kind], SERVER)
        self.assertEqual(answered.resource["deployment.environment"], "test")
        self.check_nested(asked, answered)
        self.assertLessEqual(began, asked.start)
        self.assertLessEqual(asked.end, ended)
        at = answered.start
        for name in STAGES:
            stage = one(spans, name)
            self.check_nested(answered, stage)
            self.assertGreaterEqual(stage.start, at)
            at = stage.end
        self.check_nested(one(spans, "pose"), one(spans, "verify"))
        for span in (asked, answered):
            self.assertEqual(span.status, {})
            self.assertEqual(span.attributes["rpc.system"], "grpc")
            self.assertEqual(span.attributes["rpc.service"], SERVICE)
            self.assertEqual(span.attributes["rpc.method"], "Localize")
            self.assertEqual(span.attributes["rpc.grpc.status_code"], 0)
            self.assertEqual(span.attributes["treeline.scene"], "room")
            self.assertEqual(span.attributes["treeline.outcome"], "LOCALIZED")
        self.assertEqual(answered.attributes["treeline.model_version"], "1")

    def test_http_and_websockets_are_in_it_too(self):
        collector = self.collector()
        server = self.server("--trace-endpoint", collector.endpoint)
        self.assertEqual(self.post(server, LOCALIZE,
                                   {"traceparent": TRACEPARENT})[0], 404)
        self.ask_over_websocket(server, {"traceparent": TRACEPARENT})
        self.ask_over_websocket(server, {
            "Sec-WebSocket-Protocol":
                f"treeline.v1, treeline.traceparent.{TRACEPARENT}"})
        self.stop(server)
        spans = [s for s in self.spans(collector) if KINDS[s.kind] == SERVER]
        self.assertEqual([s.name for s in spans],
                         [LOCALIZE[1:], STREAM[1:], STREAM[1:]])
        for span in spans:
            self.assertEqual((span.trace, span.parent), (TRACE, CALLER))
            self.assertEqual(span.attributes["rpc.system"], "connect_rpc")
            self.assertEqual(span.attributes["rpc.connect_rpc.error_code"],
                             "not_found")
            # The client's mistake is no error of the server, nor is what it
            # made up told on.
            self.assertEqual(span.status, {})
            self.assertNotIn("treeline.scene", span.attributes)

    def ask_over_websocket(self, server, headers):
        with socket.create_connection(("127.0.0.1", server.http_port),
                                      60) as connection:
            lines = [f"GET {STREAM} HTTP/1.1", "Host: x",
                     "Upgrade: websocket", "Connection: Upgrade",
                     "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: "
                     + base64.b64encode(bytes(16)).decode(),
                     *(f"{k}: {v}" for k, v in headers.items()), "", ""]
            connection.sendall("\r\n".join(lines).encode())
            reader = connection.makefile("rb")
            self.assertIn(b" 101 ", reader.readline())
            while reader.readline() != b"\r\n":
                pass
            message = b'{"id":"1","localize":{"scene":"nowhere"}}'
            # Masked with zeros.
            connection.sendall(struct.pack("!BB4x", 0x81, 0x80 | len(message))
                               + message)
            self.assertEqual(reader.read(1), b"\x81")

    def test_callers_and_the_share_decide_what_is_recorded(self):
        collector = self.collector()
        server = self.server("--trace-endpoint", collector.endpoint,
                             "--trace-ratio", "0")
        self.post(server, LOCALIZE, {"traceparent": TRACEPARENT[:-1] + "0"})
        self.post(server, LOCALIZE, {})
        self.post(server, LOCALIZE, {"traceparent": "odd"})
        self.post(server, LOCALIZE, {"traceparent": TRACEPARENT})
        self.stop(server)
        spans = self.spans(collector)
        self.assertEqual({s.trace for s in spans}, {TRACE})
        self.assertEqual(sum(KINDS[s.kind] == SERVER for s in spans), 1)

    def test_the_robots_recovery_contains_the_servers_spans(self):
        collector = self.collector()
        variables = {"OTEL_EXPORTER_OTLP_ENDPOINT": collector.base}
        server = self.server(**variables)
        world = self.setup.folder("world") / "box.yaml"
        world.write_text(WORLD)
        robot = Program(self.setup, [
            self.setup.program("treeline-agent"), "run", "--simulate", world,
            "--find-yourself", "--server", server.address, "--scene", "room",
            "--listen", "", "--http-listen", ""],
            environment=environment(**variables))
        wait_until(lambda: b"fix gate" in b"".join(collector.bodies)
                   or not robot.running(), "a verdict")
        self.stop(robot)
        self.stop(server)
        spans = self.spans(collector)
        recovery = one(spans, "recovery")
        self.assertEqual(recovery.service, "treeline-agent")
        self.assertEqual(recovery.parent, "")
        questions = [s for s in spans if KINDS[s.kind] == CLIENT]
        answers = [s for s in spans if KINDS[s.kind] == SERVER]
        self.assertGreaterEqual(len(answers), 1)
        for question in questions:
            self.check_nested(recovery, question)
        by_id = {s.id: s for s in questions}
        for answer in answers:
            self.assertEqual(answer.service, "treeline-server")
            self.check_nested(by_id[answer.parent], answer)
        for gate in (s for s in spans if s.name == "fix gate"):
            self.check_nested(recovery, gate)
            self.assertTrue(gate.attributes["treeline.fix.verdict"])


def silent(handler):
    """Never answers; the connection stays until the test ends."""
    handler.close_connection = False
    time.sleep(600)


def huge(handler):
    handler.send_response(200)
    handler.end_headers()
    try:
        while True:
            handler.wfile.write(bytes(1 << 20))
    except OSError:
        handler.close_connection = True


def busy(handler):
    handler.send_response(503)
    handler.send_header("Retry-After", "3600")
    handler.send_header("Content-Length", "0")
    handler.end_headers()


class BadCollectors(Traced):

    def check_harmless(self, endpoint, collector=None):
        """A server whose spans go there answers, and ends in order; its
        log."""
        server = self.server("--trace-endpoint", endpoint)
        done = self.localize(server)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        if collector is not None:
            wait_until(collector.asked.is_set, "spans")
        done = self.localize(server)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertTrue(server.metrics().has("treeline_trace_spans_total"))
        self.stop(server)
        return server.log()

    def test_none_of_them_is_felt(self):
        elsewhere = self.collector()

        def redirect(handler):
            handler.send_response(307)
            handler.send_header("Location", elsewhere.endpoint)
            handler.send_header("Content-Length", "0")
            handler.end_headers()

        made = {"silent": self.collector(silent), "busy": self.collector(busy),
                "huge": self.collector(huge),
                "elsewhere": self.collector(redirect)}
        # Side by side: mostly they wait.
        with concurrent.futures.ThreadPoolExecutor() as pool:
            runs = {name: pool.submit(self.check_harmless, bad.endpoint, bad)
                    for name, bad in made.items()}
            runs["absent"] = pool.submit(
                self.check_harmless, f"http://127.0.0.1:{free_port()}{PATH}")
            logs = {name: run.result() for name, run in runs.items()}
        for name, why in (("absent", "the collector cannot be reached"),
                          ("busy", "HTTP status 503"),
                          ("elsewhere", "HTTP status 307")):
            with self.subTest(name):
                self.assertEqual(
                    logs[name].count("traces are not sent: "), 1, logs[name])
                self.assertIn(why, logs[name])
        self.assertEqual(elsewhere.bodies, [])
        # It was left alone, as it wished, and once more asked at the end.
        self.assertLessEqual(len(made["busy"].bodies), 2)

    def test_a_client_without_its_collector_answers_and_ends(self):
        server = self.server()
        done = self.localize(server, OTEL_EXPORTER_OTLP_ENDPOINT=(
            f"http://127.0.0.1:{free_port()}"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("traces are not sent", done.stderr)


class Exemplars(Traced):

    def test_openmetrics_names_the_traces_of_times(self):
        server = self.server()
        self.localize(server)
        self.post(server, LOCALIZE, {"traceparent": TRACEPARENT})
        plain = server.get("/metrics")[1]
        self.assertNotIn(TRACE, plain)
        request = urllib.request.Request(
            f"http://127.0.0.1:{server.http_port}/metrics", headers={
                "Accept": "application/openmetrics-text;version=1.0.0,"
                          "text/plain;version=0.0.4;q=0.5,*/*;q=0.1"})
        with urllib.request.urlopen(request, timeout=60) as answer:
            self.assertEqual(
                answer.headers["Content-Type"],
                "application/openmetrics-text; version=1.0.0; charset=utf-8")
            text = answer.read().decode()
        families = {f.name: f for f in text_string_to_metric_families(text)}
        self.assertEqual(families["treeline_requests"].type, "counter")
        with_exemplar = [
            s for s in families["treeline_request_seconds"].samples
            if s.exemplar is not None]
        self.assertEqual(len(with_exemplar), 1)
        sample = with_exemplar[0]
        self.assertEqual(sample.exemplar.labels, {"trace_id": TRACE})
        self.assertLessEqual(sample.exemplar.value, float(sample.labels["le"]))
        self.assertLess(abs(float(sample.exemplar.timestamp) - time.time()),
                        600)
        # The same figures in both.
        of_plain = {(n, tuple(sorted(l.items()))): v
                    for n, l, v in Metrics(plain).samples
                    if n.startswith("treeline_requests")}
        of_open = {(s.name, tuple(sorted(s.labels.items()))): s.value
                   for s in families["treeline_requests"].samples}
        self.assertEqual(of_open, of_plain)


class Secrets(Traced):

    def test_nothing_secret_is_sent_or_logged(self):
        collector = self.collector()
        key = "correct-horse-battery"
        server = self.server(
            "--log-level", "debug", "--trace-endpoint",
            collector.endpoint.replace("//", f"//user:{key}@"),
            TREELINE_SERVER_TRACE_HEADERS=f"api-key={key}")
        self.post(server, LOCALIZE, {"Authorization": f"Bearer {key}",
                                     "Cookie": key})
        self.stop(server)
        self.assertEqual(collector.headers[0][1]["api-key"], key)
        self.assertNotIn(key, server.log())
        self.assertNotIn(key.encode(), b"".join(collector.bodies))

    def test_wrong_settings_are_told_and_no_secret_with_them(self):
        for flags, variables in (
                (["--trace-endpoint", "collector:4317"], {}),
                (["--trace-ratio", "2"], {}),
                ([], {"TREELINE_SERVER_TRACE_HEADERS": "hunter2hunter2"})):
            program = Program(self.setup, [
                self.setup.program("treeline-server"), "--models", "/nowhere",
                *flags], environment=environment(**variables))
            self.assertEqual(program.wait(), 2)
            self.assertIn("trace_", program.log())
            self.assertNotIn("hunter2", program.log())


if __name__ == "__main__":
    if not is_fetched(NODE_FOLDER):
        print("SKIPPED: npm's packages could not be fetched")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
