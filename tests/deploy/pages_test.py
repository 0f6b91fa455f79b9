#!/usr/bin/env python3
"""What stands before the servers of docker-compose.yml: haproxy with its
certificate of its own, and the scripts of deploy/.

    pages_test.py TREE PROGRAMS SCENE
"""

import base64
import http.client
import json
import os
import pathlib
import socket
import ssl
import subprocess
import sys
import tempfile
import unittest

TREE = pathlib.Path(sys.argv[1])
PROGRAMS, SCENE = sys.argv[2:4]
sys.path.insert(0, str(TREE / "tests" / "faults"))
from cluster import configuration, haproxy_program  # noqa: E402
from harness import Program, Server, Setup, free_port, wait_until  # noqa: E402

DEPLOY = TREE / "deploy"
LOCALIZE = "/treeline.v1.RelocalizationService/Localize"
# One white pixel: too small a picture for any scene, but it gets to the scene.
PNG = ("iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4//8/AAX+Av"
       "4N70a4AAAAAElFTkSuQmCC")


def run(program, *arguments):
    return subprocess.run([DEPLOY / program, *map(str, arguments)], text=True,
                          capture_output=True, check=False)


class Certificates(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name) / "tls"

    def make(self, *names):
        done = run("make-certificates", self.folder, *names)
        self.assertEqual(done.returncode, 0, done.stderr)
        return (self.folder / "ca.crt").read_bytes(), (
            self.folder / "server.pem").read_bytes()

    def assert_is_for(self, name, yes=True):
        flag = "-verify_ip" if name[0].isdigit() else "-verify_hostname"
        done = subprocess.run(
            ["openssl", "verify", "-CAfile", self.folder / "ca.crt",
             "-purpose", "sslserver", flag, name, self.folder / "server.pem"],
            capture_output=True, check=False)
        self.assertEqual(done.returncode == 0, yes, name)

    def test_what_is_good_is_kept(self):
        first = self.make("robot.local")
        self.assertEqual(self.make("robot.local"), first)
        for name in ("localhost", "127.0.0.1", "robot.local"):
            self.assert_is_for(name)
        self.assert_is_for("example.com", False)

    def test_other_names_take_another_certificate_of_the_same_authority(self):
        authority, certificate = self.make()
        self.assertEqual(self.make("10.1.2.3")[0], authority)
        self.assertNotEqual(self.make("10.1.2.3")[1], certificate)
        self.assert_is_for("10.1.2.3")

    def test_what_was_cut_off_is_made_again(self):
        self.make()
        for name in ("server.pem", "ca.crt", "ca.key"):
            with self.subTest(name=name):
                (self.folder / name).write_bytes(b"")
                self.make()
                self.assert_is_for("localhost")

    def test_keys_are_nobody_elses(self):
        self.make()
        for name in ("ca.key", "server.pem"):
            self.assertEqual((self.folder / name).stat().st_mode & 0o077, 0)

    def test_what_is_no_name_is_refused_in_words(self):
        for name in ("a b", "-x", "${NAMES:-}", "::g", "a:b", "DNS:evil,IP:1.2.3.4", "300.1.1.1", "a\nb"):
            with self.subTest(name=name):
                done = run("make-certificates", self.folder, name)
                self.assertNotEqual(done.returncode, 0)
                self.assertIn("make-certificates:", done.stderr)
                self.assertFalse((self.folder / "server.pem").exists())


class PlaceModel(unittest.TestCase):

    def test_a_scene_appears_once(self):
        with tempfile.TemporaryDirectory() as folder:
            work = pathlib.Path(folder)
            model = work / "from" / "cafe" / "1" / "model.treeline"
            model.parent.mkdir(parents=True)
            model.write_text("first")
            for _ in range(2):
                done = run("place-model", work / "from" / "cafe", work / "to")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(os.listdir(work / "to"), ["cafe"])
                model.write_text("second")
            self.assertEqual((work / "to" / "cafe" / "1" /
                              "model.treeline").read_text(), "first")


class Pages(unittest.TestCase):
    """The balancer's page for browsers, before a real server."""

    @classmethod
    def setUpClass(cls):
        if haproxy_program() is None:
            raise unittest.SkipTest("no haproxy: scripts/install-deps --tools")
        work = tempfile.TemporaryDirectory()
        cls.addClassCleanup(work.cleanup)
        cls.setup = Setup(PROGRAMS, SCENE, work.name, True)
        cls.addClassCleanup(cls.setup.__exit__)
        page = cls.setup.folder("page")
        (page / "index.html").write_text("<title>page</title>")
        server = Server(cls.setup, cls.setup.models(), "--ar-page", page)
        cls.tls = cls.setup.folder("tls")
        assert run("make-certificates", cls.tls).returncode == 0
        cls.ports = {name: free_port() for name in (50050, 8443, 8088, 8404)}
        file = cls.setup.folder("haproxy") / "haproxy.cfg"
        gone = free_port()
        file.write_text(configuration(
            (DEPLOY / "haproxy.cfg").read_text().replace(
                "/tls/", f"{cls.tls}/"),
            [*((f"bind :{of}", f"bind 127.0.0.1:{port}")
               for of, port in cls.ports.items()),
             ("connect port 8080", f"connect port {server.http_port}"),
             ("server-1:50051", f"127.0.0.1:{server.port}"),
             ("server-1:8080", f"127.0.0.1:{server.http_port}"),
             ("server-2:50051", f"127.0.0.1:{gone}"),
             ("server-2:8080", f"127.0.0.1:{gone}")]))
        cls.balancer = Program(cls.setup,
                               [haproxy_program(), "-db", "-f", file])
        cls.addClassCleanup(cls.balancer.process.stdout.close)
        wait_until(lambda: not cls.balancer.running() or cls.is_up(),
                   "haproxy to see a server")
        assert cls.balancer.running(), cls.balancer.log()

    @classmethod
    def is_up(cls):
        try:
            return cls.ask("GET", "/readyz")[0] == 200
        except OSError:
            return False

    @classmethod
    def ask(cls, method, path, body=None, headers=None, plain=None):
        if plain is None:
            trust = ssl.create_default_context(cafile=cls.tls / "ca.crt")
            connection = http.client.HTTPSConnection(
                "localhost", cls.ports[8443], timeout=30, context=trust)
        else:
            connection = http.client.HTTPConnection(
                "localhost", cls.ports[plain], timeout=30)
        try:
            connection.request(method, path, body, headers or {})
            answer = connection.getresponse()
            return answer.status, answer.headers, answer.read()
        finally:
            connection.close()

    def localize(self, origin):
        body = json.dumps({"scene": "room", "frame": {
            "color": {"encoded": PNG}}})
        return self.ask("POST", LOCALIZE, body,
                        {"Content-Type": "application/json",
                         **({"Origin": origin} if origin else {})})

    def test_the_page_comes_over_tls(self):
        status, _, body = self.ask("GET", "/ar/")
        self.assertEqual((status, body), (200, b"<title>page</title>"))
        status, headers, _ = self.ask("GET", "/")
        self.assertEqual((status, headers["Location"]), (302, "/ar/"))

    def test_its_own_page_may_ask_and_a_strangers_may_not(self):
        own = f"https://localhost:{self.ports[8443]}"
        for origin in (own, None):
            status, _, body = self.localize(origin)
            self.assertEqual(status, 400, origin)
            self.assertIn(b"invalid_argument", body)
        for origin in ("https://evil.example", f"{own}.evil.example",
                       own.replace("https", "http"), "https://localhost",
                       "null", f"{own},{own}"):
            status, _, body = self.localize(origin)
            self.assertEqual(status, 403, origin)
            self.assertIn(b"ORIGIN_REFUSED", body)

    def test_a_strangers_page_opens_no_socket(self):
        own = f"https://localhost:{self.ports[8443]}"
        for origin, expected in ((own, 101), ("https://evil.example", 403)):
            trust = ssl.create_default_context(cafile=self.tls / "ca.crt")
            with socket.create_connection(
                    ("127.0.0.1", self.ports[8443]), timeout=30) as plain:
                with trust.wrap_socket(plain, server_hostname="localhost") as s:
                    key = base64.b64encode(os.urandom(16)).decode()
                    s.sendall((f"GET {LOCALIZE}Stream HTTP/1.1\r\n"
                               f"Host: localhost:{self.ports[8443]}\r\n"
                               f"Origin: {origin}\r\n"
                               "Connection: Upgrade\r\nUpgrade: websocket\r\n"
                               f"Sec-WebSocket-Key: {key}\r\n"
                               "Sec-WebSocket-Version: 13\r\n\r\n").encode())
                    head = s.recv(64).decode()
                    self.assertRegex(head, rf"^HTTP/1.1 {expected} ", origin)

    def test_what_is_for_operators_is_not_there(self):
        self.assertEqual(self.ask("GET", "/metrics")[0], 404)
        status, _, body = self.ask("GET", "/metrics", plain=8404)
        self.assertEqual(status, 200)
        self.assertIn(b"haproxy_server_status", body)

    def test_phones_get_the_authority_and_the_way(self):
        status, headers, body = self.ask("GET", "/ca.crt", plain=8088)
        self.assertEqual(status, 200)
        self.assertEqual(headers["Content-Type"],
                         "application/x-x509-ca-cert")
        self.assertEqual(body, (self.tls / "ca.crt").read_bytes())
        for path in ("/", "/ca.key", "/server.pem", "/x/../ca.key"):
            status, headers, _ = self.ask("GET", path, plain=8088)
            self.assertEqual((status, headers["Location"]),
                             (302, "https://localhost:8443/ar/"), path)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
