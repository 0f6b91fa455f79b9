"""scripts/lib/same_answers.py tells rounding from other answers."""

import contextlib
import copy
import io
import math
import sys
import unittest

from stub_programs import REPOSITORY

sys.path.insert(0, str(REPOSITORY / "scripts" / "lib"))
import same_answers  # noqa: E402


def pose(angle_deg=0.0, position=(0, 0, 0)):
    half = math.radians(angle_deg) / 2
    return {"qw": math.cos(half), "qx": 0, "qy": 0, "qz": math.sin(half),
            "tx": position[0], "ty": position[1], "tz": position[2]}


def answers(count=100):
    return {f"frame-{i}": {"outcome": "LOCALIZED",
                           "world_from_camera": pose(i, (0.1 * i, 0, 1))}
            for i in range(count)}


class SameAnswersTest(unittest.TestCase):

    def report(self, expected, other):
        output = io.StringIO()
        with contextlib.redirect_stdout(output):
            same = same_answers.report(expected, other)
        return same, output.getvalue()

    def test_rounding_is_the_same(self):
        other = answers()
        for i in range(100):
            other[f"frame-{i}"]["world_from_camera"] = pose(
                i + 1e-4, (0.1 * i + 1e-6, 0, 1))
        same, words = self.report(answers(), other)
        self.assertTrue(same)
        self.assertIn("100 frames, 100 localized by both", words)
        self.assertIn("median 0.001000 mm and 0.0001000 degrees", words)
        self.assertIn("0 the same bit for bit", words)

    def test_a_few_may_differ_and_are_named(self):
        other = answers()
        other["frame-7"]["world_from_camera"] = pose(7, (0.71, 0, 1))
        other["frame-8"] = {"outcome": "NOT_LOCALIZED",
                            "world_from_camera": None}
        same, words = self.report(answers(), other)
        self.assertTrue(same)
        self.assertIn("frame-7: the poses are 10.000 mm and 0.0000 degrees",
                      words)
        self.assertIn("frame-8: LOCALIZED here, NOT_LOCALIZED there", words)

    def test_more_may_not(self):
        other = copy.deepcopy(answers())
        for i in range(3):
            other[f"frame-{i}"]["world_from_camera"] = pose(i + 1,
                                                            (0.1 * i, 0, 1))
        self.assertFalse(self.report(answers(), other)[0])

    def test_missing_and_added_frames_are_not_the_same(self):
        fewer = answers(97)
        self.assertFalse(self.report(answers(), fewer)[0])
        self.assertFalse(self.report(fewer, answers())[0])

    def test_nothing_localized_shows_nothing(self):
        nothing = {"frame-0": {"outcome": "NOT_LOCALIZED",
                               "world_from_camera": None}}
        self.assertFalse(self.report(nothing, nothing)[0])


if __name__ == "__main__":
    unittest.main()
