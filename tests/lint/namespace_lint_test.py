"""The namespace lint finds what it is there to find."""

import unittest

import namespace_lint
import rules
from fixture_tree import FixtureTreeTest

TABLE = rules.Rules("common/base:\nclient/base: common/base\n"
                    "namespace client/base: client_base\n")


class NamespaceLintTest(FixtureTreeTest):

    def findings(self, table=TABLE):
        return namespace_lint.findings_in(self.root, table)[0]

    def setUp(self):
        super().setUp()
        self.write("client/base/a.h", "namespace treeline::client_base {\n}\n")

    def test_accepts_the_folders_own(self):
        self.write("common/base/a.h", "namespace treeline::base {\n}\n")
        self.write("common/base/a.cc",
                   "namespace treeline::base::HWY_NAMESPACE {\n}\n")
        self.assertEqual(self.findings(), [])

    def test_finds_another_one(self):
        self.write("common/base/a.h", "//\nnamespace treeline::image {\n}\n")
        self.assertIn("common/base/a.h:2", self.findings()[0])
        self.assertIn("treeline::base", self.findings()[0])

    def test_accepts_a_declaration_of_anothers_class(self):
        self.write("common/base/a.h", "namespace treeline::image {\nclass A;\n"
                   "}  // namespace treeline::image\n\n"
                   "namespace treeline::base {\n}\n")
        self.assertEqual(self.findings(), [])

    def test_finds_none(self):
        self.write("common/base/a.h", "namespace treeline {\n}\n")
        self.assertEqual(len(self.findings()), 1)

    def test_finds_two_folders_in_one(self):
        self.write("common/base/a.h", "namespace treeline::base {\n}\n")
        self.write("client/base/a.h", "namespace treeline::base {\n}\n")
        table = rules.Rules("common/base:\nclient/base: common/base\n")
        self.assertIn("client/base, common/base", self.findings(table)[0])

    def test_finds_a_line_without_a_folder(self):
        table = rules.Rules("common/base:\nnamespace common/gone: x\n"
                            "namespace client/base: client_base\n")
        self.assertIn("common/gone", self.findings(table)[0])

    def test_tests_of_several_folders_are_free(self):
        self.write("tests/pipeline/a_test.cc", "namespace treeline {\n}\n")
        self.assertEqual(self.findings(), [])


if __name__ == "__main__":
    unittest.main()
