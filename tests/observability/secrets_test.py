#!/usr/bin/env python3
"""No token, key, password or signature ever stands in a log or an error.

    secrets_test.py TREE PROGRAMS SCENE
"""

import base64
import http.client
import os
import pathlib
import ssl
import subprocess
import sys
import tempfile
import unittest

TREE = pathlib.Path(sys.argv[1])
PROGRAMS, SCENE = sys.argv[2:4]
sys.path.insert(0, str(TREE / "tests" / "faults"))
from clients import Authority, Credentials, day  # noqa: E402
from harness import Server, Setup, client, first_frame, wait_until  # noqa: E402

LOCALIZE = "/treeline.v1.RelocalizationService/Localize"
STREAM = "/treeline.v1.RelocalizationService/LocalizeStream"
PASSWORD = "correct-horse-battery"
SIGNATURE = "5f3c9ad1e07b"


class WithFolder(unittest.TestCase):

    def setUp(self):
        work = tempfile.TemporaryDirectory()
        self.addCleanup(work.cleanup)
        self.setup = Setup(PROGRAMS, SCENE, work.name, True)
        self.addCleanup(self.setup.__exit__)

    def assert_holds_none(self, text, secrets):
        for secret in secrets:
            self.assertGreater(len(secret), 8)
            at = text.find(secret)
            self.assertEqual(at, -1, text[max(0, at - 200):at + 20])


class Calls(WithFolder):
    """A server with TLS and tokens, at its most talkative."""

    def setUp(self):
        super().setUp()
        self.authority = Authority(self.setup.folder("ca"))
        self.credentials = Credentials(self.setup.folder("tls"))
        self.pair = self.authority.issue("server", -60, day())
        self.credentials.put(self.pair)
        self.keys = self.setup.folder("keys")
        self.signing = self.setup.folder("issuer") / "issuer.key"
        self.openssl("genpkey", "-algorithm", "RSA", "-out", str(self.signing))
        self.openssl("pkey", "-in", str(self.signing), "-pubout", "-out",
                     str(self.keys / "k1.pem"))
        self.records = self.setup.folder("records")
        self.server = Server(
            self.setup, self.setup.models(), *self.credentials.flags(),
            "--auth-keys", self.keys, "--log-level", "debug", "--record",
            self.records)

    def openssl(self, *arguments):
        subprocess.run(["openssl", *arguments], check=True,
                       capture_output=True)

    def token(self, seconds):
        return subprocess.run(
            [TREE / "scripts" / "make-dev-token", self.signing, "k1", "robot",
             "localize", str(seconds)], text=True, capture_output=True,
            check=True).stdout.strip()

    def ask(self, token):
        """treeline-client with a token; what it says."""
        file = self.setup.folder("token") / "token"
        file.write_text(token)
        color, depth = first_frame(self.setup)
        done = client(self.setup, "localize", self.server.address, "--tls-ca",
                      self.authority.ca, "--token-file", file, "--scene",
                      "room", "--color", color, "--depth", depth)
        return done.returncode, done.stdout + done.stderr

    def request(self, path, headers):
        """Over HTTP; (status, what it says)."""
        connection = http.client.HTTPSConnection(
            "127.0.0.1", self.server.http_port, timeout=30,
            context=ssl.create_default_context(cafile=self.authority.ca))
        try:
            connection.request("POST", path, b"{}", {
                "Content-Type": "application/json", **headers})
            answer = connection.getresponse()
            return answer.status, answer.read().decode()
        finally:
            connection.close()

    def test_tokens_are_not_logged_good_or_bad(self):
        good = self.token(3600)
        head, claims, signature = good.split(".")
        bad = {"expired": self.token(-3600),
               "tampered": f"{head}.{claims}.{signature[::-1]}",
               "unsigned": base64.urlsafe_b64encode(
                   b'{"alg":"none"}').decode().rstrip("=") + f".{claims}.",
               "none at all": "hunter2-" + PASSWORD}
        code, said = self.ask(good)
        self.assertEqual(code, 0, said)
        texts = [said]
        for name, token in bad.items():
            with self.subTest(name):
                code, said = self.ask(token)
                self.assertEqual(code, 1, said)
                self.assertIn("UNAUTHENTICATED", said)
                texts.append(said)
        secrets = [good, signature, signature[::-1], claims,
                   bad["expired"].split(".")[2], PASSWORD]
        log = self.server.log()
        self.assertIn("UNAUTHENTICATED", log)
        self.assert_holds_none("\n".join([log, *texts]), secrets)

    def test_what_comes_over_http_is_not_logged(self):
        token = self.token(-3600)
        secret = token.split(".")[2]
        basic = base64.b64encode(f"user:{PASSWORD}".encode()).decode()
        said = [self.request(path, headers) for path, headers in (
            (LOCALIZE, {"Authorization": f"Bearer {token}"}),
            (LOCALIZE, {"Authorization": f"Basic {basic}"}),
            (LOCALIZE, {"Authorization": PASSWORD}),
            (LOCALIZE, {"Cookie": f"session={PASSWORD}"}),
            (f"{LOCALIZE}?access_token={token}", {}),
            (f"/nowhere/{PASSWORD}?X-Amz-Signature={SIGNATURE}", {}),
            (STREAM, {"Upgrade": "websocket", "Connection": "Upgrade",
                      "Sec-WebSocket-Version": "13", "Sec-WebSocket-Key":
                      "dGhlIHNhbXBsZSBub25jZQ==", "Sec-WebSocket-Protocol":
                      f"treeline.v1, treeline.bearer.{token}"}))]
        self.assertTrue(all(status >= 400 for status, _ in said), said)
        self.assert_holds_none(
            self.server.log() + "".join(text for _, text in said),
            [token, secret, basic, PASSWORD, SIGNATURE])

    def test_what_is_kept_of_failed_queries_holds_no_token(self):
        good = self.token(3600)
        file = self.setup.folder("dark") / "dark.jpg"
        color, _ = first_frame(self.setup)
        file.write_bytes(color.read_bytes()[:-200])
        token = self.setup.folder("token") / "token"
        token.write_text(good)
        client(self.setup, "localize", self.server.address, "--tls-ca",
               self.authority.ca, "--token-file", token, "--scene", "room",
               "--color", file)
        wait_until(lambda: list(self.records.glob("*.json")),
                   "a query to be kept", 60)
        kept = "".join(path.read_bytes().decode("latin-1")
                       for path in self.records.iterdir())
        self.assert_holds_none(kept + self.server.log(),
                               [good, good.split(".")[2]])

    def test_a_broken_key_is_complained_of_without_being_shown(self):
        key = self.pair[1]
        middle = key.splitlines()[1]
        broken = key.replace(middle, middle[::-1])
        self.credentials.put((self.pair[0], broken))
        wait_until(lambda: "key.pem" in self.server.log() or
                   "cert.pem" in self.server.log(), "a complaint", 60)
        other = self.authority.issue("other", -60, day())
        self.credentials.put((self.pair[0], other[1]))
        (self.keys / "private.pem").write_text(self.signing.read_text())
        # Keys are looked at when somebody shows a token.
        headers = {"Authorization": f"Bearer {self.token(3600)}"}
        wait_until(lambda: self.request(LOCALIZE, headers) and
                   "private.pem" in self.server.log(), "a complaint", 60, 1)
        self.assert_holds_none(
            self.server.log(),
            [middle, middle[::-1], other[1].splitlines()[1],
             *self.signing.read_text().splitlines()[1:4]])


class Starts(WithFolder):
    """What a server says that does not even start."""

    ADDRESS = (f"https://reader:{PASSWORD}@store.example.com/models/index.json"
               f"?X-Amz-Signature={SIGNATURE}")

    def start(self, *arguments, environment=None):
        done = subprocess.run(
            [self.setup.program("treeline-server"), *arguments], text=True,
            capture_output=True, check=False, timeout=120,
            env={**os.environ, **(environment or {})})
        return done.returncode, done.stdout + done.stderr

    def check(self, code, *arguments, environment=None):
        found, said = self.start(*arguments, environment=environment)
        self.assertEqual(found, code, said)
        self.assertNotEqual(said, "")
        self.assert_holds_none(said, [PASSWORD, SIGNATURE])

    def test_its_configuration_shows_no_password(self):
        self.check(0, "--models", self.ADDRESS, "--cache", "c",
                   "--print-config")
        self.check(0, "--print-config",
                   environment={"TREELINE_SERVER_MODELS": self.ADDRESS,
                                "TREELINE_SERVER_CACHE": "c"})

    def test_a_wrong_configuration_is_told_without_its_secrets(self):
        file = self.setup.folder("config") / "site.yaml"
        for text in (f"models: {self.ADDRESS}\nqueu: 3\n",
                     f"models: {self.ADDRESS}\ncache: c\nqueue: many\n",
                     f"models: [{self.ADDRESS}]\n",
                     f"models: {self.ADDRESS}\nmodels: {self.ADDRESS}\n"):
            file.write_text(text)
            self.check(2, "--config", str(file))

    def test_an_address_that_is_refused_is_told_without_its_secrets(self):
        plain = self.ADDRESS.replace("https:", "http:")
        for arguments in (("--models", self.ADDRESS),  # no cache
                          ("--models", plain, "--cache", "c"),
                          ("--models", plain.replace("http:", "ftp:"),
                           "--cache", "c")):
            with self.subTest(arguments[1][:6]):
                found, said = self.start(*arguments, "--listen", "127.0.0.1:0",
                                         "--http-listen", "", "--admin-listen",
                                         "")
                self.assertIn(found, (1, 2), said)
                self.assert_holds_none(said, [PASSWORD, SIGNATURE])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
