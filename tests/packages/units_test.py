"""The services' units are valid, and give away little.

    units_test.py PACKAGING
"""

import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from packaging import arguments, skip

PACKAGING, = arguments(1)
UNITS = ("treeline-server", "treeline-agent")
# As systemd-analyze counts: 0 nothing can be done from the service, 10 all.
MOST_EXPOSURE = 2.0


def unit_file(name):
    return PACKAGING / "debian" / f"{name}.service"


def settings_of(name):
    """{setting: [value, ...]} of all sections."""
    settings = {}
    for line in unit_file(name).read_text().splitlines():
        match = re.match(r"(\w+)=(.*)$", line)
        if match:
            settings.setdefault(match[1], []).append(match[2])
    return settings


def analyze(*words):
    return subprocess.run(["systemd-analyze", "--no-pager", *words],
                          capture_output=True, text=True, check=False)


class UnitsTest(unittest.TestCase):

    def exposure(self, path):
        done = analyze("security", "--offline=true", str(path))
        found = re.search(r"Overall exposure level for \S+: ([\d.]+)",
                          done.stdout)
        self.assertTrue(found, done.stdout + done.stderr)
        return float(found[1])

    def test_they_are_exposed_little(self):
        for name in UNITS:
            with self.subTest(unit=name):
                exposure = self.exposure(unit_file(name))
                print(f"{name}.service: exposure {exposure}")
                self.assertLess(exposure, MOST_EXPOSURE)

    def test_the_count_would_notice(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "open.service")
            path.write_text("[Service]\nExecStart=/bin/true\n")
            self.assertGreater(self.exposure(path), 9)

    def test_systemd_understands_every_line(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in UNITS:
                # The program and its page are not installed here.
                text = re.sub(r"(?m)^ExecStart=\S+", "ExecStart=/bin/true",
                              unit_file(name).read_text())
                text = re.sub(r"(?m)^Documentation=.*\n", "", text)
                path = pathlib.Path(folder, f"{name}.service")
                path.write_text(text)
                done = analyze("verify", str(path))
                about = [line for line in done.stderr.splitlines()
                         if name in line]
                self.assertEqual(about, [])
                self.assertEqual(done.returncode, 0, done.stderr)

    def test_they_run_what_the_packages_install(self):
        server, agent = map(settings_of, UNITS)
        self.assertEqual(server["ExecStart"], [
            "/usr/bin/treeline-server --config /etc/treeline/server.yaml"])
        self.assertEqual(agent["ExecStart"], [
            "/usr/bin/treeline-agent run --config /etc/treeline/agent.yaml"])
        rules = (PACKAGING / "debian" / "rules").read_text()
        self.assertIn("--package=treeline-agent --no-enable --no-start", rules)

    def test_they_need_no_other_packages_programs(self):
        # /bin/kill, for instance, is not everywhere.
        for name in UNITS:
            for setting, values in settings_of(name).items():
                if setting.startswith("Exec"):
                    for value in values:
                        self.assertRegex(value, r"^(/usr/bin/treeline-\S+|"
                                                r"/bin/sh) ")

    def test_their_users_are_made(self):
        for name in UNITS:
            user = settings_of(name)["User"][0]
            made = (PACKAGING / "debian" / f"{name}.sysusers").read_text()
            self.assertRegex(made, rf"(?m)^u {user} - ")

    def test_they_may_finish_and_do_not_loop(self):
        for name in UNITS:
            settings = settings_of(name)
            self.assertEqual(settings["Restart"], ["on-failure"])
            self.assertEqual(settings["RestartPreventExitStatus"], ["2"])
            self.assertGreaterEqual(int(settings["TimeoutStopSec"][0]), 30)
            self.assertGreaterEqual(int(settings["LimitNOFILE"][0]), 65536)
            self.assertGreaterEqual(int(settings["StartLimitBurst"][0]), 1)


if __name__ == "__main__":
    if shutil.which("systemd-analyze") is None:
        skip("there is no systemd-analyze here")
    unittest.main(argv=["units_test.py"])
