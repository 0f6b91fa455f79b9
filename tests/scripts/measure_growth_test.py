"""scripts/measure-growth runs each step once, and tells its figures."""

import json
import pathlib
import subprocess
import tempfile
import time
import unittest
import xml.etree.ElementTree

from stub_programs import REPOSITORY

# What Treeline writes, as far as the script reads it; a line of each call.
PROGRAM = r"""#!/usr/bin/env python3
import json, pathlib, signal, sys, time
words = sys.argv[1:]
here = pathlib.Path(__file__).parent
with open(here / "calls", "a") as calls:
    calls.write(" ".join(words) + "\n")
def value(flag):
    return words[words.index(flag) + 1]
if (here / "waits").exists():
    def stop(*_):
        (here / "stopped").touch()
        sys.exit(130)
    signal.signal(signal.SIGTERM, stop)
    (here / "waiting").touch()
    while True:
        time.sleep(0.05)
if words[0] == "train" and (here / "fails").exists():
    sys.exit("no memory")
if words[0] == "train":
    pathlib.Path(value("--output")).write_bytes(b"x" * 2000000)
if words[:2] == ["synth", "record"]:
    pathlib.Path(value("--output")).mkdir()
row = {"frames": 10, "right": 9, "wrong": 1, "gross": 0,
       "cpu_ms": {"p50": 2.5}}
if words[0] == "evaluate":
    pathlib.Path(value("--json")).write_text(json.dumps({
        "answers": row,
        "perturbations": [dict(row, name="as it is"),
                          dict(row, name="no-depth", right=8)],
        "foreign": [{"accepted": 0}]}))
if words[0] == "recognize":
    scene = {"frames": 5, "ranked_first": 5, "right_localized": 4,
             "wrong_localized": 0}
    pathlib.Path(value("--json")).write_text(json.dumps({
        "queries": [dict(scene, scene="a"), dict(scene, scene="b"),
                    dict(scene, scene=None)],
        "words_ms": {"p50": 1}, "rank_ms": {"p50": 0.2},
        "read_descriptors_ms": 4}))
"""


class MeasureGrowthTest(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.program = self.folder / "treeline"
        self.program.write_text(PROGRAM)
        self.program.chmod(0o755)

    def measure(self, *arguments):
        return subprocess.run(
            [REPOSITORY / "scripts" / "measure-growth", "--program",
             self.program, "--out", self.folder / "out", *arguments],
            capture_output=True, text=True, check=False)

    def calls(self):
        return (self.folder / "calls").read_text().splitlines()

    def test_figures_and_curves_of_buildings_and_rooms(self):
        arguments = ("--areas", "200,100", "--rooms", "1,2", "--density", "6")
        done = self.measure(*arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("| 200 m2 | 1200 |", done.stdout)
        self.assertIn("| 2.0 MB | 90.0%, 1, 2.5 ms | 80.0%, 1, 2.5 ms | 0 |",
                      done.stdout)
        self.assertIn("| 2 | 10 | 100.0% | 80.0% | 0 | 0 |", done.stdout)
        growth = json.loads((self.folder / "out/growth.json").read_text())
        self.assertEqual([row["area_m2"] for row in growth["buildings"]],
                         [100, 200])
        curves = xml.etree.ElementTree.parse(self.folder / "out/growth.svg")
        lines = curves.findall(".//{http://www.w3.org/2000/svg}polyline")
        self.assertEqual(len(lines), 10)
        record = next(call for call in self.calls() if "office:200:1" in call)
        self.assertIn("--frames 1200 --rate 9.0000", record)
        # Nothing is made twice.
        count = len(self.calls())
        self.assertEqual(self.measure(*arguments).returncode, 0)
        self.assertEqual(len(self.calls()), count)

    def test_a_step_that_fails_is_shown_and_made_again(self):
        (self.folder / "fails").touch()
        failed = self.measure("--areas", "100", "--rooms", "0")
        self.assertEqual(failed.returncode, 1)
        self.assertIn("no memory", failed.stderr)
        (self.folder / "fails").unlink()
        done = self.measure("--areas", "100", "--rooms", "0")
        self.assertEqual(done.returncode, 0, done.stderr)
        records = [call for call in self.calls() if "record" in call]
        self.assertEqual(len(records), 2)

    def test_stopped_it_stops_what_runs(self):
        (self.folder / "waits").touch()
        running = subprocess.Popen(
            [REPOSITORY / "scripts" / "measure-growth", "--program",
             self.program, "--out", self.folder / "out", "--areas", "100",
             "--rooms", "0"], stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE, text=True)
        while not (self.folder / "stopped").exists():
            if (self.folder / "waiting").exists():
                running.terminate()
            time.sleep(0.05)
        _, words = running.communicate(timeout=60)
        self.assertEqual(running.returncode, 130)
        self.assertIn("stopped", words)

    def test_wrong_usage(self):
        self.assertEqual(self.measure("--areas", "100,-3").returncode, 2)
        self.program.unlink()
        self.assertEqual(self.measure().returncode, 2)


if __name__ == "__main__":
    unittest.main()
