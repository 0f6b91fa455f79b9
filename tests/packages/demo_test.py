"""treeline-demo goes through its steps, and leaves nothing behind.

    demo_test.py PACKAGING
"""

import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

from packaging import arguments

PACKAGING, = arguments(1)
DEMO = PACKAGING / "treeline-demo"
TABLE = PACKAGING.parents[1] / "scripts" / "lib" / "demo_table.py"

# A program that notes its words and does what FAILS, WAITS and JSON say.
TREELINE = r"""#!/usr/bin/python3
import json, os, pathlib, sys, time
words = sys.argv[1:]
if words == ["--version"]:
    print("treeline 1.2.3")
    sys.exit()
with open(os.environ["CALLS"], "a") as calls:
    calls.write(" ".join(["treeline", *words]) + "\n")
if os.environ.get("FAILS") == words[0]:
    sys.exit("no room on this device")
if os.environ.get("WAITS") == words[0]:
    time.sleep(600)
options = dict(zip(words, words[1:]))
if words[0] == "evaluate":
    pathlib.Path(options["--json"]).write_text(os.environ["OFFLINE"])
"""
SERVER = r"""#!/usr/bin/python3
import os, signal, sys
if os.environ.get("FAILS") == "server":
    sys.exit("address in use")
def stop(*_):
    with open(os.environ["CALLS"], "a") as calls:
        calls.write("server stopped\n")
    os._exit(0)
signal.signal(signal.SIGTERM, stop)
print("listening on 127.0.0.1:4711", flush=True)
signal.pause()
"""
CLIENT = r"""#!/bin/sh
echo "client $*" >>"$CALLS"
printf '%s\n' "$SERVED"
"""
POSE = {"qw": 1, "qx": 0, "qy": 0, "qz": 0, "tx": 0, "ty": 0, "tz": 0}
FRAME = {"stem": "a", "inliers": 9, "outcome": "LOCALIZED",
         "world_from_camera": POSE}
OFFLINE = json.dumps({
    "per_frame": [{**FRAME, "true_world_from_camera": POSE}],
    "model": {"training": {"seconds": 1, "frames": 2}, "trees": 3,
              "leaves": 4, "file_bytes": 5}})
SERVED = {**FRAME, "round_trip_ms": 8,
          "server": {"decode_ms": 4, "localize_ms": 3}}


class DemoTest(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.temporary = self.folder / "tmp"
        self.temporary.mkdir()
        for name, text in (("treeline", TREELINE), ("treeline-server", SERVER),
                           ("treeline-client", CLIENT)):
            program = self.folder / "bin" / name
            program.parent.mkdir(exist_ok=True)
            program.write_text(text)
            program.chmod(0o755)
        (self.folder / "share" / "demo").mkdir(parents=True)
        shutil.copy(TABLE, self.folder / "share" / "demo")
        self.calls = self.folder / "calls"
        self.calls.write_text("")

    def start(self, *words, served=None, **variables):
        return subprocess.Popen(
            [DEMO, *words], text=True, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, stdin=subprocess.DEVNULL,
            start_new_session=True, cwd=self.folder,
            env={**os.environ, "TMPDIR": str(self.temporary),
                 "TREELINE_DEMO_BIN": str(self.folder / "bin"),
                 "TREELINE_DEMO_SHARE": str(self.folder / "share"),
                 "CALLS": str(self.calls), "OFFLINE": OFFLINE,
                 "SERVED": json.dumps(served or SERVED), **variables})

    def demo(self, *words, **more):
        process = self.start(*words, **more)
        out, errors = process.communicate(timeout=60)
        return process.returncode, out, errors

    def assert_nothing_is_left(self):
        self.assertEqual(list(self.temporary.iterdir()), [])

    def test_it_records_learns_serves_asks_and_compares(self):
        code, out, errors = self.demo("--frames", "50")
        self.assertEqual(code, 0, out + errors)
        calls = self.calls.read_text().splitlines()
        self.assertEqual([" ".join(call.split()[:2]) for call in calls],
                         ["treeline synth", "treeline train",
                          "treeline evaluate", "client localize",
                          "server stopped"])
        self.assertIn("--frames 50", calls[0])
        self.assertIn("--server 127.0.0.1:4711", calls[3])
        self.assertIn("bit for bit", out)
        self.assertIn("Everything took", out)
        self.assert_nothing_is_left()

    def test_what_was_made_can_be_kept(self):
        code, out, errors = self.demo("--out", "kept here")
        self.assertEqual(code, 0, out + errors)
        self.assertTrue((self.folder / "kept here/offline.json").is_file())
        # And is not written over.
        code, _, errors = self.demo("--out", "kept here")
        self.assertEqual(code, 2)
        self.assertIn("kept here is not empty", errors)

    def test_a_step_that_fails_says_why(self):
        for step, words in (("train", "no room on this device"),
                            ("server", "address in use")):
            with self.subTest(step=step):
                code, _, errors = self.demo(FAILS=step)
                self.assertEqual(code, 1)
                self.assertIn(words, errors)
                self.assert_nothing_is_left()

    def test_another_answer_than_the_models_is_a_failure(self):
        code, out, errors = self.demo(served={**SERVED, "inliers": 8})
        self.assertEqual(code, 1, out)
        self.assertIn("9 inliers offline, 8 through", errors)
        self.assertIn("server stopped", self.calls.read_text())
        self.assert_nothing_is_left()

    def test_interrupted_it_leaves_nothing(self):
        process = self.start(WAITS="train")
        until = time.monotonic() + 60
        while ("train" not in self.calls.read_text() and
               time.monotonic() < until):
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGINT)
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.assert_nothing_is_left()

    def test_wrong_usage_is_refused(self):
        for words in (["--wurld"], ["--frames"], ["--frames", "many"]):
            code, _, errors = self.demo(*words)
            self.assertEqual(code, 2, errors)
        self.assertEqual(self.calls.read_text(), "")

    def test_help_and_version(self):
        code, out, _ = self.demo("--help")
        self.assertEqual(code, 0)
        self.assertIn("Usage: treeline-demo", out)
        code, out, _ = self.demo("--version")
        self.assertEqual((code, out), (0, "treeline-demo 1.2.3\n"))


if __name__ == "__main__":
    unittest.main(argv=["demo_test.py"])
