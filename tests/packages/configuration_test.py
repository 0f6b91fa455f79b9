"""The packages' configuration files are what the programs read.

    configuration_test.py PACKAGING BIN
"""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from packaging import arguments

PACKAGING, BIN = arguments(2)
COMMANDS = {"server": ["treeline-server"], "agent": ["treeline-agent", "run"]}
# What the package sets; everything else keeps its default.
SET = {"server": {"models", "poll_s"}, "agent": set()}


def config_text(program):
    return subprocess.run(
        [sys.executable, "-B", PACKAGING / "lib" / "make_config.py", program],
        capture_output=True, text=True, check=True).stdout


class ConfigurationTest(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.file = pathlib.Path(folder.name, "config.yaml")

    def in_force(self, program, text):
        """{setting: (value, origin)} as the program has it."""
        self.file.write_text(text)
        done = subprocess.run(
            [BIN / COMMANDS[program][0], *COMMANDS[program][1:], "--config",
             self.file, "--print-config"],
            capture_output=True, text=True, check=False, env={})
        self.assertEqual(done.returncode, 0, done.stderr)
        return {match[1]: (match[2], match[3]) for match in re.finditer(
            r"(?m)^(\w+): (.*?)  # (.*)$", done.stdout)}

    def test_as_installed_only_what_must_be_is_set(self):
        for program in COMMANDS:
            with self.subTest(program=program):
                values = self.in_force(program, config_text(program))
                self.assertGreater(len(values), 20)
                self.assertEqual(
                    {name for name, (_, origin) in values.items()
                     if origin != "default"}, SET[program])

    def test_it_names_every_setting_and_its_default(self):
        for program in COMMANDS:
            text = config_text(program)
            values = self.in_force(program, text)
            named = re.findall(r"(?m)^#?(\w+): ", text)
            self.assertEqual(sorted(named), sorted(values))
            # Its examples are not defaults; everything else is.
            everything = re.sub(r"(?m)^#(\w+: )", r"\1", text)
            sys.path.insert(0, str(PACKAGING / "lib"))
            import make_config
            examples = make_config.PROGRAMS[program][3].keys()
            filled = self.in_force(program, everything)
            for name in values.keys() - examples - SET[program]:
                self.assertEqual(filled[name][0], values[name][0], name)
            for name in examples:
                self.assertIn("config.yaml:", filled[name][1])


if __name__ == "__main__":
    unittest.main(argv=["configuration_test.py"])
