"""The tutorial, followed word by word.

    tutorial_test.py PROGRAMS SCENE PACKAGE

What is fenced as ```sh in docs/tutorials/python-notebook.md is run in one
shell, as a reader would. What is fenced without a language builds Treeline, as
the build that runs this test has done; it is put where the tutorial has it.
"""

import dataclasses
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import unittest

import treeline

PROGRAMS, _, PACKAGE = (pathlib.Path(a).resolve() for a in sys.argv[1:4])
ROOT = pathlib.Path(__file__).resolve().parents[3]
TUTORIAL = ROOT / "docs" / "tutorials" / "python-notebook.md"


class Tutorial(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.checkout = self.folder / "treeline"
        (self.checkout / "build").mkdir(parents=True)
        (self.checkout / "client").symlink_to(ROOT / "client")
        (self.checkout / "build" / "python").symlink_to(PACKAGE)

    def follow(self, commands):
        """The transcript. Kills all that a failed step leaves behind."""
        shell = subprocess.Popen(
            ["bash", "-e", "-m", "-c", commands], cwd=self.folder, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            env={**os.environ, "TREELINE": str(self.checkout),
                 "PATH": f"{PROGRAMS}:/usr/bin:/bin"}, start_new_session=True)
        try:
            transcript, _ = shell.communicate(timeout=560)
        except subprocess.TimeoutExpired:
            transcript = ""
        finally:
            for process in pathlib.Path("/proc").glob("[0-9]*/stat"):
                self.end_if_of(shell.pid, process)
            shell.wait()
        self.assertEqual(shell.returncode, 0, transcript)
        return transcript

    @staticmethod
    def end_if_of(session, stat):
        """Of a session of its own, so that nobody else's is ended."""
        try:
            fields = stat.read_text().rpartition(")")[2].split()
            if int(fields[3]) == session:
                os.kill(int(stat.parent.name), signal.SIGKILL)
        except (OSError, IndexError):
            pass

    def test_its_commands_do_what_it_says(self):
        steps = re.findall(r"^```sh\n(.*?)^```$", TUTORIAL.read_text(),
                           re.M | re.S)
        self.assertEqual(len(steps), 6)
        # A reader is slower than a shell: the server is up by step 4.
        steps[1] += "wait_until_it_listens\n"
        transcript = self.follow("\n".join([
            "wait_until_it_listens() {",
            "  until treeline-client scenes --server 127.0.0.1:7361"
            " >/dev/null 2>&1",
            "  do kill -0 %1 || return 1; done",
            "}", *steps]))
        self.assertRegex(transcript, r"listening on 127\.0\.0\.1:7361")
        self.assertRegex(transcript, r"DEPTH camera at [\d. -]+ m, confidence")
        self.assertRegex(transcript, r"frame-\d+ +\d\.\d cm")
        for picture in ("track.png", "inliers.png"):
            self.assertTrue((self.folder / picture).is_file(), picture)


class HowTo(unittest.TestCase):

    def test_it_names_only_what_there_is(self):
        page = (ROOT / "docs" / "how-to" / "use-from-python.md").read_text()
        names = set(re.findall(
            r"\b(cameras|errors|geodesy|geometry)\.(\w+)", page))
        names |= {("errors", name) for row in re.findall(
            r"^\| (`\w+`(?:, `\w+`)*) \|", page.partition("## Errors")[2],
            re.M) for name in re.findall(r"`(\w+)`", row)}
        self.assertGreater(len(names), 20)
        for module, name in names:
            self.assertTrue(hasattr(getattr(treeline, module), name),
                            f"{module}.{name}")
        for name in re.findall(r"\btreeline\.([A-Z]\w+)", page):
            self.assertTrue(hasattr(treeline, name), name)
        table = page.partition("| argument of")[2].partition("\n\n")[0]
        fields = {field.name for field in dataclasses.fields(treeline.Query)}
        for row in re.findall(r"^\| (`.*?) \|", table, re.M):
            for name in re.findall(r"`(\w+)`", row):
                self.assertIn(name, {*fields, "timeout_s"})


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
