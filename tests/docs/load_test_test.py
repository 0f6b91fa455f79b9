"""docs/tutorials/load-test.md, followed word by word.

    load_test_test.py PROGRAMS
"""

import json
import pathlib
import sys
import tempfile
import unittest

from following import follow, steps_of

PROGRAMS = pathlib.Path(sys.argv[1]).resolve()


class Tutorial(unittest.TestCase):

    def test_its_commands_do_what_it_says(self):
        steps = steps_of("tutorials/load-test.md")
        self.assertEqual(len(steps), 7)
        # A reader is slower than a shell: the server is up by step 4.
        steps[1] += "wait_until_it_listens\n"
        with tempfile.TemporaryDirectory() as name:
            status, transcript = follow("\n".join([
                "wait_until_it_listens() {",
                "  until treeline-client scenes --server 127.0.0.1:7365"
                " >/dev/null 2>&1",
                "  do kill -0 %1 || return 1; done",
                "}", *steps]), name, PROGRAMS)
            self.assertEqual(status, 0, transcript)
            folder = pathlib.Path(name)
            report = [path for path in (folder / "load.html",
                                        folder / "load.data.json")
                      if path.is_file()]
            self.assertEqual(len(report), 1, transcript)
            self.assertIn('"server_metrics": {', report[0].read_text())
            good = json.loads((folder / "good.json").read_text())
            bad = json.loads((folder / "bad.json").read_text())
        self.assertRegex(transcript, r"closed loop, 4 at a time, 5\.0 s\n"
                         r"  goodput \d+\.\d/s")
        self.assertRegex(transcript, r"open loop, 40\.0/s")
        self.assertRegex(transcript, r"poses: \d+ of \d+ within tolerance")
        self.assertRegex(transcript, r"(?m)^\d+\.\d/s answered, localized ")
        self.assertIn("exit status 0\nexit status 4\n", transcript)
        self.assertEqual(good["runs"][0]["failures"], [])
        self.assertRegex(bad["runs"][0]["failures"][0], r"^p99 is .*p99>1us")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
