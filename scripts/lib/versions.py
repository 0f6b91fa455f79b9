"""Says whether everything that states Treeline's version agrees.

Usage: versions.py [--root TREE] [--set VERSION]

The version is that of project() in CMakeLists.txt: programs and Debian packages
take it from there. Files of other tools state it again; this names those that
state another one, exit status 1. --set writes VERSION into all of them.
"""

import argparse
import pathlib
import re
import sys

SOURCE = ("CMakeLists.txt", r"(?m)^project\(treeline VERSION (\S+) ")
# Each match of a pattern must state the version.
PLACES = (
    SOURCE,
    ("Dockerfile", r'org\.opencontainers\.image\.version="([^"]*)"'),
    ("client/python/pyproject.toml", r'(?m)^version = "([^"]*)"$'),
    ("client/python/debian/changelog", r"\Atreeline-client \(([^)]*)\)"),
    ("client/typescript/package.json", r'(?m)^  "version": "([^"]*)"'),
    ("client/typescript/package-lock.json",
     r'"name": "@treeline/client",\s+"version": "([^"]*)"'),
    ("client/java/pom.xml", r"<version>([^<]*)</version>\s+<packaging>"),
    ("docs/how-to/use-from-java-and-kotlin.md",
     r"treeline-client-(\d+\.\d+\.\d+)\.jar"),
    ("docs/how-to/use-from-python.md", r"treeline_(\d[^_]*)_all\.deb"),
    ("docs/how-to/use-from-python.md", r"treeline-(\d[^-]*)-py3"),
    ("docs/how-to/use-from-typescript.md",
     r"treeline-client-(\d+\.\d+\.\d+)\.tgz"),
)
VERSION = r"\d+\.\d+\.\d+"


def stated(root, path, pattern):
    text = (root / path).read_text(encoding="utf-8")
    return [match[1] for match in re.finditer(pattern, text)]


def version_of(root):
    """"0.1.0"; raises ValueError."""
    found = stated(root, *SOURCE)
    if len(found) != 1 or not re.fullmatch(VERSION, found[0]):
        raise ValueError(f"CMakeLists.txt has no version: {found}")
    return found[0]


def disagreements(root):
    """A sentence for each place that states another version, or none."""
    version = version_of(root)
    for path, pattern in PLACES:
        found = stated(root, path, pattern)
        if not found:
            yield f"{path}: no version where one is expected: {pattern}"
        for other in found:
            if other != version:
                yield (f"{path}: {other}, but CMakeLists.txt says {version}; "
                       "run scripts/release --set-version")


def write(root, version):
    for path, pattern in PLACES:
        text = (root / path).read_text(encoding="utf-8")
        parts, end = [], 0
        for match in re.finditer(pattern, text):
            parts += [text[end:match.start(1)], version]
            end = match.end(1)
        (root / path).write_text("".join([*parts, text[end:]]),
                                 encoding="utf-8")


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--root", type=pathlib.Path,
                           default=pathlib.Path(__file__).parents[2])
    arguments.add_argument("--set", metavar="VERSION")
    given = arguments.parse_args()
    try:
        if given.set is not None:
            if not re.fullmatch(VERSION, given.set):
                sys.exit(f"versions: {given.set} is not like 1.2.3")
            write(given.root, given.set)
        found = list(disagreements(given.root))
    except (OSError, ValueError) as error:
        sys.exit(f"versions: {error}")
    for sentence in found:
        print(sentence)
    if not found:
        print(version_of(given.root))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
