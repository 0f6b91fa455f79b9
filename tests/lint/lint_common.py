"""What the lints share: the files of a tree, and how findings are printed."""

import os
import pathlib
import sys

SKIPPED_FOLDERS = {".git", ".cache", "build", "out", "node_modules",
                   "__pycache__"}


def files_of(root, suffixes=(), names=()):
    """Paths below root, relative, sorted, that end or are named so.

    Folders that hold no sources of ours (build/, out/, .git/) are left out,
    wherever they are.
    """
    found = []
    for folder, subfolders, files in os.walk(root):
        subfolders[:] = [name for name in subfolders
                         if name not in SKIPPED_FOLDERS]
        for name in files:
            if name.endswith(tuple(suffixes)) or name in names:
                path = pathlib.Path(folder, name).relative_to(root)
                found.append(path.as_posix())
    return sorted(found)


def read(root, path):
    return pathlib.Path(root, path).read_text(encoding="utf-8",
                                              errors="replace")


def is_below(path, folder):
    """Whether path is the folder or lies in it."""
    return path == folder or path.startswith(folder + "/")


def report(title, findings, checked):
    """Prints the findings, returns the exit status."""
    for finding in findings:
        print(finding)
    verdict = f"{len(findings)} findings" if findings else "clean"
    print(f"{title}: {checked} checked, {verdict}")
    return 1 if findings else 0


def root_from_arguments():
    """The tree to look at: the first argument, or this repository."""
    if len(sys.argv) > 1:
        return sys.argv[1]
    return str(pathlib.Path(__file__).resolve().parents[2])
