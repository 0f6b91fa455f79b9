"""What a program's --help becomes: parts, a manual page, completion.

    help_parts_test.py PACKAGING
"""

import unittest

from packaging import arguments

arguments(1)
from completion import bash_completion  # noqa: E402
from man_page import man_page  # noqa: E402
from program_help import HelpError, read_help  # noqa: E402

HELP = """\
Learns a place: from what
a camera saw.
Usage: ./bin/prog learn [OPTIONS] CAPTURE

Positionals:
  CAPTURE PATH REQUIRED       What to learn from

Options:
  -h,--help                   Print this help message and exit
  -l,--log-level TEXT         Lowest level that is logged [debug, info; default
                              info]
  --threads N=3               Threads
  --tls-cert FILE Needs: --tls-key
                              Certificate
  --quiet Excludes: --threads No progress
  --kind TEXT:{a,b} REQUIRED  Its kind


Method:
  --seed INT                  Seed

Subcommands:
  room                        A room

The first paragraph,
in two lines.

  a.yaml:2: set in

Examples:
  prog learn x \\
      --quiet
  .hidden

Exit codes: 0 done, 1 failed.
"""


class ReadHelpTest(unittest.TestCase):

    def setUp(self):
        self.help = read_help(["prog", "learn"], HELP)
        self.options = {option.names[-1]: option
                        for option in self.help.options}

    def test_the_parts(self):
        self.assertEqual(self.help.description,
                         "Learns a place: from what a camera saw.")
        self.assertEqual(self.help.usage, "[OPTIONS] CAPTURE")
        self.assertEqual([heading for heading, _ in self.help.lists],
                         ["Positionals", "Options", "Method"])
        self.assertEqual(self.help.commands[0].term, "room")
        self.assertTrue(self.help.footer.startswith("The first paragraph,"))
        self.assertTrue(self.help.footer.endswith("1 failed."))

    def test_options_know_their_values(self):
        values = {name: option.value for name, option in self.options.items()}
        self.assertEqual(values, {
            "--help": "", "--log-level": "TEXT", "--threads": "N=3",
            "--tls-cert": "FILE", "--quiet": "", "--kind": "TEXT:{a,b}",
            "--seed": "INT"})
        self.assertEqual(self.options["--log-level"].choices,
                         ["debug", "info"])
        self.assertEqual(self.options["--kind"].choices, ["a", "b"])
        self.assertEqual(self.options["--threads"].choices, [])
        self.assertTrue(self.options["--tls-cert"].is_place)
        self.assertFalse(self.options["--threads"].is_place)

    def test_without_usage_it_is_no_help(self):
        with self.assertRaisesRegex(HelpError, "prog"):
            read_help(["prog"], "Segmentation fault\n")


class ManPageTest(unittest.TestCase):

    def setUp(self):
        one = read_help(["prog", "learn"], HELP)
        program = read_help(["prog"], HELP)
        self.page = man_page(one, [program, one], "1.2.0", 1763000000)

    def test_head_and_sections(self):
        self.assertIn('.TH PROG\\-LEARN 1 2025-11-13 "Treeline 1.2.0"',
                      self.page)
        self.assertIn(".SH NAME\nprog\\-learn \\- learns a place\n", self.page)
        self.assertIn("\\fBprog\\fR(1)", self.page)
        sections = [line[4:].strip('"') for line in self.page.splitlines()
                    if line.startswith(".SH ")]
        self.assertEqual(sections, [
            "NAME", "SYNOPSIS", "DESCRIPTION", "POSITIONALS", "OPTIONS",
            "METHOD", "COMMANDS", "NOTES", "EXAMPLES", "EXIT STATUS",
            "SEE ALSO"])

    def test_examples_stay_as_they_are(self):
        self.assertIn(".nf\nprog learn x \\e\n    \\-\\-quiet\n\\&.hidden\n.fi",
                      self.page)
        self.assertIn(".nf\na.yaml:2: set in\n.fi", self.page)


class CompletionTest(unittest.TestCase):

    def test_values_are_completed_by_what_they_are(self):
        text = bash_completion([read_help(["prog"], HELP)])
        self.assertIn("' -l' | ' --log-level')", text)
        self.assertIn("compgen -W 'debug info'", text)
        self.assertIn("complete -F _prog prog\n", text)


if __name__ == "__main__":
    unittest.main(argv=["help_parts_test.py"])
