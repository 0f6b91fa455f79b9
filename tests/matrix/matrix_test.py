"""One query by every client: the same pose, or the same reason why not.

    matrix_test.py PROGRAMS SCENE PACKAGE WORK BUNDLER

PROGRAMS holds treeline-server and treeline-client; SCENE is a folder with
recording/ and room.treeline, of tests/integration/make_scene.cmake. PACKAGE and
WORK are those of scripts/build-typescript, BUNDLER the work folder of
scripts/build-bench-report, which has esbuild and playwright-core; where they
are not, clients of node are left out, in words. The clients: clients.py.
"""

import io
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import types
import unittest

import jsonschema
import numpy as np
from PIL import Image
from clients import (ORIGIN, ConnectJson, Cpp, GeoPose, Python, Query,
                     TypeScript)
from real_server import ANCHOR, RealServer, put_scene

import treeline
from treeline import geodesy

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAMS, SCENE = (pathlib.Path(a) for a in sys.argv[1:3])
PACKAGE, WORK, BUNDLER = (pathlib.Path(a) for a in sys.argv[3:6])
RECORDING = SCENE / "recording"
STEMS = (RECORDING / "test.txt").read_text().split()[:8]
KEY = "2026-11"
GEOPOSE = ROOT / "tests" / "interop" / "geopose"


def assert_geopose(value, name):
    """By the schema of that name, of the GeoPose standard."""
    schema = json.loads((GEOPOSE / f"{name}.schema.json").read_text())
    jsonschema.Draft7Validator(schema).validate(value)


def node_clients():
    """Name and command of those that can run here."""
    here = pathlib.Path(__file__).resolve().parent
    node = shutil.which("node")
    packages = sorted(PACKAGE.glob("treeline-client-*.tgz"))
    if not node or not packages or not (WORK / "node_modules").is_dir():
        print("without Node and browser: there is no package @treeline/client")
        return {}
    os.environ.update(TREELINE_PACKAGE=str(packages[-1]),
                      TREELINE_PACKAGE_WORK=str(WORK),
                      TREELINE_BUNDLER=str(BUNDLER))
    commands = {"Node": [node, here / "node_client.js"]}
    if shutil.which("chromium") and (BUNDLER / "node_modules").is_dir():
        commands["browser"] = [node, here / "browser_client.js", ORIGIN]
    else:
        print("without browser: there is no chromium, or no playwright-core")
    return commands


def query_of(stem, **fields):
    return Query(**{"color": (RECORDING / f"{stem}.color.jpg").read_bytes(),
                    "depth": (RECORDING / f"{stem}.depth.png").read_bytes(),
                    **fields})


def png(array):
    out = io.BytesIO()
    Image.fromarray(array).save(out, "PNG")
    return out.getvalue()


class Server(RealServer):
    """With flags of its own."""

    def __init__(self, models, *flags):
        self._process = subprocess.Popen(
            [PROGRAMS / "treeline-server", "--models", models, "--listen",
             "127.0.0.1:0", "--admin-listen", "", "--http-listen",
             "127.0.0.1:0", "--drain-s", "0", "--cors-origin", ORIGIN,
             *flags], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            text=True)
        self.address = self._line(r"listening on (.*)$")
        self.http = self._line(r"http on (.*)$")


class Matrix(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.models = cls.folder / "models"
        put_scene(cls.models, SCENE / "room.treeline")
        broken = cls.models / "broken" / "1"
        broken.mkdir(parents=True)
        model = (SCENE / "room.treeline").read_bytes()
        (broken / "model.treeline").write_bytes(model[:len(model) // 2])
        cls.server = cls.start()
        cls.clients = {"C++": Cpp(PROGRAMS / "treeline-client"),
                       "Python": Python(), "Connect JSON": ConnectJson()}
        for name, command in node_clients().items():
            cls.clients[name] = TypeScript(*command)
            cls.addClassCleanup(cls.clients[name].stop)
        cls.geo = GeoPose()

    @classmethod
    def start(cls, *flags):
        server = Server(cls.models, *flags)
        cls.addClassCleanup(server.stop)
        return server

    def agreed(self, query, server=None, geopose=False):
        """What all of them say; an answer bit for bit."""
        server = server or self.server
        answers = {name: client.ask(server, query)
                   for name, client in self.clients.items()}
        if geopose:
            answers["GeoPose"] = self.geo.ask(server, query)
        first = answers["C++"]
        for name, answer in answers.items():
            self.assertEqual(answer, first, f"{name} and C++")
        return first

    def error(self, code, reason, query, **options):
        self.assertEqual(self.agreed(query, **options),
                         {"outcome": "ERROR", "code": code, "reason": reason})

    def test_the_same_pose(self):
        localized = 0
        anchor = geodesy.GeoAnchor(
            ANCHOR["latitude_deg"], ANCHOR["longitude_deg"],
            ANCHOR["height_m"],
            tuple(ANCHOR["enu_from_world"][c] for c in "wxyz"))
        with treeline.Client(self.server.address) as client:
            calibration = client.scene("room").model.calibration
        for stem in STEMS:
            with self.subTest(stem):
                answer = self.agreed(query_of(stem))
                on_earth = self.geo.ask(self.server, query_of(stem))
                self.assertEqual(on_earth["outcome"], answer["outcome"])
                if answer["outcome"] != "LOCALIZED":
                    continue
                localized += 1
                self.check_geopose(
                    on_earth["geopose"],
                    geodesy.geo_pose(calibration.color_pose(
                        types.SimpleNamespace(
                            world_from_camera=treeline.geometry.pose(
                                answer["pose"][:4], answer["pose"][4:]),
                            pose_sensor=calibration.pose_sensor)), anchor))
        self.assertGreaterEqual(localized, len(STEMS) // 2)

    def check_geopose(self, said, true):
        for name in ("basic_quaternion", "basic_quaternion_strict"):
            assert_geopose(said, name)
            assert_geopose(true.as_json(), name)
        assert_geopose(true.as_ypr_json(), "basic_ypr")
        with self.assertRaises(jsonschema.ValidationError):
            assert_geopose(said, "basic_ypr")
        # A degree is 1.1e5 m: 1e-11 of one is a micrometre.
        position = said["position"]
        self.assertAlmostEqual(position["lat"], true.latitude_deg, delta=1e-10)
        self.assertAlmostEqual(position["lon"], true.longitude_deg,
                               delta=1e-10)
        self.assertAlmostEqual(position["h"], true.height_m, delta=1e-5)
        ours = np.array([said["quaternion"][c] for c in "wxyz"])
        theirs = np.array(true.enu_from_device_wxyz)
        self.assertGreater(abs(ours @ theirs), 1 - 1e-12)

    def test_the_same_word_for_no_pose(self):
        blind = png(np.zeros((480, 640), np.uint16))
        answer = self.agreed(query_of(STEMS[0], depth=blind), geopose=True)
        self.assertEqual(answer, {"outcome": "TOO_FEW_SAMPLES"})

    def test_an_unknown_scene(self):
        self.error("NOT_FOUND", "SCENE_NOT_FOUND",
                   query_of(STEMS[0], scene="attic"))

    def test_an_unknown_version(self):
        self.error("NOT_FOUND", "VERSION_NOT_FOUND",
                   query_of(STEMS[0], version="9"))

    def test_what_is_no_name_of_a_scene(self):
        self.error("INVALID_ARGUMENT", "SCENE_NAME_INVALID",
                   query_of(STEMS[0], scene="../room"))

    def test_a_corrupt_model(self):
        self.error("DATA_LOSS", "MODEL_CORRUPT",
                   query_of(STEMS[0], scene="broken"))

    def test_a_bad_image(self):
        picture = query_of(STEMS[0]).color
        # A file that ends in the middle, and one that is no picture.
        for color in (picture[:len(picture) // 2],
                      picture[:200] + bytes(2000)):
            self.error("INVALID_ARGUMENT", "INVALID_REQUEST",
                       query_of(STEMS[0], color=color), geopose=True)

    def test_a_picture_of_another_size(self):
        small = io.BytesIO()
        Image.new("RGB", (64, 48)).save(small, "JPEG")
        self.error("INVALID_ARGUMENT", "INVALID_REQUEST",
                   query_of(STEMS[0], color=small.getvalue()), geopose=True)

    def test_no_depth_where_it_is_needed(self):
        self.error("INVALID_ARGUMENT", "INVALID_REQUEST",
                   query_of(STEMS[0], depth=None), geopose=True)

    def token(self, scopes, seconds=3600):
        return subprocess.run(
            [ROOT / "scripts" / "make-dev-token", self.folder / "issuer.key",
             KEY, "matrix", scopes, str(seconds)], check=True,
            capture_output=True, text=True).stdout.strip()

    def test_tokens(self):
        key = self.folder / "issuer.key"
        (self.folder / "keys").mkdir()
        for command in (
            ["openssl", "genpkey", "-algorithm", "RSA", "-pkeyopt",
             "rsa_keygen_bits:2048", "-out", key],
            ["openssl", "pkey", "-in", key, "-pubout", "-out",
             self.folder / "keys" / f"{KEY}.pem"]):
            subprocess.run(command, check=True, capture_output=True)
        server = self.start("--auth-keys", str(self.folder / "keys"))
        options = {"server": server, "geopose": True}
        self.error("UNAUTHENTICATED", "TOKEN_MISSING", query_of(STEMS[0]),
                   **options)
        good = self.token("localize")
        head, _, signature = good.rpartition(".")
        changed = f"{head}.{'A' if signature[0] != 'A' else 'B'}{signature[1:]}"
        self.error("UNAUTHENTICATED", "TOKEN_INVALID",
                   query_of(STEMS[0], token=changed), **options)
        # Clocks may differ by a minute.
        self.error("UNAUTHENTICATED", "TOKEN_EXPIRED",
                   query_of(STEMS[0], token=self.token("localize", -3600)),
                   **options)
        self.error("PERMISSION_DENIED", "SCOPE_MISSING",
                   query_of(STEMS[0], token=self.token("other")), **options)
        self.assertEqual(
            self.agreed(query_of(STEMS[0], token=good), server),
            self.agreed(query_of(STEMS[0])))

    def test_too_large(self):
        """The one thing that the transports say differently: gRPC refuses a
        large message before the server could give a reason."""
        server = self.start("--max-message-mib", "1")
        noise = np.random.default_rng(7).integers(
            0, 256, (800, 800, 3), np.uint8)
        query = query_of(STEMS[0], color=png(noise))
        self.assertGreater(len(query.color), 1 << 20)
        clients = {**self.clients, "GeoPose": self.geo}
        for name, client in clients.items():
            reason = "" if name in ("C++", "Python") else "REQUEST_TOO_LARGE"
            self.assertEqual(client.ask(server, query),
                             {"outcome": "ERROR", "code": "RESOURCE_EXHAUSTED",
                              "reason": reason}, name)

    def test_too_late(self):
        """A client's own clock may be the first: then nobody gave a reason. A
        worker may still be at the query before: then the server says at once
        that this one would be too late."""
        for name, client in self.clients.items():
            answer = client.ask(self.server,
                                query_of(STEMS[0], timeout_s=0.0011))
            self.assertEqual(answer["outcome"], "ERROR", name)
            self.assertIn((answer["code"], answer["reason"]),
                          (("DEADLINE_EXCEEDED", ""),
                           ("DEADLINE_EXCEEDED", "DEADLINE_EXCEEDED"),
                           ("UNAVAILABLE", "DEADLINE_UNREACHABLE")), name)

    def test_the_reasons_are_those_of_the_table(self):
        page = (ROOT / "docs" / "reference" / "service.md").read_text()
        page += (ROOT / "docs" / "reference" / "http.md").read_text()
        reasons = set(re.findall(r'"([A-Z]+_[A-Z_]+)"',
                                 pathlib.Path(__file__).read_text()))
        for reason in reasons:
            self.assertIn(f"`{reason}`", page)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
