"""The link lint finds what it is there to find."""

import unittest

import link_lint
import rules
from fixture_tree import FixtureTreeTest

TABLE = rules.load()


class LinkLintTest(FixtureTreeTest):

    def findings(self):
        return link_lint.findings_in(self.root, TABLE)[0]

    def assert_one_finding(self, *parts):
        findings = self.findings()
        self.assertEqual(len(findings), 1, findings)
        for part in parts:
            self.assertIn(part, findings[0])

    def library(self, folder, name, deps="", keyword="DEPS"):
        self.write(f"{folder}/{name}.cc")
        self.write(f"{folder}/CMakeLists.txt",
                   f"# What it is for.\ntreeline_library({name}\n"
                   f"  SRCS {name}.cc\n  {keyword} {deps})\n")

    def test_accepts_links_along_the_arrows(self):
        self.library("common/base", "base", "absl::status")
        self.library("common/geometry", "geometry", "base Eigen3::Eigen")
        self.assertEqual(self.findings(), [])

    def test_finds_a_link_against_the_arrows(self):
        self.library("common/base", "base", "geometry", "PRIVATE_DEPS")
        self.library("common/geometry", "geometry")
        self.assert_one_finding("base links geometry",
                                "common/base may not know common/geometry")

    def test_finds_training_far_down_the_chain_of_the_server(self):
        self.library("server/core/training", "training")
        self.library("server/core/dataset", "dataset", "training")
        self.library("server/app", "treeline-server", "dataset")
        findings = "\n".join(self.findings())
        self.assertIn("treeline-server ends up with training of "
                      "server/core/training", findings)

    def test_sees_links_added_later(self):
        self.library("common/geometry", "geometry")
        self.write("common/base/base.cc")
        self.write("common/base/CMakeLists.txt",
                   "treeline_library(base SRCS base.cc)\n"
                   "target_link_libraries(base PRIVATE geometry)\n")
        self.assert_one_finding("base links geometry")

    def test_finds_a_source_that_no_target_builds(self):
        self.library("common/base", "base")
        self.write("common/base/forgotten.cc")
        self.assert_one_finding("common/base/forgotten.cc", "no CMakeLists")

    def test_a_name_in_a_comment_builds_nothing(self):
        self.write("common/base/a.cc")
        self.write("common/base/CMakeLists.txt", "# a.cc\n")
        self.assert_one_finding("common/base/a.cc")

    def test_accepts_a_source_named_from_the_root_or_from_above(self):
        self.write("tests/fuzz/main.cc")
        self.write("cmake/Fuzz.cmake",
                   "add_executable(a ${CMAKE_SOURCE_DIR}/tests/fuzz/main.cc)")
        self.write("tests/golden/a_test.cc")
        self.write("tests/CMakeLists.txt",
                   "treeline_test(a_test SRCS golden/a_test.cc)")
        self.assertEqual(self.findings(), [])


if __name__ == "__main__":
    unittest.main()
