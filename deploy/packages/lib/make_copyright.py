"""Writes a package's copyright file: ours, and that of what its pages hold.

Usage: make_copyright.py BASE [INSTALLED WORK]...

BASE is deploy/packages/debian/copyright. INSTALLED is where a page is installed
(usr/share/treeline/page/*), and WORK the folder that it was built in, with
package-lock.json and node_modules. Named are all packages that the page needs
when it runs, whether or not the bundler has kept anything of them.
"""

import json
import pathlib
import re
import sys

# Texts that Debian keeps.
COMMON = {"Apache-2.0": "Apache-2.0"}
LICENCE_FILES = re.compile(r"(?i)^(licen[cs]e|copying)([.-].*)?$")
COPYRIGHT = re.compile(r"(?i)^\W*(copyright\s.*\d{4}.*|copyright\s+\(c\).*)$")


class CopyrightError(Exception):
    """A package does not say what its licence is."""


def heads_of_sources(folder):
    """The comments that its sources begin with; where no file of its own has
    the licence, it stands there."""
    heads = {}
    for file in sorted(folder.rglob("*.js")):
        head = re.match(r"(?://.*\n)+", file.read_text(errors="replace"))
        if head and "Copyright" in head[0]:
            heads[re.sub(r"(?m)^// ?", "", head[0])] = True
    return "\n".join(heads)


def runtime_packages(work):
    """(name, version, licence, text) of what the page needs when it runs."""
    lock = json.loads((work / "package-lock.json").read_text())
    for place, package in sorted(lock["packages"].items()):
        if not place or package.get("dev") or package.get("link"):
            continue
        name = place.rpartition("node_modules/")[2]
        folder = work / place
        if not folder.is_dir():
            if package.get("optional"):
                continue
            raise CopyrightError(f"{folder} is missing; build the page again")
        files = sorted(file for file in folder.iterdir()
                       if LICENCE_FILES.match(file.name) and file.is_file())
        licence = package.get("license") or json.loads(
            (folder / "package.json").read_text()).get("license")
        if not isinstance(licence, str):
            raise CopyrightError(f"{name} names no licence")
        text = (files[0].read_text(errors="replace") if files else
                heads_of_sources(folder))
        licence = licence.strip("()").replace(" AND ", " and ")
        if not text and licence not in COMMON:
            raise CopyrightError(f"{name} has no text of its licence")
        yield name, package["version"], licence, text


def holders_of(name, text):
    """Its lines of copyright; without any, its authors."""
    lines = [" ".join(line.split()) for line in text.splitlines()
             if COPYRIGHT.match(line)]
    # The Apache licence's own example is no holder.
    lines = [line for line in lines if "[yyyy]" not in line]
    return lines or [f"The authors of {name}"]


def body_of(text):
    """A licence's text without its holders."""
    lines = [line.strip() for line in text.splitlines()
             if not COPYRIGHT.match(line)]
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines)).strip()


def indented(lines):
    return "".join(f" {line}\n" if line else " .\n" for line in lines)


def page_paragraph(installed, packages):
    holders = dict.fromkeys(holder for name, _, _, text in packages
                            for holder in holders_of(name, text))
    licences = dict.fromkeys(
        one for licence in ["Apache-2.0", *(p[2] for p in packages)]
        for one in licence.split(" and "))
    return (f"\nFiles: {installed}\n"
            "Copyright: 2026 The Treeline authors\n" + indented(holders) +
            f"License: {' and '.join(licences)}\n"
            "Comment:\n Parts of these packages of npm are in it:\n" +
            indented(f"{name} {version} ({licence})"
                     for name, version, licence, _ in packages))


def licence_paragraphs(packages):
    """Each text once; where two of one name differ, both."""
    texts = {}
    for name, _, licence, text in packages:
        names = [one for one in licence.split(" and ") if one not in COMMON]
        if not names:
            continue
        licence = " and ".join(names)
        body = body_of(text)
        seen = texts.setdefault(licence, {})
        seen.setdefault(" ".join(body.lower().split()), (name, body))
    paragraphs = ""
    for licence, seen in texts.items():
        lines = []
        for name, body in seen.values():
            lines += [f"[{name}]", "", *body.split("\n"), ""]
        paragraphs += f"\nLicense: {licence}\n" + indented(lines[:-1])
    return paragraphs


def copyright_text(base, pages):
    """pages: (INSTALLED, WORK) of each page."""
    text, everything = base, []
    for installed, work in pages:
        packages = list(runtime_packages(work))
        everything += packages
        ours, mark, licences = text.partition("\nLicense: Apache-2.0\n On ")
        text = ours + page_paragraph(installed, packages) + mark + licences
    return text + licence_paragraphs(everything)


def main():
    base, *pages = map(pathlib.Path, sys.argv[1:])
    if len(pages) % 2:
        sys.exit(__doc__)
    try:
        sys.stdout.write(copyright_text(
            base.read_text(), list(zip(pages[::2], pages[1::2]))))
    except (CopyrightError, OSError, KeyError) as error:
        sys.exit(f"make_copyright: {error}")


if __name__ == "__main__":
    main()
