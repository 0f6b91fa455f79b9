"""docs/tutorials/serve-a-room.md, followed word by word, but for a shorter walk
and ports of its own.

    serve_a_room_test.py PROGRAMS
"""

import json
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

from following import follow, steps_of

PROGRAMS = pathlib.Path(sys.argv[1]).resolve()
ADDRESS = "127.0.0.1:7363"
HTTP_ADDRESS = "127.0.0.1:7364"
HAS_CURL = shutil.which("curl") is not None


def numbers(text):
    return [float(number) for number in text.split()]


class Tutorial(unittest.TestCase):

    def test_its_commands_do_what_it_says(self):
        steps = steps_of("tutorials/serve-a-room.md")
        self.assertEqual(len(steps), 10)
        if not HAS_CURL:
            print("curl is not installed: its step is left out")
            steps = [step for step in steps if "curl" not in step]
        # A reader is slower than a shell.
        steps[4] += "wait_until_it_listens\n"
        commands = "\n".join([
            "wait_until_it_listens() {",
            f"  until treeline-client scenes --server {ADDRESS}"
            " >/dev/null 2>&1",
            "  do kill -0 %1 || return 1; done",
            "}", *steps])
        commands = commands.replace("--frames 600", "--frames 120").replace(
            "127.0.0.1:50051", ADDRESS).replace(
                "127.0.0.1:8080", HTTP_ADDRESS)
        with tempfile.TemporaryDirectory() as name:
            status, transcript = follow(
                commands, name, PROGRAMS, TREELINE_SERVER_LISTEN=ADDRESS,
                TREELINE_SERVER_ADMIN_LISTEN="",
                TREELINE_SERVER_HTTP_LISTEN=HTTP_ADDRESS)
            self.assertEqual(status, 0, transcript)
            folder = pathlib.Path(name)
            self.assertTrue((folder / "models/room/1/model.treeline").is_file())
            self.assertTrue((folder / "report.html").is_file() or
                            (folder / "report.data.json").is_file(), transcript)
            stem = (folder / "room/test.txt").read_text().split()[0]
            rows = [numbers(line) for line in (
                folder / f"room/{stem}.pose.txt").read_text().splitlines()[:3]]
            self.assertIn("color_from_depth 1 0 0 0 -0.025 0 0",
                          (folder / "room/recording.txt").read_text())
        # Where the colour camera is, which the answer is of.
        truth = [row[3] + 0.025 * row[0] for row in rows]
        self.assertIn(f"listening on {ADDRESS}", transcript)
        answers = re.findall(r"(?m)^LOCALIZED in room.*: colour camera\n  position +"
                             r"([-\d. ]+) m", transcript)
        self.assertEqual(len(answers), 2, transcript)
        for answer in answers:
            for found, true in zip(numbers(answer), truth, strict=True):
                self.assertAlmostEqual(found, true, delta=0.015)
        if HAS_CURL:
            line = re.search(r"(?m)^{.*OUTCOME_LOCALIZED.*}", transcript)
            pose = json.loads(line.group())["worldFromCamera"]
            for axis, true in zip("xyz", truth, strict=True):
                self.assertAlmostEqual(pose["translationM"].get(axis, 0), true,
                                       delta=0.015)
        self.assertRegex(transcript, r"(?m)^NOT LOCALIZED in room")
        self.assertIn("exit status 3\n", transcript)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
