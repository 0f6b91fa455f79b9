#!/usr/bin/env python3
"""Failed queries are shown to those who may, and to nobody else.

    failed_queries_test.py TREE PROGRAMS SCENE
"""

import base64
import http.client
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

TREE = pathlib.Path(sys.argv[1])
PROGRAMS, SCENE = sys.argv[2:4]
sys.path.insert(0, str(TREE / "tests" / "faults"))
from harness import Server, Setup, wait_until  # noqa: E402

LOCALIZE = "/treeline.v1.RelocalizationService/Localize"
TRACE = "0af7651916cd43dd8448eb211c80319c"
TRACEPARENT = f"00-{TRACE}-b7ad6b7169203331-01"
LIST = "/failed-queries"
# One white pixel: too small a picture for any scene.
PNG = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4//8/AAX+Av"
    "4N70a4AAAAAElFTkSuQmCC")


class FailedQueries(unittest.TestCase):

    def setUp(self):
        work = tempfile.TemporaryDirectory()
        self.addCleanup(work.cleanup)
        self.setup = Setup(PROGRAMS, SCENE, work.name, True)
        self.addCleanup(self.setup.__exit__)
        self.records = self.setup.folder("records")

    def server(self, *flags):
        return Server(self.setup, self.setup.models(), "--record",
                      self.records, *flags)

    def ask(self, server, method, path, token="", body=None, headers=None):
        connection = http.client.HTTPConnection("127.0.0.1", server.http_port,
                                                timeout=60)
        try:
            connection.request(method, path, body, {
                **({"Authorization": f"Bearer {token}"} if token else {}),
                **(headers or {})})
            answer = connection.getresponse()
            return answer.status, answer.headers["Content-Type"], answer.read()
        finally:
            connection.close()

    def keep_one(self, server, token=""):
        body = json.dumps({"scene": "room", "frame": {
            "color": {"encoded": base64.b64encode(PNG).decode()}}})
        status, _, _ = self.ask(
            server, "POST", LOCALIZE, token, body,
            {"Content-Type": "application/json", "traceparent": TRACEPARENT})
        self.assertEqual(status, 400)
        wait_until(lambda: list(self.records.glob("*.binpb")), "the record")

    def test_who_may_sees_the_picture_the_reason_and_the_trace(self):
        keys = self.setup.folder("keys")
        issuer = self.setup.folder("issuer") / "issuer.key"
        for command in (
                ["genpkey", "-algorithm", "RSA", "-out", issuer],
                ["pkey", "-in", issuer, "-pubout", "-out", keys / "k1.pem"]):
            subprocess.run(["openssl", *map(str, command)], check=True,
                           capture_output=True)
        tokens = {scope: subprocess.run(
            [TREE / "scripts" / "make-dev-token", issuer, "k1", "someone",
             scope], text=True, capture_output=True, check=True).stdout.strip()
                  for scope in ("localize", "admin", "inspect")}
        server = self.server("--auth-keys", keys)
        self.keep_one(server, tokens["localize"])

        status, kind, body = self.ask(server, "GET", LIST, tokens["inspect"])
        self.assertEqual((status, kind), (200, "application/json"))
        query, = json.loads(body)["queries"]
        self.assertEqual(query["scene"], "room")
        self.assertEqual(query["status"], "INVALID_ARGUMENT")
        self.assertEqual(query["trace_id"], TRACE)
        name = f"{LIST}/{query['name']}"
        status, kind, body = self.ask(server, "GET", name, tokens["inspect"])
        self.assertEqual((status, kind), (200, "application/json"))
        self.assertEqual(json.loads(body)["reason"], query["reason"])
        status, kind, body = self.ask(server, "GET", name + "/picture",
                                      tokens["inspect"])
        self.assertEqual((status, kind, body), (200, "image/png", PNG))

        for path in (LIST, name, name + "/picture", LIST + "/../readyz"):
            for scope, refusal in (("localize", 403), ("admin", 403),
                                   ("", 401)):
                with self.subTest(path=path, scope=scope):
                    status, _, body = self.ask(server, "GET", path,
                                               tokens.get(scope, ""))
                    self.assertEqual(status, refusal)
                    self.assertNotIn(PNG[:20], body)
        for path in ("/../keys/k1.pem", "/%2e%2e/x", "/nothing",
                     f"/{query['name']}.json", "//picture"):
            status, _, _ = self.ask(server, "GET", LIST + path,
                                    tokens["inspect"])
            self.assertIn(status, (400, 404), path)

    def test_without_tokens_nobody_sees_any(self):
        server = self.server()
        self.keep_one(server)
        status, _, body = self.ask(server, "GET", LIST)
        self.assertEqual(status, 403)
        self.assertEqual(json.loads(body)["code"], "permission_denied")

    def test_where_none_are_kept_there_is_no_such_path(self):
        server = Server(self.setup, self.setup.models())
        self.assertEqual(self.ask(server, "GET", LIST)[0], 404)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
