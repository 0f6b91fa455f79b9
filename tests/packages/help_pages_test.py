"""Manual pages and completion of the real programs.

    help_pages_test.py PACKAGING BIN
"""

import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from packaging import PROGRAMS, arguments

PACKAGING, BIN = arguments(2)

# Asks the completion in FILE what it offers where LINE ends.
ASK = r"""
source "$1"
read -ra COMP_WORDS <<<"$2"
if [[ "$2" == *" " ]]; then COMP_WORDS+=(""); fi
COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
function=$(complete -p "${COMP_WORDS[0]}" | sed 's/.*-F \([^ ]*\).*/\1/')
compopt() { :; }
"$function"
printf '%s\n' "${COMPREPLY[@]}"
"""


def run(*command, **options):
    return subprocess.run([str(word) for word in command], text=True,
                          capture_output=True, check=False, **options)


class HelpPagesTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.out = pathlib.Path(folder.name)
        programs = [BIN / name for name in PROGRAMS]
        programs.append(PACKAGING / "treeline-demo")
        done = run(PACKAGING / "make-help-pages", cls.out, *programs,
                   env={**os.environ, "SOURCE_DATE_EPOCH": "1763000000",
                        "TREELINE_DEMO_BIN": str(BIN)})
        if done.returncode != 0:
            raise AssertionError(done.stdout + done.stderr)
        cls.pages = sorted((cls.out / "man" / "man1").iterdir())

    def completions(self, line):
        program = line.split()[0]
        file = self.out / "bash-completion" / "completions" / program
        done = run("bash", "--norc", "-c", ASK, "bash", file, line)
        self.assertEqual(done.stderr, "")
        return done.stdout.split()

    def test_every_program_and_command_has_a_page(self):
        names = {page.stem for page in self.pages}
        self.assertGreater(len(names), 30)
        for name in (*PROGRAMS, "treeline-demo", "treeline-learn",
                     "treeline-synth-record", "treeline-agent-run",
                     "treeline-client-watch", "treeline-server-healthcheck"):
            self.assertIn(name, names)

    def test_man_has_nothing_to_complain_of(self):
        if shutil.which("man") is None:
            self.skipTest("there is no man here")
        for page in self.pages:
            with self.subTest(page=page.name):
                done = run("man", "--warnings=w", "-E", "UTF-8", "-l", "-Tutf8",
                           "-Z", page, env={**os.environ, "LC_ALL": "C.UTF-8",
                                            "MANROFFSEQ": "", "MANWIDTH": "80"})
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                done = run("lexgrog", page)
                self.assertEqual(done.returncode, 0, done.stdout)

    def test_no_help_is_left_out(self):
        for page in self.pages:
            text = page.read_text()
            self.assertIn("\n.SH NAME\n", text)
            self.assertIn("\\-\\-help", text, page.name)
            self.assertNotRegex(text, r"(?m)^\.TP\n\\fBExamples", page.name)
        learn = (self.out / "man/man1/treeline-learn.1").read_text()
        self.assertIn(".SH EXAMPLES", learn)

    def test_shells_can_read_the_completion(self):
        for program in (*PROGRAMS, "treeline-demo"):
            file = self.out / "bash-completion" / "completions" / program
            done = run("bash", "-n", file)
            self.assertEqual((done.returncode, done.stderr), (0, ""), program)
            if shutil.which("shellcheck"):
                done = run("shellcheck", "--severity=warning", file)
                self.assertEqual(done.returncode, 0, done.stdout)
            file = self.out / "zsh" / "vendor-completions" / f"_{program}"
            self.assertTrue(file.read_text().startswith(f"#compdef {program}"))
            if shutil.which("zsh"):
                done = run("zsh", "-n", file)
                self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_commands_options_and_choices_are_offered(self):
        self.assertIn("learn", self.completions("treeline "))
        self.assertIn("record", self.completions("treeline synth "))
        self.assertEqual(self.completions("treeline synth record --fram"),
                         ["--frames"])
        self.assertEqual(self.completions("treeline-server --http-l"),
                         ["--http-listen"])
        self.assertEqual(self.completions("treeline-server --log-level d"),
                         ["debug"])
        self.assertEqual(self.completions("treeline-server --log-level = d"),
                         ["debug"])
        self.assertIn("missions", self.completions("treeline-agent suite "))
        # Of a command: not what another one has.
        self.assertEqual(self.completions("treeline-server healthcheck --http"),
                         [])
        self.assertEqual(self.completions("treeline-client nonsense --col"),
                         [])

    def test_values_that_are_files_are_left_to_the_shell(self):
        self.assertEqual(self.completions("treeline-server --config "), [])
        self.assertEqual(self.completions("treeline train --dataset "), [])


class BrokenProgramTest(unittest.TestCase):

    def test_a_program_that_cannot_be_asked_is_named(self):
        with tempfile.TemporaryDirectory() as folder:
            program = pathlib.Path(folder, "broken")
            program.write_text("#!/bin/sh\necho no >&2\nexit 3\n")
            program.chmod(0o755)
            done = run(PACKAGING / "make-help-pages", folder, program)
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, "broken .*status 3: no")


if __name__ == "__main__":
    unittest.main(argv=["help_pages_test.py"])
