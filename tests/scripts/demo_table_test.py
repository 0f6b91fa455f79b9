"""The demonstration's table computes what it says."""

import copy
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile
import unittest

from stub_programs import REPOSITORY

SCRIPT = REPOSITORY / "scripts" / "lib" / "demo_table.py"
sys.path.insert(0, str(SCRIPT.parent))
import demo_table  # noqa: E402


def pose(axis=(0, 0, 1), angle_deg=0.0, position=(0, 0, 0)):
    half = math.radians(angle_deg) / 2
    x, y, z = (math.sin(half) * a for a in axis)
    return {"qw": math.cos(half), "qx": x, "qy": y, "qz": z,
            "tx": position[0], "ty": position[1], "tz": position[2]}


def offline_frame(stem, estimate, truth):
    return {"stem": stem, "inliers": 100, "world_from_camera": estimate,
            "outcome": "LOCALIZED" if estimate else "NOT_LOCALIZED",
            "true_world_from_camera": truth}


def served_answer(stem, estimate, round_trip_ms=8.0):
    return {"stem": stem, "inliers": 100, "world_from_camera": estimate,
            "outcome": "LOCALIZED" if estimate else "NOT_LOCALIZED",
            "round_trip_ms": round_trip_ms,
            "server": {"decode_ms": 4.0, "localize_ms": 3.0}}


MODEL = {"training": {"seconds": 12.5, "frames": 500}, "trees": 5,
         "leaves": 90000, "file_bytes": 20000000}


class MathematicsTest(unittest.TestCase):

    def test_angles_small_and_large(self):
        for angle in (1e-6, 0.3, 5, 90, 179.9):
            turned = pose((0.6, 0, 0.8), angle)
            self.assertAlmostEqual(
                demo_table.angle_between_deg(pose(), turned), angle, places=9)

    def test_opposite_quaternions_are_one_rotation(self):
        a = pose((1, 0, 0), 30)
        b = {key: -value if key[0] == "q" else value
             for key, value in a.items()}
        self.assertAlmostEqual(demo_table.angle_between_deg(a, b), 0)

    def test_percentiles_interpolate_as_numpy_does(self):
        values = [4, 1, 3, 2]
        self.assertEqual(demo_table.percentile(values, 0), 1)
        self.assertEqual(demo_table.percentile(values, 50), 2.5)
        self.assertAlmostEqual(demo_table.percentile(values, 99), 3.97)
        self.assertEqual(demo_table.percentile(values, 100), 4)
        self.assertEqual(demo_table.percentile([7], 99), 7)


class RowsTest(unittest.TestCase):

    def rows(self, frames, answers):
        offline = {"per_frame": frames, "model": MODEL}
        served = {answer["stem"]: answer for answer in answers}
        return dict(demo_table.rows_of(offline, served))

    def test_counts_what_lies_within_both_bounds(self):
        estimates = {
            "right": pose(angle_deg=1.9, position=(0.019, 0, 0)),
            "coarse": pose(angle_deg=4.9, position=(0, 0.049, 0)),
            "turned": pose(angle_deg=5.1, position=(0.001, 0, 0)),
            "shifted": pose(angle_deg=0.1, position=(0, 0, 0.051)),
            "lost": None,
        }
        rows = self.rows(
            [offline_frame(s, e, pose()) for s, e in estimates.items()],
            [served_answer(s, e) for s, e in estimates.items()])
        self.assertEqual(rows["held-out frames"], "5")
        self.assertEqual(rows["localized"], "4")
        self.assertEqual(rows["within 5 cm and 5 degrees"], "40.0 %")
        self.assertEqual(rows["within 2 cm and 2 degrees"], "20.0 %")
        self.assertEqual(rows["median error"], "3.40 cm, 3.40 degrees")

    def test_frames_without_truth_are_not_scored(self):
        rows = self.rows(
            [offline_frame("a", pose(), pose()),
             offline_frame("b", pose(), None)],
            [served_answer("a", pose()), served_answer("b", pose())])
        self.assertEqual(rows["within 5 cm and 5 degrees"], "100.0 %")

    def test_the_answers_of_the_server_are_scored_not_the_offline_ones(self):
        rows = self.rows([offline_frame("a", pose(), pose())],
                         [served_answer("a", pose(position=(1, 0, 0)))])
        self.assertEqual(rows["within 5 cm and 5 degrees"], "0.0 %")

    def test_latencies(self):
        frames = [offline_frame(str(i), pose(), pose()) for i in range(101)]
        times = list(range(101))
        random.Random(1).shuffle(times)
        rows = self.rows(frames, [served_answer(str(i), pose(), times[i])
                                  for i in range(101)])
        self.assertEqual(rows["round trip, p50 / p99"], "50.0 / 99.0 ms")
        self.assertEqual(rows["of which decoding images"], "4.0 / 4.0 ms")
        self.assertEqual(rows["model"], "20.0 MB, 5 trees, 90000 leaves")
        self.assertEqual(rows["training"], "12.5 s on 500 frames")


class ComparisonTest(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        # Not a round number: the last bit must survive JSON.
        third = pose(angle_deg=1 / 3, position=(1 / 3, 2 / 7, 0.1))
        self.frames = [offline_frame("a", third, pose()),
                       offline_frame("b", None, pose())]
        self.answers = [served_answer("a", copy.deepcopy(third)),
                        served_answer("b", None)]

    def run_table(self):
        offline = self.folder / "offline.json"
        offline.write_text(
            json.dumps({"per_frame": self.frames, "model": MODEL}))
        served = self.folder / "served.jsonl"
        served.write_text("".join(
            answer if isinstance(answer, str) else json.dumps(answer) + "\n"
            for answer in self.answers))
        return subprocess.run(
            [sys.executable, "-B", str(SCRIPT), "--offline", str(offline),
             "--served", str(served)],
            capture_output=True, text=True, check=False)

    def assert_fails_with(self, words):
        done = self.run_table()
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn(words, done.stderr)
        self.assertNotIn("Traceback", done.stderr)

    def test_equal_answers_pass(self):
        done = self.run_table()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("All 2 answers of the server are bit for bit",
                      done.stdout)

    def test_one_bit_is_a_difference(self):
        estimate = self.answers[0]["world_from_camera"]
        estimate["ty"] = math.nextafter(estimate["ty"], 1)
        self.assert_fails_with("a: the poses differ")

    def test_another_outcome_is_a_difference(self):
        self.answers[1] = served_answer("b", pose())
        self.assert_fails_with(
            "b: NOT_LOCALIZED offline, LOCALIZED through the server")

    def test_another_inlier_count_is_a_difference(self):
        self.answers[0]["inliers"] = 99
        self.assert_fails_with("a: 100 inliers offline, 99 through")

    def test_a_missing_answer_is_a_difference(self):
        del self.answers[0]
        self.assert_fails_with("a: the server's answer is missing")

    def test_an_answer_too_many_is_a_difference(self):
        self.answers.append(served_answer("c", pose()))
        self.assert_fails_with("c: not among the offline frames")

    def test_a_failed_query_is_a_difference(self):
        self.answers[1] = {"stem": "b", "color": "b.jpg", "outcome": "ERROR",
                           "code": "UNAVAILABLE", "reason": "stopping"}
        self.assert_fails_with("b: the query failed: UNAVAILABLE: stopping")

    def test_says_which_line_is_not_json(self):
        self.answers.append("what is this\n")
        self.assert_fails_with("line 3 of the client's output is not JSON")

    def test_says_which_key_is_missing(self):
        del self.frames[1]["inliers"]
        self.assert_fails_with("do not have 'inliers' where expected")

    def test_says_that_a_file_is_missing(self):
        done = subprocess.run(
            [sys.executable, "-B", str(SCRIPT), "--offline",
             str(self.folder / "none.json"), "--served", "/dev/null"],
            capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("none.json", done.stderr)
        self.assertNotIn("Traceback", done.stderr)


if __name__ == "__main__":
    unittest.main()
