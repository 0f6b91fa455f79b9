"""scripts/install-deps installs what is missing, and only that."""

import unittest

from stub_programs import REPOSITORY, ScriptTest

PACKAGES = """\
[build]
alpha      # why
beta-dev   # why, too

[tools]
gamma-14   # only to develop

[arm64]
delta-arm  # only for another machine
"""


class InstallDepsTest(ScriptTest):

    def setUp(self):
        super().setUp()
        (self.root / "scripts" / "packages.txt").write_text(PACKAGES)
        self.calls = self.root / "calls"
        self.os_release("debian", "12", "Debian GNU/Linux 12 (bookworm)")
        self.stub("apt-get", f'#!/bin/sh\necho "apt-get $*" >>{self.calls}\n')
        # Only used by those who are not root.
        self.stub("sudo", '#!/bin/sh\nexec "$@"\n')
        self.installed()

    def os_release(self, system, version, name):
        file = self.root / "os-release"
        file.write_text(f'ID={system}\nVERSION_ID="{version}"\n'
                        f'PRETTY_NAME="{name}"\n')

    def installed(self, *names):
        lines = "".join(f"echo installed {name}\n" for name in names)
        self.stub("dpkg-query", "#!/bin/sh\necho config-files gamma-14\n"
                  + lines)

    def install(self, *arguments, **variables):
        return self.run_script(
            "install-deps", *arguments,
            TREELINE_OS_RELEASE=str(self.root / "os-release"), **variables)

    def apt_calls(self):
        return self.calls.read_text() if self.calls.exists() else ""

    def test_leaves_apt_alone_where_all_is_there(self):
        self.installed("alpha", "beta-dev")
        done = self.install()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("all 2 packages are installed", done.stdout)
        self.assertEqual(self.apt_calls(), "")

    def test_installs_what_is_missing(self):
        self.installed("alpha")
        done = self.install()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("apt-get update", self.apt_calls())
        self.assertRegex(self.apt_calls(), r"apt-get install .* beta-dev\n")
        self.assertNotIn("alpha", self.apt_calls())
        self.assertNotIn("gamma-14", self.apt_calls())

    def test_a_removed_package_with_old_settings_is_missing(self):
        self.installed("alpha", "beta-dev")
        done = self.install("--tools")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(self.apt_calls(), r"install .* gamma-14\n")

    def test_the_other_machines_packages_are_asked_for(self):
        self.installed("alpha", "beta-dev")
        done = self.install("--arm64")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(self.apt_calls(), r"install .* delta-arm\n")
        self.assertNotIn("gamma-14", self.apt_calls())

    def test_check_names_what_is_missing_and_installs_nothing(self):
        done = self.install("--check")
        self.assertEqual(done.returncode, 1)
        self.assertIn("missing: alpha beta-dev", done.stderr)
        self.assertEqual(self.apt_calls(), "")

    def test_says_what_to_install_when_apt_fails(self):
        self.stub("apt-get", "#!/bin/sh\nexit 100\n")
        done = self.install()
        self.assertEqual(done.returncode, 1)
        self.assertIn("is there a network? Missing: alpha beta-dev",
                      done.stderr)

    def test_another_system_hears_what_it_lacks(self):
        self.os_release("fedora", "40", "Fedora Linux 40")
        self.stub("pkg-config", '#!/bin/sh\n[ "$2" != spng ]\n')
        done = self.install()
        self.assertEqual(done.returncode, 1)
        self.assertIn("This is Fedora Linux 40", done.stderr)
        self.assertIn("library  spng (development files)\n", done.stderr)
        self.assertNotIn("library  eigen3", done.stderr)
        self.assertIn("docker run", done.stderr)
        self.assertEqual(self.apt_calls(), "")

    def test_another_debian_is_another_system(self):
        self.os_release("debian", "11", "Debian GNU/Linux 11 (bullseye)")
        self.stub("pkg-config", "#!/bin/sh\nexit 1\n")
        self.assertIn("This is Debian GNU/Linux 11", self.install().stderr)

    def test_another_system_that_has_all_goes_on(self):
        self.os_release("ubuntu", "24.04", "Ubuntu 24.04")
        for name in ("pkg-config", "g++", "cmake", "ninja", "protoc",
                     "grpc_cpp_plugin", "python3"):
            self.stub(name, "#!/bin/sh\nexit 0\n")
        done = self.install()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("going on", done.stderr)

    def test_refuses_an_unknown_argument(self):
        done = self.install("--everything")
        self.assertEqual(done.returncode, 1)
        self.assertIn("unknown argument: --everything", done.stderr)


class PackagesTest(unittest.TestCase):

    def test_every_package_says_why(self):
        lines = (REPOSITORY / "scripts" / "packages.txt").read_text()
        for line in lines.splitlines():
            if line and not line.startswith(("#", "[")):
                self.assertRegex(line, r"^[a-z0-9+.-]+ +# \S")


if __name__ == "__main__":
    unittest.main()
