"""What a release has left on machines and sends over wires is understood today.

    upgrade_test.py TREE BIN SCENE

Reads tests/upgrade/kept/VERSION of every release. BIN holds today's programs,
SCENE room.treeline of tests/integration/make_scene.cmake.
"""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import urllib.request

TREE, BIN, SCENE = (pathlib.Path(path) for path in sys.argv[1:4])
sys.path.insert(0, str(TREE / "client" / "python" / "tests"))
from keep_release import MESSAGES, decoded  # noqa: E402
from real_server import RealServer, put_scene  # noqa: E402

KEPT = TREE / "tests" / "upgrade" / "kept"
LOCALIZE = "/treeline.v1.RelocalizationService/Localize"


def releases():
    return sorted(KEPT.iterdir())


def run(*command):
    return subprocess.run([str(word) for word in command], capture_output=True,
                          text=True, check=False, env={})


class UpgradeTest(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_something_was_kept(self):
        self.assertTrue(releases())

    def test_configuration_holds_and_means_the_same(self):
        for kept in releases():
            for program, command in (("server", ["treeline-server"]),
                                     ("agent", ["treeline-agent", "run"])):
                with self.subTest(release=kept.name, program=program):
                    file = kept / f"{program}.yaml"
                    done = run(BIN / command[0], *command[1:], "--config",
                               file, "--print-config")
                    self.assertEqual(done.returncode, 0, done.stderr)
                    now = dict(re.findall(r"(?m)^(\w+): (.*?)  # ",
                                          done.stdout))
                    for name, value in re.findall(r"(?m)^(\w+): (.*)$",
                                                  file.read_text()):
                        self.assertEqual(same(now[name]), same(value), name)

    def test_messages_have_the_same_fields(self):
        for kept in releases():
            for name, message in MESSAGES.items():
                with self.subTest(release=kept.name, message=message):
                    text = decoded(TREE, message,
                                   (kept / f"{name}.binpb").read_bytes())
                    self.assertEqual(text,
                                     (kept / f"{name}.txtpb").read_text())
                    # A field that nobody knows is shown as a number.
                    self.assertNotRegex(text, r"(?m)^\s*\d+[ :{]")

    def test_a_server_answers_an_old_query(self):
        put_scene(self.folder / "models", SCENE / "room.treeline")
        server = RealServer(BIN / "treeline-server", self.folder / "models")
        self.addCleanup(server.stop)
        for kept in releases():
            with self.subTest(release=kept.name):
                request = urllib.request.Request(
                    f"http://{server.http}{LOCALIZE}",
                    data=(kept / "request.binpb").read_bytes(),
                    headers={"Content-Type": "application/proto",
                             "Connect-Protocol-Version": "1"})
                with urllib.request.urlopen(request, timeout=60) as reply:
                    answer = decoded(TREE, "LocalizeResponse", reply.read())
                # Of sixteen pixels nothing can be localized.
                self.assertIn("outcome: OUTCOME_NOT_LOCALIZED", answer)
                self.assertIn('scene: "room"', answer)

    def test_a_model_is_read(self):
        for kept in releases():
            with self.subTest(release=kept.name):
                done = run(BIN / "treeline", "inspect",
                           kept / "model.bin")
                self.assertEqual(done.returncode, 0, done.stderr)


def same(value):
    """A value of YAML, however it is quoted and whatever its digits."""
    value = value.strip("\"'")
    try:
        return float(value)
    except ValueError:
        return value


if __name__ == "__main__":
    unittest.main(argv=["upgrade_test.py"])
