"""scripts/demo leads through its steps, fails with a word, cleans up."""

import json
import os
import signal
import subprocess
import time
import unittest

from stub_programs import ScriptTest

TREELINE = r"""#!/usr/bin/env python3
import json, os, pathlib, sys
arguments = dict(zip(sys.argv[1:], sys.argv[2:]))
with open(os.environ["CALLS"], "a") as calls:
    calls.write(" ".join(["treeline", *sys.argv[1:]]) + "\n")
if sys.argv[1] == "synth":
    folder = pathlib.Path(arguments["--output"])
    folder.mkdir(parents=True)
    (folder / "train.txt").write_text("seq-01/frame-000000\n")
    (folder / "test.txt").write_text("seq-01/frame-000001\n")
if sys.argv[1] == "train":
    pathlib.Path(arguments["--output"]).write_text("model")
    sys.exit(int(os.environ.get("TRAIN_STATUS", "0")))
if sys.argv[1] == "evaluate":
    if "NO_TEMPLATE" not in os.environ:
        pathlib.Path(arguments["--report"]).write_text("<html>")
    pathlib.Path(arguments["--json"]).write_text(os.environ["OFFLINE"])
"""

SERVER = r"""#!/usr/bin/env python3
import os, signal, sys
with open(os.environ["CALLS"], "a") as calls:
    calls.write(" ".join(["server", *sys.argv[1:]]) + "\n")
if "REFUSAL" in os.environ:
    sys.exit(os.environ["REFUSAL"])
def stop(*_):
    with open(os.environ["CALLS"], "a") as calls:
        calls.write("server stopped\n")
    os._exit(int(os.environ.get("SERVER_STATUS", "0")))
signal.signal(signal.SIGTERM, stop)
print("treeline-server 0.1.0\nlistening on 127.0.0.1:4711", flush=True)
while True:
    signal.pause()
"""

CLIENT = r"""#!/usr/bin/env python3
import os, sys, time
with open(os.environ["CALLS"], "a") as calls:
    calls.write(" ".join(["client", *sys.argv[1:]]) + "\n")
time.sleep(float(os.environ.get("CLIENT_SECONDS", "0")))
print(os.environ["SERVED"])
"""

POSE = {"qw": 1, "qx": 0, "qy": 0, "qz": 0, "tx": 0, "ty": 0, "tz": 0.25}
OFFLINE = {
    "per_frame": [{"stem": "seq-01/frame-000001", "outcome": "LOCALIZED",
                   "inliers": 9, "world_from_camera": POSE,
                   "true_world_from_camera": POSE}],
    "model": {"training": {"seconds": 1, "frames": 1}, "file_bytes": 1,
              "trees": 1, "leaves": 1}}
SERVED = {"stem": "seq-01/frame-000001", "outcome": "LOCALIZED", "inliers": 9,
          "world_from_camera": POSE, "round_trip_ms": 5,
          "server": {"decode_ms": 2, "localize_ms": 2}}


class DemoTest(ScriptTest):

    def setUp(self):
        super().setUp()
        self.calls = self.root / "calls"
        for name in ("install-deps", "build-report"):
            self.write_program(self.root / "scripts" / name, "#!/bin/sh\n")
        self.write_program(
            self.root / "scripts/build",
            f'#!/bin/sh\necho "build $*" >>{self.calls}\n')
        for name, text in (("treeline", TREELINE), ("treeline-server", SERVER),
                           ("treeline-client", CLIENT)):
            self.write_program(self.root / "build/release/bin" / name, text)
        self.variables = {"CALLS": str(self.calls),
                          "OFFLINE": json.dumps(OFFLINE),
                          "SERVED": json.dumps(SERVED)}

    def demo(self, *arguments, cwd=None, **variables):
        return self.run_script("demo", *arguments, cwd=cwd,
                               **{**self.variables, **variables})

    def calls_made(self):
        return self.calls.read_text().splitlines()

    def recording(self, *names):
        folder = self.root / "real scene"
        folder.mkdir()
        for name in names:
            (folder / name).write_text("seq-01/frame-000001\n")
        return folder

    def test_records_learns_serves_asks_and_compares(self):
        done = self.demo("--frames", "40", "--seed", "7")
        self.assertEqual(done.returncode, 0, done.stderr)
        out = self.root / "out/demo"
        build, synth, train, evaluate, server, client, stop = self.calls_made()
        self.assertEqual(build,
                         "build release treeline treeline-server "
                         "treeline-client")
        self.assertEqual(synth, "treeline synth record --world room --output "
                         f"{out}/recording/room --frames 40")
        self.assertIn("--seed 7 --output "
                      f"{out}/models/room/1/model.treeline", train)
        self.assertIn(f"--frames {out}/recording/room/train.txt", train)
        self.assertIn(f"--frames {out}/recording/room/test.txt", evaluate)
        self.assertIn("--seed 7 --threads 1", evaluate)
        self.assertEqual(server,
                         f"server --models {out}/models --load-all "
                         "--listen 127.0.0.1:0 --admin-listen  --http-listen ")
        self.assertIn("--server 127.0.0.1:4711 --scene room", client)
        self.assertIn("--seed 7 --json", client)
        self.assertEqual(stop, "server stopped")
        self.assertIn("bit for bit", done.stdout)
        self.assertIn(f"Pictures: {out}/report.html", done.stdout)

    def test_names_the_data_where_no_report_page_can_be_made(self):
        self.assertEqual(self.demo().returncode, 0)
        self.write_program(self.root / "scripts/build-report",
                           "#!/bin/sh\necho no node >&2\nexit 77\n")
        # Not the page of the run before.
        done = self.demo(NO_TEMPLATE="1")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("no node", done.stderr)
        self.assertIn(f"data: {self.root}/out/demo/report.data.json",
                      done.stdout)
        self.assertNotIn("report.html", done.stdout)

    def test_an_address_of_the_run_before_is_not_asked(self):
        log = self.root / "out/demo/server.log"
        log.parent.mkdir(parents=True)
        log.write_text("listening on 127.0.0.1:1\n")
        self.assertEqual(self.demo().returncode, 0)
        self.assertIn("--server 127.0.0.1:4711 ", "\n".join(self.calls_made()))

    def test_runs_twice_and_from_any_folder(self):
        self.assertEqual(self.demo(cwd="/").returncode, 0)
        done = self.demo(cwd="/")
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_real_frames_with_the_poses_beside_them(self):
        folder = self.recording("train.txt", "test.txt", "poses-sfm.txt")
        done = self.demo("--data", f"7scenes:{folder}")
        self.assertEqual(done.returncode, 0, done.stderr)
        calls = "\n".join(self.calls_made())
        self.assertNotIn("synth", calls)
        self.assertEqual(calls.count(f"--poses {folder}/poses-sfm.txt"), 2)
        self.assertIn("/models/real-scene/1/model.treeline", calls)
        self.assertIn("--scene real-scene", calls)

    def test_own_poses_of_the_recording(self):
        folder = self.recording("train.txt", "test.txt", "poses-sfm.txt")
        done = self.demo("--data", f"7scenes:{folder}", "--poses", "own")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("--poses", "\n".join(self.calls_made()))

    def test_relative_paths_count_from_where_the_user_stands(self):
        folder = self.recording("train.txt", "test.txt")
        done = self.demo("--data", f"7scenes:{folder.name}",
                         cwd=folder.parent)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"--root {folder}", "\n".join(self.calls_made()))

    def assert_fails_with(self, done, words):
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertIn(words, done.stderr)

    def test_says_which_list_is_missing(self):
        folder = self.recording("train.txt")
        self.assert_fails_with(self.demo("--data", f"7scenes:{folder}"),
                               f"{folder} has no test.txt")

    def test_says_that_a_folder_is_missing(self):
        self.assert_fails_with(self.demo("--data", "7scenes:nowhere"),
                               "there is no nowhere")

    def test_refuses_another_format_and_what_is_no_number(self):
        self.assert_fails_with(self.demo("--data", "tum:x"),
                               "--data takes 7scenes:DIR; got tum:x")
        self.assert_fails_with(self.demo("--frames", "many"),
                               "--frames many is not a number")
        self.assert_fails_with(self.demo("--frames"), "--frames needs a value")

    def test_stops_where_training_fails(self):
        done = self.demo(TRAIN_STATUS="3")
        self.assertEqual(done.returncode, 3)
        self.assertIn("learn it: FAILED (status 3)", done.stderr)
        self.assertNotIn("server", "\n".join(self.calls_made()[1:]))

    def test_shows_why_the_server_did_not_start(self):
        done = self.demo(REFUSAL="address already in use")
        self.assert_fails_with(done, "address already in use")
        self.assertIn("the server did not start", done.stderr)

    def test_a_server_that_ends_badly_is_a_failure(self):
        self.assert_fails_with(self.demo(SERVER_STATUS="9"),
                               "the server ended with status 9")

    def test_a_difference_is_a_failure(self):
        served = {**SERVED, "world_from_camera": {**POSE, "tz": 0.26}}
        self.assert_fails_with(self.demo(SERVED=json.dumps(served)),
                               "the poses differ")

    def test_an_interrupt_leaves_no_server_behind(self):
        process = subprocess.Popen(
            [str(self.root / "scripts/demo")], start_new_session=True,
            env=self.environment(**self.variables, CLIENT_SECONDS="30"),
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        deadline = time.monotonic() + 30
        while not (self.calls.exists()
                   and "\nclient " in self.calls.read_text()):
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.01)
        # As a terminal does it: to everything in the foreground.
        os.killpg(process.pid, signal.SIGINT)
        self.assertEqual(process.wait(timeout=30), 130)
        self.assertIn("server stopped", self.calls_made())


if __name__ == "__main__":
    unittest.main()
