"""docs/tutorials/robot-in-a-cafe.md, followed word by word.

    robot_tutorial_test.py PROGRAMS
"""

import pathlib
import sys
import tempfile
import unittest

from following import follow, steps_of

PROGRAMS = pathlib.Path(sys.argv[1]).resolve()
STATE = "http://127.0.0.1:8081/api/state"


class Tutorial(unittest.TestCase):

    def test_the_robot_does_what_it_says(self):
        steps = steps_of("tutorials/robot-in-a-cafe.md")
        self.assertEqual(len(steps), 8)
        # A reader is slower than a shell: the robot is ready by the next step.
        steps[3] += f"""
            until curl -s {STATE} | grep -q '"pose":{{'
            do kill -0 %1 && kill -0 %2 && sleep 0.2; done
            """
        with tempfile.TemporaryDirectory() as name:
            status, transcript = follow("\n".join(steps), name, PROGRAMS,
                                        seconds=1400)
            folder = pathlib.Path(name)
            log = folder / "agent.log"
            words = log.read_text() if log.is_file() else ""
            self.assertEqual(status, 0, transcript + words)
            for picture in ("drive.png", "map/map.png"):
                self.assertTrue((folder / picture).is_file(), picture)
            self.assertTrue((folder / "state" / "routes").exists())
        # To the terrace, and after the kidnap to the foot of the ramp.
        self.assertEqual(transcript.count("\nthere: "), 2, transcript)
        self.assertRegex(transcript, r"event=lost ")
        self.assertRegex(transcript, r"event=resume text=.found after [1-9]")
        self.assertRegex(transcript, r"(?m)^over: ")
        self.assertNotIn("missed waypoint", transcript)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
