"""The scripts for 64-bit Arm say so where they cannot work, and touch nothing."""

import unittest

from stub_programs import ScriptTest

NO_MIRROR = "#!/bin/sh\nexit 0\n"
# Knows a mirror, and reaches nothing.
NO_NETWORK = """#!/bin/sh
case "$1" in
indextargets) echo deb http://mirror.invalid bookworm main ;;
*) echo "E: no network" >&2; exit 100 ;;
esac
"""


class Arm64Test(ScriptTest):

    def setUp(self):
        super().setUp()
        for name in ("aarch64-linux-gnu-g++", "qemu-aarch64-static"):
            self.stub(name, "#!/bin/sh\nexit 0\n")

    def test_without_network_there_are_no_libraries(self):
        self.stub("apt-get", NO_NETWORK)
        for script in ("arm64-sysroot", "test-arm64"):
            done = self.run_script(script)
            self.assertEqual(done.returncode, 77, done.stderr)
            self.assertIn("skipped: apt has not got the packages", done.stdout)
            self.assertIn("E: no network", done.stderr)
            self.assertFalse((self.root / "build" / "arm64-sysroot").exists())

    def test_without_a_mirror_it_says_what_to_do(self):
        self.stub("apt-get", NO_MIRROR)
        done = self.run_script("arm64-sysroot")
        self.assertEqual(done.returncode, 77, done.stderr)
        self.assertIn("run apt-get update", done.stdout)

    def test_libraries_of_the_same_packages_are_kept(self):
        packages = self.root / "scripts" / "packages.txt"
        packages.write_text("[build]\ng++  # why\nalpha-dev  # why\n\n"
                            "[tools]\nbeta-dev  # why\n")
        sysroot = self.root / "build" / "arm64-sysroot"
        sysroot.mkdir(parents=True)
        (sysroot / "packages.txt").write_text("alpha-dev\n")
        self.stub("apt-get", NO_NETWORK)
        done = self.run_script("arm64-sysroot")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.run_script("arm64-sysroot", "--fresh").returncode,
                         77)
        packages.write_text("[build]\nalpha-dev  # why\ngamma-dev  # why\n")
        self.assertEqual(self.run_script("arm64-sysroot").returncode, 77)
        self.assertTrue((sysroot / "packages.txt").exists())

    def test_help_names_what_it_does_and_the_codes(self):
        for script in ("arm64-sysroot", "test-arm64"):
            done = self.run_script(script, "--help")
            self.assertEqual(done.returncode, 0)
            self.assertIn("Exit codes: 0", done.stdout)
            self.assertIn("77", done.stdout)


if __name__ == "__main__":
    unittest.main()
