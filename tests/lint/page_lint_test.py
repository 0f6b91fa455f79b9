"""The lints of file sizes and of Markdown links find what they should."""

import contextlib
import io
import unittest
from unittest import mock

import doc_link_lint
import size_lint
from fixture_tree import FilesOfTest, FixtureTreeTest  # noqa: F401


class SizeLintTest(FixtureTreeTest):

    def run_lint(self):
        output = io.StringIO()
        with mock.patch("sys.argv", ["size_lint.py", self.root]):
            with contextlib.redirect_stdout(output):
                return size_lint.main(), output.getvalue()

    def test_accepts_500_lines_in_silence(self):
        self.write("a.cc", "x\n" * 500)
        status, output = self.run_lint()
        self.assertEqual(status, 0)
        self.assertNotIn("warning", output)

    def test_warns_from_501_lines(self):
        self.write("a.cc", "x\n" * 501)
        status, output = self.run_lint()
        self.assertEqual(status, 0)
        self.assertIn("warning: a.cc has 501 lines", output)

    def test_fails_from_600_lines(self):
        self.write("a.h", "x\n" * 600)
        status, output = self.run_lint()
        self.assertEqual(status, 1)
        self.assertIn("a.h: 600 lines", output)


class DocLinkLintTest(FixtureTreeTest):

    def findings(self):
        return doc_link_lint.findings_in(self.root)[0]

    def test_accepts_links_that_lead_somewhere(self):
        self.write("docs/a.md", "# One: two\n[b](adr/b.md#a-b) ![p](../p.svg) "
                   "[here](#one-two) [web](https://example.org/x)\n")
        self.write("docs/adr/b.md", "## A b\n")
        self.write("p.svg")
        self.assertEqual(self.findings(), [])

    def test_finds_a_missing_file(self):
        self.write("docs/a.md", "Text.\nSee [b](b.md).\n")
        self.assertEqual(self.findings(),
                         ["docs/a.md:2: b.md: there is no such file"])

    def test_finds_a_missing_heading(self):
        self.write("a.md", "# One\n[two](#two)\n")
        self.assertEqual(self.findings(),
                         ["a.md:2: #two: there is no such heading"])

    def test_finds_a_link_out_of_the_repository(self):
        self.write("a.md", "[x](../design/style.md)\n")
        self.assertIn("leads out of the repository", self.findings()[0])

    def test_finds_a_missing_picture_in_html(self):
        self.write("a.md", '<img alt="x" src="docs/x.svg">\n')
        self.assertIn("docs/x.svg", self.findings()[0])

    def test_finds_a_page_that_only_a_comment_mentions(self):
        self.write("a.cc", "// See docs/b.md.\n// https://x.org/docs/c.md\n")
        self.assertEqual(self.findings(),
                         ["a.cc:1: docs/b.md: there is no such page"])
        self.write("docs/b.md")
        self.assertEqual(self.findings(), [])

    def test_finds_a_source_that_a_page_names_and_nobody_has(self):
        self.write("a/x.cc")
        self.write("b.md", "`a/x.cc`, `x.cc`, `a/y.cc`, `z.h`\n")
        self.write("docs/research/c.md", "`a/gone.cc`\n")
        self.assertEqual(self.findings(),
                         ["b.md:1: a/y.cc: there is no such source",
                          "b.md:1: z.h: there is no such source"])

    def test_leaves_code_alone(self):
        self.write("a.md", "`[x](y.md)`\n```\n[x](z.md)\n```\n")
        self.assertEqual(self.findings(), [])


if __name__ == "__main__":
    unittest.main()
