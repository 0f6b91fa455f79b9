"""A robot in another process, known over DDS alone: it is mapped, told its
place, sent to goals, carried away, found; its sensors fall silent, its clock
jumps, somebody sends nonsense."""

import argparse
import math
import os
import queue
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

PROGRAMS = None
# On a busy machine, that is much; nothing waits for it to pass.
LONGEST_S = 120

# A room with a screen, a niche and furniture: nowhere alike.
WORLD = """
size: [6, 5, 2.6]
seed: 3
rooms:
  - {name: hall, area: [0, 0, 6, 5], floor: planks, lamps: [2, 2]}
walls:
  - {name: screen, from: [3.6, 2.5], to: [5.95, 2.5], height: 2.6}
  - {name: niche, from: [1.9, 4.0], to: [1.9, 4.95], height: 2.6}
furniture:
  - {kind: wardrobe, at: [0.35, 2.2], facing: east}
  - {kind: sideboard, at: [2.6, 0.28], facing: north, width: 1.2}
  - {kind: crate, at: [5.5, 4.6], facing: north, width: 0.6}
places:
  - {name: start, at: [1.2, 1.2], facing: east}
tour:
  - [1.2, 1.2]
  - [4.6, 1.3]
  - [2.7, 1.9]
  - [2.8, 3.4]
  - [4.4, 3.6]
  - [2.4, 3.3]
  - [1.2, 3.3]
  - [1.3, 1.6]
"""

ROBOT = """
domain_id: {domain}
interface: lo
use_sim_time: true
{more}
"""


class Program:
    """A process whose lines, of both streams, are waited for."""

    def __init__(self, *arguments):
        self.process = subprocess.Popen(
            arguments, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, text=True)
        self.lines = queue.Queue()
        self.said = []
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()

    def read(self):
        for line in self.process.stdout:
            self.lines.put(line)

    def next_line(self):
        line = self.lines.get(timeout=0.1)
        self.said.append(line)
        return line

    def wait_for(self, pattern):
        until = time.monotonic() + LONGEST_S
        while time.monotonic() < until:
            try:
                line = self.next_line()
            except queue.Empty:
                if self.process.poll() is not None:
                    break
                continue
            found = re.search(pattern, line)
            if found:
                return found
        raise AssertionError(f"no {pattern} in\n{''.join(self.said[-60:])}")

    def wait_for_all(self, *patterns):
        """In any order."""
        left = list(patterns)
        while left:
            line = self.wait_for("|".join(left)).string
            left = [each for each in left if not re.search(each, line)]

    def end(self, how=signal.SIGTERM):
        if self.process.poll() is None:
            self.process.send_signal(how)
        code = self.process.wait(LONGEST_S)
        self.reader.join()
        while not self.lines.empty():
            self.said.append(self.lines.get())
        for stream in (self.process.stdin, self.process.stdout):
            stream.close()
        return code


    def order(self, *words):
        self.process.stdin.write(" ".join(map(str, words)) + "\n")
        self.process.stdin.flush()


class Robot(Program):
    """treeline-emulator ros2: orders go in, and its newest status is waited for."""

    def status(self):
        """The newest there is, or else the next one."""
        line = None
        until = time.monotonic() + LONGEST_S
        while line is None or not self.lines.empty():
            if time.monotonic() > until:
                raise AssertionError("the robot is silent")
            try:
                new = self.next_line()
            except queue.Empty:
                continue
            line = new if new.startswith("t=") else line
        values = dict(re.findall(r"(?:^|\s)(\w+)=(\S+)", line.split(" [")[0]))
        values.update(re.findall(r"\[treeline: ([^=\]]+)=([^\]]*)\]", line))
        return values

    def wait_until(self, what, holds):
        until = time.monotonic() + LONGEST_S
        while time.monotonic() < until:
            status = self.status()
            if holds(status):
                return status
        raise AssertionError(f"never: {what}; last {status}")


def numbers(text):
    return [float(number) for number in text.split(",")]


def stands(status):
    return float(status["speed"]) < 0.01


def drives(status):
    return float(status["speed"]) > 0.2


class RobotProgramTest(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        # As the tests in C++ choose theirs: testing_domain.h.
        self.domain = str(1 + os.getpid() % 100)

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)
        return self.path(name)

    def start(self, kind, *arguments):
        program = kind(*arguments)
        self.addCleanup(program.end, signal.SIGKILL)
        return program

    def start_robot(self, camera_hz, *form):
        return self.start(Robot, PROGRAMS.robot, "ros2",
                          "--domain-id", self.domain, "--interface", "lo",
                          "--world", self.write("world.yaml", WORLD),
                          "--pace", PROGRAMS.pace, "--seed", "5",
                          "--camera-hz", str(camera_hz), *form)

    def map(self, robot, config):
        mapper = self.start(Program, PROGRAMS.agent, "map", "--live", "--ros2",
                            config, "--output", self.path("map"))
        mapper.wait_for(r"[1-9]\d* scans")
        robot.order("tour")
        robot.wait_until("the tour begins", lambda s: s["tour"] == "1")
        robot.wait_until("the tour ends", lambda s: s["tour"] == "0")
        self.assertEqual(mapper.end(signal.SIGINT), 0,
                         "".join(mapper.said[-20:]))

    def drive(self, config, *more, on="map"):
        agent = self.start(Program, PROGRAMS.agent, "run", "--ros2", config,
                           "--map", self.path(on), "--listen", "",
                           "--http-listen", "", *more)
        agent.wait_for("driving")
        return agent

    def goes_to(self, robot, x, y):
        robot.order("goal", x, y, 0)
        robot.wait_until("it drives", drives)
        return self.arrives(robot, x, y)

    def arrives(self, robot, x, y):
        status = robot.wait_until(
            "the goal is reached",
            lambda s: s.get("goal", "").startswith("succeeded") and stands(s))
        at = numbers(status["true"])
        # Its own tolerance is 0.1 m, and the map is good to some centimetres.
        self.assertLess(abs(at[0] - x) + abs(at[1] - y), 0.3, status)
        return status

    def is_placed(self, robot):
        status = robot.wait_until(
            "it knows where it is",
            lambda s: s.get("localization") == "localized" and stands(s) and
            numbers(s.get("place_off", "9,9"))[0] < 0.15)
        self.assertLess(numbers(status["tf_off"])[0], 0.15, status)
        self.assertGreater(int(status["map"]), 1000)

    def is_carried_away_and_found(self, robot):
        robot.order("kidnap", 1.2, 3.2, -1.5)
        robot.wait_until("it is elsewhere", lambda s: numbers(
            s["place_off"])[0] > 0.5)
        robot.order("goal", 4.6, 1.2, 0)
        robot.wait_until(
            "it looks for its place",
            lambda s: s.get("navigation", "").startswith(
                ("lost", "relocalizing")))
        self.arrives(robot, 4.6, 1.2)
        self.is_placed(robot)

    def is_sent_by_action(self, robot, rmw):
        """As Nav2's clients send it. The map begins where the tour did."""
        client = self.start(Program, PROGRAMS.client, self.domain, rmw)
        there, back = (3.4, 0.0), (0.0, 0.2)
        # What is no goal for it, and one that it cannot reach.
        client.order("goal", 1, "odom", *there, 0)
        client.wait_for("rejected 1")
        client.order("goal", 2, "map", "nan", 0, 0)
        client.wait_for("rejected 2")
        client.order("goal", 3, "map", *there, 0, "/opt/tree.xml")
        client.wait_for("rejected 3")
        client.order("goal", 4, "map", 60, 60, 0)
        client.wait_for("accepted 4")
        client.wait_for("result 4 6 204 ")
        # The next goal takes the place of the one before it; it is cancelled.
        client.order("goal", 5, "map", *there, 0)
        client.wait_for(r"status .*5:2|accepted 5")
        to_go = client.wait_for(r"feedback 5 ([1-9]\S*) (\S+) 0 \S+ \S+")
        self.assertLess(float(to_go[1]), 6)
        robot.wait_until("it drives", drives)
        client.order("goal", 6, "map", *there, 0)
        client.wait_for("result 5 6 0 another goal")
        client.order("cancel", 6)
        client.wait_for_all("canceling 0 1", "result 6 5 0")
        robot.wait_until("it stands", stands)
        client.order("cancel", 6)
        client.wait_for("canceling 3 0")
        client.order("cancel", 77)
        client.wait_for("canceling 2 0")
        # A client that dies leaves its goal; who comes next is told of it.
        client.order("goal", 7, "map", *there, 0)
        client.wait_for("feedback 7 ")
        client.end(signal.SIGKILL)
        robot.wait_until("it drives", drives)
        self.arrives(robot, 4.6, 1.2)
        client = self.start(Program, PROGRAMS.client, self.domain, rmw)
        client.wait_for(r"status .*5:6 6:5 7:4")
        client.order("goal", 8, "map", *back, 0)
        client.wait_for("result 8 4 0")
        self.arrives(robot, 1.2, 1.4)

    def test_it_is_mapped_driven_carried_away_and_found(self):
        robot = self.start_robot(0, "--plain")
        config = self.write("robot.yaml",
                            ROBOT.format(domain=self.domain, more=""))
        self.map(robot, config)
        agent = self.drive(config)
        robot.order("place", *numbers(robot.status()["true"]))
        self.is_placed(robot)
        self.is_sent_by_action(robot, "fastrtps")
        self.is_carried_away_and_found(robot)
        # Whoever is told nothing may be driven by somebody else.
        before = robot.wait_until("all is told", stands)
        after = robot.wait_until(
            "time passes",
            lambda s: float(s["t"]) > float(before["t"]) + 3)
        again = robot.wait_until(
            "time passes", lambda s: float(s["t"]) > float(after["t"]) + 1)
        self.assertEqual(after["commands"], again["commands"])
        # Ctrl-C in the middle of a drive.
        client = self.start(Program, PROGRAMS.client, self.domain, "fastrtps")
        client.order("goal", 9, "map", 0, 0, 0)
        robot.wait_until("it drives", drives)
        self.assertEqual(agent.end(signal.SIGINT), 0, "".join(agent.said))
        client.wait_for("result 9 6 ")
        last = robot.wait_until("it stands", stands)
        self.assertEqual(numbers(last["cmd"]), [0, 0])

    def write_flat_map(self, x, y, yaw):
        """The map as map_saver writes one, whose frame lies there in it."""
        with open(self.path("map/levels/level-0.yaml"), encoding="utf-8") as file:
            settings = file.read()
        numbers_of = lambda key: re.search(rf"{key}: (.*)", settings).group(1)
        at = [float(n) for n in numbers_of("origin").strip("[]").split(",")]
        at = self.moved(x, y, yaw, at[0], at[1])
        os.rename(self.path("map/levels/level-0.pgm"), self.path("hall.pgm"))
        shutil.rmtree(self.path("map"))
        return self.write("hall.yaml", f"""
image: hall.pgm
mode: trinary
resolution: {numbers_of("resolution")}
origin: [{at[0]}, {at[1]}, {yaw}]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
""")

    @staticmethod
    def moved(x, y, yaw, at_x, at_y):
        return (x + math.cos(yaw) * at_x - math.sin(yaw) * at_y,
                y + math.sin(yaw) * at_x + math.cos(yaw) * at_y)

    def test_it_drives_on_a_map_of_map_server(self):
        robot = self.start_robot(0, "--plain")
        config = self.write("robot.yaml",
                            ROBOT.format(domain=self.domain, more=""))
        self.map(robot, config)
        # Neither a multiple of the resolution nor straight.
        frame = (3.137, -7.412, 0.6)
        self.write_flat_map(*frame)
        agent = self.drive(config, "--find-yourself", on="hall.yaml")
        client = self.start(Program, PROGRAMS.client, self.domain, "fastrtps")
        # (4.6, 1.2) in the world; the first map began at (1.2, 1.2).
        client.order("goal", 1, "map", *self.moved(*frame, 3.4, 0), 0)
        client.wait_for("result 1 4 0")
        self.arrives(robot, 4.6, 1.2)
        robot.order("kidnap", 1.2, 3.2, -1.5)
        client.order("goal", 2, "map", *self.moved(*frame, 3.4, 0.1), 0)
        client.wait_for("result 2 4 0")
        self.arrives(robot, 4.6, 1.3)
        self.assertEqual(agent.end(signal.SIGINT), 0, "".join(agent.said))
        self.assertRegex("".join(agent.said),
                         "(?s)event=resume.*event=lost.*event=resume")

    def test_it_stands_when_it_does_not_hear_and_goes_on(self):
        robot = self.start_robot(0, "--plain")
        config = self.write(
            "robot.yaml", ROBOT.format(domain=self.domain,
                                       more="rmw: rmw_cyclonedds_cpp"))
        self.map(robot, config)
        agent = self.drive(config)
        robot.order("place", *numbers(robot.status()["true"]))
        self.is_placed(robot)
        self.is_sent_by_action(robot, "cyclonedds")
        place = (4.6, 1.2)
        for trouble, cause in ((("silence", "scan", 3), "laser_lost"),
                               (("silence", "odom", 3), "odometry_lost"),
                               (("silence", "clock", 8), "base_lost")):
            with self.subTest(trouble=trouble):
                robot.order("goal", *place, 0)
                robot.wait_until("it drives", drives)
                robot.order(*trouble)
                robot.wait_until(
                    f"it stands for {cause}",
                    lambda s, cause=cause: stands(s) and
                    s.get("navigation/cause") == cause)
                self.arrives(robot, *place)
                place = (1.2, 1.4) if place[0] > 2 else (4.6, 1.2)
        with self.subTest("a clock that is set, and nonsense"):
            robot.order("goal", *place, 0)
            # /clock's silence was a leap, too.
            before = robot.wait_until("it drives", drives)
            robot.order("nonsense")
            robot.order("jump", -100)
            robot.order("nonsense")
            status = self.arrives(robot, *place)
            self.assertEqual(int(status["topics/clock jumps"]),
                             int(before["topics/clock jumps"]) + 1)
            self.assertGreater(int(status["topics/refused"]),
                               int(before["topics/refused"]) + 4)
        self.assertEqual(agent.end(), 0, "".join(agent.said))
        self.assertIn("that is no laser", "".join(agent.said))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    for name in ("agent", "client", "robot", "pace"):
        parser.add_argument("--" + name, required=True)
    PROGRAMS, rest = parser.parse_known_args()
    unittest.main(argv=sys.argv[:1] + rest)
