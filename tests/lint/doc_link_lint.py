"""Checks that relative links in the Markdown files lead somewhere.

Usage: doc_link_lint.py [TREE]. A link to a file must name one that exists in
the tree; a link with #heading must name a heading of that page, as GitHub
spells its anchor.
"""

import os
import pathlib
import re
import sys

import lint_common

LINK = re.compile(r"!?\[[^\]]*\]\(\s*<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\s*\)")
HTML_SOURCE = re.compile(r"<(?:img|a)\b[^>]*?\b(?:src|href)=\"([^\"]+)\"")
FENCE = re.compile(r"^ {0,3}(```|~~~)")
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
    return findings, len(pages)


def main():
    findings, checked = findings_in(lint_common.root_from_arguments())
    return lint_common.report("doc link lint", findings, checked)


if __name__ == "__main__":
    sys.exit(main())
