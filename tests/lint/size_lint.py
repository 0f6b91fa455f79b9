"""Keeps files readable in one sitting.

Usage: size_lint.py [TREE]. A source of 600 lines or more fails; one over 500
is named without failing.
"""

import sys

import lint_common

FAIL_FROM = 600
WARN_OVER = 500
SUFFIXES = (".h", ".cc", ".py", ".proto", ".cmake", ".ts", ".js", ".sh",
            ".java")


def sizes_of(root):
    paths = lint_common.files_of(root, SUFFIXES, names=("CMakeLists.txt",))
    return {path: len(lint_common.read(root, path).splitlines())
            for path in paths}


def main():
    sizes = sizes_of(lint_common.root_from_arguments())
    for path, lines in sizes.items():
        if WARN_OVER < lines < FAIL_FROM:
            print(f"warning: {path} has {lines} lines")
    findings = [f"{path}: {lines} lines; split it below {FAIL_FROM}"
                for path, lines in sizes.items() if lines >= FAIL_FROM]
    return lint_common.report("size lint", findings, len(sizes))


if __name__ == "__main__":
    sys.exit(main())
