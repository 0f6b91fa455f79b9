"""The own header lint finds what it is there to find."""

import unittest

import own_header_lint
from fixture_tree import FixtureTreeTest

OWN = '#include "common/base/a.h"\n\n#include <string>\n'


class OwnHeaderLintTest(FixtureTreeTest):

    def findings(self, exceptions=()):
        return own_header_lint.findings_in(self.root, exceptions)[0]

    def test_accepts_a_source_that_begins_with_its_header(self):
        self.write("common/base/a.h")
        self.write("common/base/a.cc", "// Why.\n" + OWN)
        self.assertEqual(self.findings(), [])

    def test_finds_a_source_without_a_header(self):
        self.write("common/base/b.h")
        self.write("common/base/a.cc", '#include "common/base/b.h"\n')
        self.assertEqual(len(self.findings()), 1)
        self.assertIn("common/base/a.cc: has no header", self.findings()[0])

    def test_a_header_of_another_folder_is_not_its_own(self):
        self.write("client/base/a.h")
        self.write("common/base/a.cc", '#include "client/base/a.h"\n')
        self.assertIn("common/base/a.h", self.findings()[0])

    def test_finds_a_header_that_is_not_included_first(self):
        self.write("common/base/a.h")
        self.write("common/base/a.cc",
                   "#include <string>\n" + OWN)
        self.assertIn("first", self.findings()[0])

    def test_finds_a_header_that_is_not_included(self):
        self.write("common/base/a.h")
        self.write("common/base/a.cc", "int a = 0;\n")
        self.assertIn("first", self.findings()[0])

    def test_programs_need_none(self):
        self.write("common/base/a.cc",
                   "int main(int argc, char** argv) {}\n")
        self.assertEqual(self.findings(), [])

    def test_who_only_names_main_is_no_program(self):
        self.write("common/base/a.cc", "// Called by int main().\n")
        self.assertEqual(len(self.findings()), 1)

    def test_tests_benchmarks_and_fuzzers_need_none(self):
        for path in ("common/base/a_test.cc", "common/base/a_benchmark.cc",
                     "common/base/a_fuzz.cc", "tests/robot/fixture.cc"):
            self.write(path)
        self.assertEqual(self.findings(), [])

    def test_exceptions_are_passed_over(self):
        self.write("common/base/a.cc")
        self.assertEqual(self.findings({"common/base/a.cc": "why"}), [])

    def test_finds_exceptions_that_are_none(self):
        self.write("common/base/a.h")
        self.write("common/base/a.cc", OWN)
        self.assertEqual(len(self.findings({"common/base/a.cc": "why"})), 1)
        self.assertEqual(len(self.findings({"common/base/gone.cc": "",
                                            "common/base/a.cc": ""})), 2)


if __name__ == "__main__":
    unittest.main()
