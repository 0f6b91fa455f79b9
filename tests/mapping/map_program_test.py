"""treeline-agent map as a program: a killed drive, an interrupted one, errors."""

import argparse
import math
import os
import re
import signal
import subprocess
import sys
import tempfile
import unittest

AGENT = None
# Scans in a second of the simulated laser.
LASER_HZ = 40


def run(*arguments):
    return subprocess.run([AGENT, *arguments], capture_output=True, text=True,
                          timeout=120)


def carmen_log(scans):
    """A laser log of a drive to and fro in a room of 8 x 6 m with a niche."""
    walls = [((-4, -3), (4, -3)), ((4, -3), (4, 1)), ((4, 1), (5, 1)),
             ((5, 1), (5, 3)), ((5, 3), (-4, 3)), ((-4, 3), (-4, -3))]

    def range_m(x, y, angle):
        nearest = 80
        dx, dy = math.cos(angle), math.sin(angle)
        for (ax, ay), (bx, by) in walls:
            wx, wy = bx - ax, by - ay
            det = dx * wy - dy * wx
            if abs(det) < 1e-9:
                continue
            along = ((ax - x) * wy - (ay - y) * wx) / det
            part = ((ax - x) * dy - (ay - y) * dx) / det
            if along > 0 and 0 <= part <= 1:
                nearest = min(nearest, along)
        return nearest

    lines = []
    for i in range(scans):
        x = -2 + 0.1 * i if i < 20 else 0.1 * (scans - i) - 2
        ranges = " ".join(f"{range_m(x, 0, math.radians(k - 90)):.3f}"
                          for k in range(181))
        lines.append(f"FLASER 181 {ranges} {x:.3f} 0 0 {x:.3f} 0 0 "
                     f"{i}.0 robot {i}.0\n")
    return "".join(lines)


class LiveDrive:
    """A simulated drive that is being mapped, at the pace of real time."""

    def __init__(self, bundle):
        self.process = subprocess.Popen(
            [AGENT, "map", "--live", "--simulate", "cafe", "--output", bundle],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.scans = 0

    def wait_for_scans(self, count):
        for line in self.process.stderr:
            told = re.match(r"(\d+) scans", line)
            if told:
                self.scans = int(told.group(1))
            if self.scans >= count:
                return
        raise AssertionError("the drive ended early")

    def stop(self, how):
        self.process.send_signal(how)
        out, err = self.process.communicate(timeout=120)
        return self.process.returncode, out + err


class MapProgramTest(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def poses(self, bundle):
        with open(self.path(bundle + "/trajectory.txt"),
                  encoding="utf-8") as lines:
            return sum(1 for line in lines if not line.startswith("#"))

    def test_a_killed_drive_loses_a_second_at_most(self):
        drive = LiveDrive(self.path("killed"))
        drive.wait_for_scans(3 * LASER_HZ)
        killed_after = drive.scans
        drive.stop(signal.SIGKILL)
        self.assertFalse(os.path.exists(self.path("killed/bundle.yaml")))
        mapped = run("map", "--log", self.path("killed/drive.tlog"),
                     "--output", self.path("mapped"), "--quiet")
        self.assertEqual(mapped.returncode, 0, mapped.stderr)
        # A second, and the scans at both ends that have no wheel readings.
        self.assertGreaterEqual(self.poses("mapped"),
                                killed_after - LASER_HZ - 5)

    def test_ctrl_c_ends_the_drive_and_makes_the_map(self):
        drive = LiveDrive(self.path("cafe"))
        drive.wait_for_scans(8 * LASER_HZ)
        code, said = drive.stop(signal.SIGINT)
        self.assertEqual(code, 0, said)
        for part in ("bundle.yaml", "octomap.bt", "levels/level-0.yaml",
                     "drive.tlog", "live.png", "map.png"):
            self.assertTrue(os.path.exists(self.path("cafe/" + part)), part)
        self.assertGreaterEqual(self.poses("cafe"), drive.scans - 5)

    def test_what_is_there_is_not_overwritten(self):
        os.makedirs(self.path("map"))
        with open(self.path("map/octomap.bt"), "w", encoding="utf-8") as file:
            file.write("somebody's")
        refused = run("map", "--live", "--simulate", "cafe", "--output",
                      self.path("map"))
        self.assertEqual(refused.returncode, 1)
        self.assertIn("--overwrite", refused.stderr)

    def test_errors_say_what_is_missing(self):
        for arguments, word in (
                (["--output", "x"], "--log"),
                (["--output", "x", "--live"], "--simulate"),
                (["--output", "x", "--log", self.path("none")], "none"),
                (["--output", self.path("y"), "--live", "--simulate", "cafee"],
                 "cafe"),
                (["--output", self.path("z"), "--rgbd", "tum:nowhere"],
                 "nowhere")):
            refused = run("map", *arguments)
            self.assertNotEqual(refused.returncode, 0, arguments)
            self.assertIn(word, refused.stderr, arguments)

    def test_odometry_is_trusted_as_told(self):
        with open(self.path("room.log"), "w", encoding="utf-8") as file:
            file.write(carmen_log(40))
        off = {}
        for noise in ("auto", "learned", "wheels", "gyroscope"):
            mapped = run("map", "--log", self.path("room.log"), "--output",
                         self.path(noise), "--quiet", "--odometry-noise",
                         noise)
            self.assertEqual(mapped.returncode, 0, mapped.stderr)
            off[noise] = re.search(
                r"off by ([0-9.]+) times \(way\) and ([0-9.]+) times",
                mapped.stdout).groups()
        # It begins with doubt, and learns from the scans; others do not.
        self.assertGreater(float(off["learned"][1]), 1)
        self.assertEqual(off["auto"], off["learned"])
        self.assertEqual(off["wheels"], ("1.0", "1.0"))
        self.assertEqual(off["gyroscope"], ("1.0", "1.0"))
        wrong = run("map", "--log", self.path("room.log"), "--output",
                    self.path("wrong"), "--odometry-noise", "none")
        self.assertEqual(wrong.returncode, 2)
        self.assertIn("gyroscope", wrong.stderr)

    def test_scores_are_of_the_reference(self):
        with open(self.path("a.txt"), "w", encoding="utf-8") as file:
            for i in range(20):
                file.write(f"{i} {i} {i % 3} 0 0 0 0 1\n")
        with open(self.path("b.txt"), "w", encoding="utf-8") as file:
            for i in range(20):
                file.write(f"{i} {i + 5} {i % 3 - 2} 0 0 0 0 1\n")
        same = run("score-trajectory", "--estimate", self.path("a.txt"),
                   "--reference", self.path("b.txt"), "--max-gap", "2")
        self.assertEqual(same.returncode, 0, same.stderr)
        self.assertRegex(same.stdout, r"absolute +rmse +0\.0000")
        neither = run("score-trajectory", "--estimate", self.path("a.txt"))
        self.assertEqual(neither.returncode, 1)
        self.assertIn("--reference", neither.stderr)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--agent", required=True)
    options, rest = parser.parse_known_args()
    AGENT = options.agent
    unittest.main(argv=sys.argv[:1] + rest)
