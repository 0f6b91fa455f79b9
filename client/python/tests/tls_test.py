"""TLS, with the certificates of the C++ client's tests."""

import os
import pathlib
import re
import tempfile
import time
import unittest

import grpc
from fake_server import Server

import treeline
from treeline import errors

CERTIFICATES = (pathlib.Path(__file__).resolve().parents[2] / "relocalizer" /
                "testing_certificates.h")
PATIENCE_S = 30
JPEG = b"\xff\xd8\xff rest"


def pem(name):
    text = CERTIFICATES.read_text()
    return re.search(rf'{name}\[\] = R"\((.*?)\)"', text, re.S)[1]


class Tls(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def file(self, name, content):
        """Replaces it whole, as who renews certificates should."""
        path = self.folder / name
        (self.folder / "new").write_text(content)
        os.replace(self.folder / "new", path)
        return path

    def serve(self, client_authority=None):
        server = Server(credentials=grpc.ssl_server_credentials(
            [(pem("kServerKey").encode(), pem("kServer").encode())],
            client_authority and pem(client_authority).encode(),
            client_authority is not None))
        self.addCleanup(server.stop)
        return server

    def connect(self, server, tls, **options):
        client = treeline.Client(server.address, tls=tls, **options)
        self.addCleanup(client.close)
        return client

    def test_a_server_of_a_trusted_authority_is_asked(self):
        server = self.serve()
        ca_file = self.file("ca.crt", pem("kAuthority"))
        client = self.connect(server, treeline.Tls(ca_file), token="abc")
        self.assertFalse(client.localize(JPEG))
        self.assertEqual(server.service.metadata[0]["authorization"],
                         "Bearer abc")
        # Two servers with one name.
        both = treeline.Client([server.address, self.serve().address],
                               tls=treeline.Tls(ca_file))
        self.addCleanup(both.close)
        self.assertFalse(both.localize(JPEG))

    def test_another_authority_or_another_name_is_not(self):
        server = self.serve()
        other = self.file("other.crt", pem("kOtherAuthority"))
        with self.assertRaisesRegex(errors.Unavailable, server.address):
            self.connect(server, treeline.Tls(other)).localize(JPEG)
        ca_file = self.file("ca.crt", pem("kAuthority"))
        wrong = treeline.Tls(ca_file, server_name="treeline.example")
        with self.assertRaises(errors.Unavailable):
            self.connect(server, wrong).localize(JPEG)
        right = treeline.Tls(ca_file, server_name="treeline.test")
        self.assertFalse(self.connect(server, right).localize(JPEG))

    def test_a_client_shows_its_certificate(self):
        server = self.serve("kAuthority")
        ca_file = self.file("ca.crt", pem("kAuthority"))
        with self.assertRaises(errors.Unavailable):
            self.connect(server, treeline.Tls(ca_file)).localize(JPEG)
        mutual = treeline.Tls(ca_file, self.file("own.crt", pem("kClient")),
                              self.file("own.key", pem("kClientKey")))
        self.assertFalse(self.connect(server, mutual).localize(JPEG))

    def test_files_that_change_are_read_again(self):
        server = self.serve()
        ca_file = self.file("ca.crt", pem("kOtherAuthority"))
        client = self.connect(server, treeline.Tls(ca_file), max_attempts=1)
        with self.assertRaises(errors.Unavailable):
            client.localize(JPEG)
        self.file("ca.crt", "half a certifi")
        time.sleep(1.1)  # files are looked at once a second
        with self.assertRaises(errors.Unavailable):
            client.localize(JPEG)
        self.file("ca.crt", pem("kAuthority"))
        end = time.monotonic() + PATIENCE_S
        while True:
            try:
                self.assertFalse(client.localize(JPEG))
                break
            except errors.Unavailable:
                self.assertLess(time.monotonic(), end)
                time.sleep(0.05)

    def test_a_call_that_waits_survives_new_certificates(self):
        server = self.serve()
        ca_file = self.file("ca.crt", pem("kAuthority"))
        client = self.connect(server, treeline.Tls(ca_file))
        stream = client.stream(
            frame for frame in [JPEG] * 3 if time.sleep(0.8) is None)
        self.assertEqual(next(stream).index, 0)
        self.file("ca.crt", pem("kAuthority") + pem("kOtherAuthority"))
        self.assertFalse(client.localize(JPEG))
        time.sleep(0.6)
        self.assertFalse(client.localize(JPEG))
        self.assertEqual([a.index for a in stream], [1, 2])

    def test_what_cannot_work_is_refused(self):
        ca_file = self.file("ca.crt", pem("kAuthority"))
        empty = self.file("empty.crt", "nothing")
        with self.assertRaisesRegex(ValueError, "go together"):
            treeline.Tls(ca_file, certificate_file=ca_file)
        with self.assertRaisesRegex(ValueError, "empty.crt: there is no"):
            treeline.Client("127.0.0.1:1", tls=treeline.Tls(empty))
        with self.assertRaises(FileNotFoundError):
            treeline.Client("127.0.0.1:1", tls=treeline.Tls("/nowhere"))
        with self.assertRaisesRegex(ValueError, "all their certificates"):
            treeline.Client("127.0.0.1:1,127.0.0.2:1",
                            tls=treeline.Tls(ca_file))


if __name__ == "__main__":
    unittest.main()
