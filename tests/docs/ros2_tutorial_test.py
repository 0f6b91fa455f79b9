"""docs/tutorials/first-hour-with-a-ros2-robot.md, followed word by word.

    ros2_tutorial_test.py PROGRAMS
"""

import os
import pathlib
import re
import sys
import tempfile
import unittest

from following import follow, steps_of

PROGRAMS = pathlib.Path(sys.argv[1]).resolve()
# In a domain of its own: tests in C++ and those of tests/bridge have 1 to 100.
DOMAIN = str(101 + os.getpid() % 99)


class Tutorial(unittest.TestCase):

    def test_the_robot_does_what_it_says(self):
        steps = steps_of("tutorials/first-hour-with-a-ros2-robot.md")
        self.assertEqual(len(steps), 6)
        with tempfile.TemporaryDirectory() as name:
            commands = "\n".join(steps)
            self.assertEqual(commands.count("42"), 2)
            status, transcript = follow(commands.replace("42", DOMAIN), name,
                                        PROGRAMS)
            folder = pathlib.Path(name)
            logs = {log: (folder / log).read_text()
                    for log in ("map.log", "agent.log", "robot.log")
                    if (folder / log).is_file()}
            told = transcript + "".join(
                f"\n---- {log}\n{text[-4000:]}" for log, text in logs.items())
            self.assertEqual(status, 0, told)
            self.assertTrue((folder / "flat" / "map.png").is_file())
            self.assertTrue((folder / "drive.mcap").read_bytes()
                            .startswith(b"\x89MCAP"))
        for line in ("robot  .* is heard in domain " + DOMAIN,
                     "laser: scan: ranges .* of 541 beams",
                     r"odometry: odom .*\d Hz; 0 refused",
                     "velocities: cmd_vel .*somebody listens"):
            self.assertRegex(transcript, "(?m)^ok +" + line)
        self.assertEqual(len(re.findall("^there: ", transcript, re.M)), 2, told)
        self.assertRegex(transcript, "event=lost ")
        self.assertEqual(len(re.findall("event=resume text=.found after",
                                        transcript)), 2, told)
        # By the robot's own knowledge, after all.
        off = re.search(r"place_off=([\d.]+),([\d.]+)", transcript)
        self.assertLess(float(off[1]), 0.15, told)
        self.assertLess(float(off[2]), 0.1, told)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
