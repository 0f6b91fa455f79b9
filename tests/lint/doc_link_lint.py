"""Checks that relative links in the Markdown files lead somewhere.

Usage: doc_link_lint.py [TREE]. A link to a file must name one that exists in
the tree; a link with #heading must name a heading of that page, as GitHub
spells its anchor. A path below docs/ that a comment, a message or a text
mentions must exist, too, and so must the sources that a page names in `code`
(docs/research and docs/adr speak of their own time).
"""

import os
import pathlib
import re
import sys

import lint_common

LINK = re.compile(r"!?\[[^\]]*\]\(\s*<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\s*\)")
HTML_SOURCE = re.compile(r"<(?:img|a)\b[^>]*?\b(?:src|href)=\"([^\"]+)\"")
FENCE = re.compile(r"^ {0,3}(```|~~~)")
MENTION = re.compile(r"(?<![\w./-])docs/[\w./-]*\.(?:md|yaml|svg|png|jpg)\b")
MENTIONING = (".md", ".h", ".cc", ".proto", ".py", ".js", ".mjs", ".ts", ".sh",
              ".yaml", ".yml", ".cmake", ".txt", "Dockerfile")
SOURCE = re.compile(r"`([\w./-]+\.(?:cc|h|proto|py))`")
OF_THEIR_TIME = ("docs/research/", "docs/adr/", "CHANGELOG.md")
HEADING = re.compile(r"^ {0,3}#{1,6}\s+(.*?)\s*#*\s*$")


def prose_lines(text):
    """(number, line) of what is neither fenced nor inline code."""
    fenced = False
    for number, line in enumerate(text.splitlines(), 1):
        if FENCE.match(line):
            fenced = not fenced
        elif not fenced:
            yield number, line


def anchor_of(heading):
    """The anchor that GitHub gives a heading."""
    heading = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
    return re.sub(r"[^\w\- ]", "", heading).replace(" ", "-")


def anchors_in(text):
    return {anchor_of(match[1]) for _, line in prose_lines(text)
            if (match := HEADING.match(line))}


def objection_to(root, page, target):
    """Why the link `target` on `page` is broken, or None."""
    if re.match(r"[a-z][a-z0-9+.-]*:", target):
        return None
    path, _, anchor = target.partition("#")
    if path:
        where = os.path.normpath(os.path.join(os.path.dirname(page), path))
        if where.startswith(".."):
            return "leads out of the repository"
        if not pathlib.Path(root, where).exists():
            return "there is no such file"
    else:
        where = page
    if anchor and where.endswith(".md"):
        if anchor not in anchors_in(lint_common.read(root, where)):
            return "there is no such heading"
    return None


def mentions_without_page(root):
    """A finding for each path below docs/ that does not exist."""
    findings = []
    for path in lint_common.files_of(root, MENTIONING):
        if path.endswith("_test.py"):  # their fixtures name pages
            continue
        lines = lint_common.read(root, path).splitlines()
        for number, line in enumerate(lines, 1):
            for page in MENTION.findall(line):
                if not pathlib.Path(root, page).exists():
                    findings.append(f"{path}:{number}: {page}: there is no "
                                    "such page")
    return findings


def missing_sources(root, pages):
    """A finding for each source that a page names and that does not exist."""
    paths = set(lint_common.files_of(root, (".cc", ".h", ".proto", ".py")))
    names = {os.path.basename(path) for path in paths}
    findings = []
    for page in pages:
        if page.startswith(OF_THEIR_TIME):
            continue
        for number, line in prose_lines(lint_common.read(root, page)):
            for source in SOURCE.findall(line):
                known = paths if "/" in source else names
                if source not in known:
                    findings.append(f"{page}:{number}: {source}: there is no "
                                    "such source")
    return findings


def findings_in(root):
    """(findings, number of pages looked at)."""
    findings = []
    pages = lint_common.files_of(root, (".md",))
    for page in pages:
        for number, line in prose_lines(lint_common.read(root, page)):
            line = re.sub(r"`[^`]*`", lambda m: "x" * len(m[0]), line)
            for target in LINK.findall(line) + HTML_SOURCE.findall(line):
                reason = objection_to(root, page, target)
                if reason:
                    findings.append(f"{page}:{number}: {target}: {reason}")
    findings += mentions_without_page(root) + missing_sources(root, pages)
    return findings, len(pages)


def main():
    findings, checked = findings_in(lint_common.root_from_arguments())
    return lint_common.report("doc link lint", findings, checked)


if __name__ == "__main__":
    sys.exit(main())
