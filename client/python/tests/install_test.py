"""The wheel in a fresh environment, and what Debian's package installs.

    install_test.py PROGRAMS SCENE PACKAGE
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from real_server import RealServer, put_scene

PROGRAMS, SCENE, PACKAGE = (pathlib.Path(a).resolve() for a in sys.argv[1:4])
ROOT = pathlib.Path(__file__).resolve().parents[3]
EXAMPLE = ROOT / "client" / "python" / "examples" / "localize.py"


class Install(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_program(self, *command, **environment):
        """What it prints. Nothing of this process' path reaches it."""
        inherited = {name: value for name, value in os.environ.items()
                     if not name.startswith("PYTHON")}
        done = subprocess.run(
            command, cwd=self.folder, env={**inherited, **environment},
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            check=False)
        self.assertEqual(done.returncode, 0, done.stdout)
        return done.stdout

    def localize(self, python, **environment):
        """What the example says of a frame, asked at a real server."""
        put_scene(self.folder / "models", SCENE / "room.treeline")
        server = RealServer(PROGRAMS / "treeline-server",
                            self.folder / "models")
        self.addCleanup(server.stop)
        recording = SCENE / "recording"
        stem = (recording / "test.txt").read_text().split()[0]
        return self.run_program(
            python, "-B", EXAMPLE, server.address, "room",
            recording / f"{stem}.color.jpg", recording / f"{stem}.depth.png",
            **environment)

    def test_the_wheel_works_in_a_fresh_environment(self):
        self.run_program(sys.executable, "-m", "venv", "--system-site-packages",
                         "venv")
        python = self.folder / "venv" / "bin" / "python"
        wheel, = PACKAGE.glob("*.whl")
        # Without an index: what it needs must be there, of Debian.
        self.run_program(python, "-m", "pip", "install", "--no-index", wheel)
        where = self.run_program(python, "-c",
                                 "import treeline; print(treeline.__file__)")
        self.assertTrue(where.startswith(str(self.folder / "venv")), where)
        self.assertRegex(self.localize(python),
                         r"^DEPTH camera at [\d. -]+ m, confidence [\d.]+,")

    def test_debians_package_works_where_it_is_unpacked(self):
        deb, = PACKAGE.glob("*.deb")
        self.run_program("dpkg-deb", "--extract", deb, self.folder / "root")
        modules = self.folder / "root" / "usr/lib/python3/dist-packages"
        where = self.run_program(
            sys.executable, "-B", "-c",
            "import treeline; print(treeline.__file__)",
            PYTHONPATH=str(modules))
        self.assertTrue(where.startswith(str(modules)), where)
        self.assertRegex(
            self.localize(sys.executable, PYTHONPATH=str(modules)),
            r"^DEPTH camera at [\d. -]+ m, confidence [\d.]+,")
        depends = self.run_program("dpkg-deb", "--field", deb, "Depends")
        for package in ("python3-grpcio", "python3-numpy", "python3-protobuf"):
            self.assertIn(package, depends)

    def test_nothing_is_installed_but_the_package(self):
        deb, = PACKAGE.glob("*.deb")
        listed = self.run_program("dpkg-deb", "--contents", deb)
        for line in listed.splitlines():
            self.assertRegex(
                line, r" \./(usr/(lib/(python3/(dist-packages/(treeline"
                r"(-[\d.]+\.dist-info)?/.*)?)?)?|share/(doc/"
                r"(python3-treeline/.*)?)?)?)?$")

    def test_versions_are_those_of_treeline(self):
        version = re.search(r"project\(treeline VERSION ([\d.]+)",
                            (ROOT / "CMakeLists.txt").read_text())[1]
        for pattern in (f"treeline-{version}-py3-none-any.whl",
                        f"python3-treeline_{version}_all.deb"):
            self.assertTrue((PACKAGE / pattern).exists(), pattern)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
