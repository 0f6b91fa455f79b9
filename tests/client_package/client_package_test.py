r"""The installed C++ client, used as a stranger would.

    client_package_test.py BUILD PROGRAMS SCENE HARNESS COMPILER \
        --sanitize=SANITIZERS

BUILD is the build folder; PROGRAMS holds treeline-server; SCENE is a folder
with recording/ and room.treeline, of tests/integration/make_scene.cmake;
HARNESS has real_server.py. SANITIZERS is what the archive was built with.
"""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

BUILD, PROGRAMS, SCENE, HARNESS = (pathlib.Path(a) for a in sys.argv[1:5])
COMPILER = sys.argv[5]
SANITIZERS = sys.argv[6].removeprefix("--sanitize=")
sys.path.insert(0, str(HARNESS))
from real_server import RealServer, put_scene  # noqa: E402

CONSUMER = pathlib.Path(__file__).resolve().parent / "consumer"
PAGE = CONSUMER.parents[2] / "docs" / "how-to" / "use-from-cpp.md"
FLAGS = [f"-fsanitize={SANITIZERS}"] if SANITIZERS else []
# What a program of others must not have to find.
HEAVY = re.compile(r'#include [<"](grpc|google/|Eigen|opencv|.*\.pb\.h)')


def run(*command, **options):
    result = subprocess.run([str(part) for part in command], text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            check=False, **options)
    if result.returncode != 0:
        raise AssertionError(f"{command}:\n{result.stdout}")
    return result.stdout


class Installed(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        first = cls.folder / "installed"
        run("cmake", "--install", BUILD, "--component", "client", "--prefix",
            first)
        # Nothing in it may say where it was put.
        cls.prefix = cls.folder / "moved here"
        first.rename(cls.prefix)
        cls.pkgconfig = next(cls.prefix.rglob("treeline-client.pc")).parent
        put_scene(cls.folder / "models", SCENE / "room.treeline")
        cls.server = RealServer(PROGRAMS / "treeline-server",
                                cls.folder / "models")
        cls.addClassCleanup(cls.server.stop)
        cls.stem = (SCENE / "recording" / "test.txt").read_text().split()[0]

    def pkg_config(self, *arguments):
        # Debian's pkg-config leaves blanks in paths unquoted.
        plain = self.folder / "plain"
        if not plain.exists():
            plain.symlink_to(self.prefix)
        folder = plain / self.pkgconfig.relative_to(self.prefix)
        return run("pkg-config", *arguments, "treeline-client",
                   env={"PATH": "/usr/bin:/bin",
                        "PKG_CONFIG_PATH": str(folder)}).split()

    def ask(self, program, scene="room"):
        recording = SCENE / "recording"
        return subprocess.run(
            [program, self.server.address, scene,
             recording / f"{self.stem}.color.jpg",
             recording / f"{self.stem}.depth.png"],
            capture_output=True, text=True, check=False)

    def check_program(self, program):
        done = self.ask(program)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        match = re.fullmatch(
            r"localized (\S+) (\S+) (\S+)\nworld tentative\n", done.stdout)
        self.assertTrue(match, done.stdout)
        truth = (SCENE / "recording" / f"{self.stem}.pose.txt").read_text()
        rows = [line.split() for line in truth.splitlines()]
        for said, row in zip(match.groups(), rows):
            self.assertAlmostEqual(float(said), float(row[3]), delta=0.05)
        unknown = self.ask(program, "attic")
        self.assertEqual(unknown.returncode, 1)
        self.assertRegex(unknown.stdout, "^error SCENE_NOT_FOUND: .*attic")

    def test_cmake_finds_it(self):
        build = self.folder / "by-cmake"
        run("cmake", "-S", CONSUMER, "-B", build,
            f"-DCMAKE_PREFIX_PATH={self.prefix}",
            f"-DCMAKE_CXX_COMPILER={COMPILER}",
            f"-DCMAKE_CXX_FLAGS={' '.join(FLAGS)}")
        run("cmake", "--build", build)
        self.check_program(build / "where_am_i")

    def test_pkg_config_finds_it(self):
        program = self.folder / "by-pkg-config"
        run(COMPILER, "-std=c++20", *FLAGS, CONSUMER / "where_am_i.cc", "-o",
            program, *self.pkg_config("--cflags", "--libs"))
        self.check_program(program)

    def test_another_minor_version_is_not_found(self):
        project = self.folder / "wants-more"
        project.mkdir()
        (project / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.25)\n"
            "project(wants_more LANGUAGES CXX)\n"
            "find_package(treeline-client 0.99 REQUIRED)\n")
        with self.assertRaisesRegex(AssertionError, "0\\.99"):
            run("cmake", "-S", project, "-B", project / "build",
                f"-DCMAKE_PREFIX_PATH={self.prefix}")

    def test_every_header_stands_by_itself_and_is_light(self):
        include = self.prefix / "include" / "treeline"
        headers = sorted(include.rglob("*"))
        headers = [h for h in headers if h.is_file()]
        self.assertGreater(len(headers), 10)
        flags = self.pkg_config("--cflags")
        for header in headers:
            name = str(header.relative_to(include))
            self.assertTrue(name.endswith(".h"), name)
            self.assertIsNone(HEAVY.search(header.read_text()), name)
            run(COMPILER, "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra",
                "-Werror", "-x", "c++", "-", *flags,
                input=f'#include "{name}"\n')

    def test_nothing_else_is_installed(self):
        kinds = {"treeline": 0, "cmake": 0, "pkgconfig": 0}
        for file in self.prefix.rglob("*"):
            if file.is_dir():
                continue
            name = str(file.relative_to(self.prefix))
            match = re.fullmatch(
                r"include/(treeline)/(client|common)/.*\.h"
                r"|lib[^ ]*/(cmake)/treeline-client/treeline-client-.*\.cmake"
                r"|lib[^ ]*/(pkgconfig)/treeline-client\.pc"
                r"|lib[^ ]*/libtreeline-client\.a"
                r"|share/treeline/proto/(google|treeline)/.*\.proto", name)
            self.assertTrue(match, name)
            for kind in filter(kinds.__contains__, match.groups()):
                kinds[kind] += 1
        self.assertTrue(all(kinds.values()), kinds)

    def test_the_page_shows_this_program(self):
        shown = re.findall(r"^```(?:cpp|cmake)\n(.*?)^```$", PAGE.read_text(),
                           re.M | re.S)
        self.assertGreaterEqual(len(shown), 2)
        # However its lines are broken.
        known = "".join("".join((CONSUMER / name).read_text().split())
                        for name in ("where_am_i.cc", "CMakeLists.txt"))
        for block in shown[:2]:
            for line in filter(None, map(str.strip, block.splitlines())):
                self.assertIn("".join(line.split()), known)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
