"""scripts/demo robot maps, learns, drives, kidnaps, and tells how it went."""

import json
import re
import unittest

from stub_programs import ScriptTest

TREELINE = r"""#!/usr/bin/env python3
import os, sys
with open(os.environ["CALLS"], "a") as calls:
    calls.write(" ".join(["treeline", *sys.argv[1:]]) + "\n")
"""

SERVER = r"""#!/usr/bin/env python3
import os, signal, sys
def stop(*_):
    with open(os.environ["CALLS"], "a") as calls:
        calls.write("server stopped\n")
    os._exit(0)
signal.signal(signal.SIGTERM, stop)
print("listening on 127.0.0.1:4711", flush=True)
while True:
    signal.pause()
"""

# A robot that needs half a second for each part of the story.
AGENT = r"""#!/usr/bin/env python3
import http.server, json, os, pathlib, signal, sys, time
arguments = dict(zip(sys.argv[1:], sys.argv[2:]))
with open(os.environ["CALLS"], "a") as calls:
    calls.write(" ".join(["agent", *sys.argv[1:]]) + "\n")
if sys.argv[1] == "map":
    folder = pathlib.Path(arguments["--output"])
    folder.mkdir()
    (folder / "trajectory.txt").write_text(
        "# time x y z qx qy qz qw\n0 0 0 0 0 0 0 1\n1 2 1 0.5 0 0 0 1\n")
    (folder / "levels").mkdir()
    for level in (0, 1):
        stem = folder / f"levels/level-{level}"
        stem.with_suffix(".yaml").write_text(
            "resolution: 0.05\norigin: [0, 0, 0]\n")
        stem.with_suffix(".pgm").write_bytes(
            b"P5\n10 10\n255\n" + bytes([254]) * 100)
if sys.argv[1] != "run":
    sys.exit(0)
BAD_RESUMPTION = "WRONG" in os.environ
NEVER = "NEVER" in os.environ
kidnapped = goal_at = None
def state():
    mode, goal, away = "idle", None, 0.0
    now = time.monotonic()
    if goal_at is not None:
        mode, goal = "driving", {"state": "active"}
    if kidnapped is not None:
        after = now - kidnapped
        mode = "relocalizing" if after < 0.5 else "driving"
        away = 3.0 if after < 0.5 or BAD_RESUMPTION else 0.02
        if after > 1:
            goal = {"state": "failed" if NEVER else "succeeded",
                    "why": "a crate stands there"}
    return {"mode": mode, "cause": "none", "goal": goal,
            "pose": {"x": 1, "y": 0, "yaw": 0},
            "truth": {"x": 1 + away, "y": 0, "yaw": 0},
            "missed_deadlines": 0}
class Handler(http.server.BaseHTTPRequestHandler):
    def log_message(self, *_): pass
    def reply(self, body):
        self.send_response(200)
        self.end_headers()
        self.wfile.write(body)
    def do_GET(self):
        if self.path == "/api/info":
            self.reply(json.dumps({"map": {"levels": [
                {"index": 0, "width": 10, "height": 10, "resolution_m": 0.05,
                 "origin": [0, 0, 0], "min_height_m": 0, "max_height_m": 0.1},
                {"index": 1, "width": 10, "height": 10, "resolution_m": 0.05,
                 "origin": [0, 0, 0], "min_height_m": 0.3,
                 "max_height_m": 0.6}]}}).encode())
        elif self.path == "/api/state":
            self.reply(json.dumps(state()).encode())
        else:
            self.reply(b"picture")
    def do_POST(self):
        global kidnapped, goal_at
        body = self.rfile.read(int(self.headers["Content-Length"])).decode()
        assert self.headers["X-Treeline"] == "1"
        with open(os.environ["CALLS"], "a") as calls:
            calls.write(f"POST {self.path} {body}\n")
        if self.path == "/api/goal": goal_at = time.monotonic()
        if self.path == "/api/sim/kidnap":
            if os.environ.pop("SOMEBODY_STANDS_THERE", None):
                self.send_response(409)
                self.end_headers()
                return
            kidnapped = time.monotonic()
        self.reply(b'{"ok": true}')
host, port = arguments["--http-listen"].split(":")
signal.signal(signal.SIGTERM, lambda *_: os._exit(0))
http.server.ThreadingHTTPServer((host, int(port)), Handler).serve_forever()
"""

PORT = 18473


class DemoRobotTest(ScriptTest):

    def setUp(self):
        super().setUp()
        self.calls = self.root / "calls"
        for name in ("install-deps", "build", "build-page"):
            self.write_program(self.root / "scripts" / name, "#!/bin/sh\n")
        for name, text in (("treeline", TREELINE), ("treeline-server", SERVER),
                           ("treeline-agent", AGENT)):
            self.write_program(self.root / "build/release/bin" / name, text)
        # build-page has fetched nothing here, so there are no pictures.
        # The kidnap comes sooner than people would like to watch.
        teller = self.root / "scripts/lib/demo_robot.py"
        text, count = re.subn(r"default=12,", "default=0.2,",
                              teller.read_text())
        self.assertEqual(count, 1)
        teller.write_text(text)

    def demo(self, *arguments, **variables):
        return self.run_script("demo", "robot", "--port", str(PORT),
                               *arguments, CALLS=str(self.calls), **variables)

    def test_maps_learns_drives_kidnaps_and_arrives(self):
        done = self.demo("--seed", "7")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        out = self.root / "out/demo-robot"
        simulate, make_map, train, run, goal, kidnap, stop = (
            self.calls.read_text().splitlines())
        self.assertIn("agent simulate --world cafe --drive survey", simulate)
        self.assertIn(f"agent map --log {out}/drive.tlog", make_map)
        self.assertIn(f"treeline train --map {out}/map", train)
        self.assertIn(f"--server 127.0.0.1:4711 --simulate cafe --seed 8", run)
        self.assertTrue(goal.startswith("POST /api/goal"), goal)
        self.assertEqual(json.loads(goal.split(" ", 2)[2])["poses"],
                         [{"x": 2, "y": 1, "yaw": 0, "level": 1}])
        # To a place of the drive.
        self.assertIn('POST /api/sim/kidnap {"x": 2.0, "y": 1.0,', kidnap)
        self.assertEqual(stop, "server stopped")
        summary = json.loads((out / "summary.json").read_text())
        self.assertTrue(summary["arrived"])
        self.assertEqual(summary["wrong_resumptions"], 0)
        self.assertGreater(summary["recovered_s"], 0.3)
        page = (out / "summary.html").read_text()
        self.assertIn("It arrived.", page)
        self.assertIn("polyline", page)

    def test_where_somebody_stands_it_is_carried_elsewhere(self):
        done = self.demo(SOMEBODY_STANDS_THERE="1")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(self.calls.read_text().count("POST /api/sim/kidnap"),
                         2)

    def test_believing_a_wrong_place_is_a_failure(self):
        done = self.demo(WRONG="1")
        self.assertEqual(done.returncode, 1)
        self.assertIn("300.0 cm", done.stdout)

    def test_a_goal_that_fails_is_a_failure_and_says_why(self):
        done = self.demo(NEVER="1")
        self.assertEqual(done.returncode, 1)
        self.assertIn("a crate stands there", done.stdout)
        self.assertIn("did not end well", done.stderr)

    def test_refuses_what_it_does_not_know(self):
        done = self.demo("--wurld", "cafe")
        self.assertEqual(done.returncode, 1)
        self.assertIn("unknown argument: --wurld", done.stderr)


if __name__ == "__main__":
    unittest.main()
