"""Writes a Debian changelog of one entry, of CHANGELOG.md's newest section.

Usage: make_changelog.py SOURCE VERSION SECONDS

SECONDS since 1970 are the entry's date.
"""

import email.utils
import pathlib
import re
import sys
import textwrap

ROOT = pathlib.Path(__file__).resolve().parents[3]
MAINTAINER = "The Treeline authors <treeline@treeline.invalid>"


def newest_points(text):
    """Its points, each one line of text without Markdown's links."""
    sections = re.split(r"^## ", text, flags=re.M)
    if len(sections) < 2:
        raise ValueError("CHANGELOG.md has no section")
    points = re.findall(r"^\* (.*(?:\n  .*)*)", sections[1], flags=re.M)
    return [re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", " ".join(point.split()))
            for point in points] or ["No changes that users would notice."]


def changelog(source, version, seconds, text):
    points = "".join(
        textwrap.fill(point, 78, initial_indent="  * ",
                      subsequent_indent="    ", break_long_words=False,
                      break_on_hyphens=False) + "\n"
        for point in newest_points(text))
    date = email.utils.formatdate(seconds)
    return (f"{source} ({version}) bookworm; urgency=medium\n\n{points}\n"
            f" -- {MAINTAINER}  {date.replace('-0000', '+0000')}\n")


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    source, version, seconds = sys.argv[1:]
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    sys.stdout.write(changelog(source, version, int(seconds), text))


if __name__ == "__main__":
    main()
