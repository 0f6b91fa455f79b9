"""A collector of traces for tests: a real HTTP server, and OpenTelemetry's own
decoder of what it was sent."""

import base64
import http.server
import json
import pathlib
import subprocess
import threading

PATH = "/v1/traces"


class Collector:
    """Answers as `behave(handler)` does; None: as collectors do."""

    def __init__(self, behave=None):
        self.bodies = []
        self.headers = []
        # Set when a request has come, whatever the answer.
        self.asked = threading.Event()
        collector = self

        class Handler(http.server.BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_POST(self):  # pylint: disable=invalid-name
                length = int(self.headers["Content-Length"])
                body = self.rfile.read(length)
                collector.headers.append((self.path, dict(self.headers)))
                collector.bodies.append(body)
                collector.asked.set()
                if behave is None:
                    self.send_response(200)
                    self.send_header("Content-Length", "0")
                    self.end_headers()
                else:
                    behave(self)

            def log_message(self, *_):
                pass

        self._server = http.server.ThreadingHTTPServer(("127.0.0.1", 0),
                                                       Handler)
        self._server.daemon_threads = True
        self.base = f"http://127.0.0.1:{self._server.server_port}"
        self.endpoint = self.base + PATH
        threading.Thread(target=self._server.serve_forever, args=(0.02,),
                         daemon=True).start()

    def close(self):
        self._server.shutdown()
        self._server.server_close()


class Span:
    """One span as the collector has it."""

    def __init__(self, service, message):
        self.service = service
        self.trace = message["traceId"]
        self.id = message["spanId"]
        self.parent = message.get("parentSpanId", "")
        self.name = message["name"]
        self.kind = message["kind"]
        self.start = int(message["startTimeUnixNano"])
        self.end = int(message["endTimeUnixNano"])
        self.attributes = {a["key"]: value_of(a["value"])
                           for a in message.get("attributes", [])}
        self.status = message.get("status", {})


def value_of(value):
    (kind, plain), = value.items()
    return int(plain) if kind == "intValue" else plain


def decoded(folder, bodies):
    """The requests as OpenTelemetry's code reads them, and Node prints them.

    folder: of package.json's node_modules and decode_otlp.js.
    """
    lines = "".join(base64.b64encode(body).decode() + "\n" for body in bodies)
    done = subprocess.run(["node", "decode_otlp.js"], cwd=folder, input=lines,
                          text=True, capture_output=True, check=False)
    if done.returncode != 0:
        raise AssertionError("no request of OTLP: " + done.stderr[-2000:])
    return [json.loads(line) for line in done.stdout.splitlines()]


def spans_of(folder, bodies):
    spans = []
    for request in decoded(folder, bodies):
        for of_resource in request["resourceSpans"]:
            resource = {a["key"]: value_of(a["value"])
                        for a in of_resource["resource"]["attributes"]}
            for of_scope in of_resource["scopeSpans"]:
                assert of_scope["scope"]["name"] == "treeline"
                for message in of_scope["spans"]:
                    span = Span(resource["service.name"], message)
                    span.resource = resource
                    spans.append(span)
    return spans


def is_fetched(folder):
    return (pathlib.Path(folder) / "node_modules" / "@opentelemetry").is_dir()
