"""Keeps each source beside the header that says what it defines.

Usage: own_header_lint.py [TREE]. Every FOLDER/NAME.cc must have a
FOLDER/NAME.h and include it first, so that the header proves to be complete.
Programs (a source with `int main(`), tests, benchmarks and fuzzers need none,
nor do the sources of EXCEPTIONS.
"""

import re
import sys

import lint_common

# Each with its reason. A line for what needs none is itself a finding.
EXCEPTIONS = {}

FREE_SUFFIXES = ("_test.cc", "_benchmark.cc", "_fuzz.cc")
FREE_FOLDERS = ("tests",)
MAIN = re.compile(r"^int main\(", re.MULTILINE)
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*[<"]([^">]+)[">]',
                     re.MULTILINE)


def is_free(path, text):
    """Whether a source needs no header, whatever the exceptions."""
    return (path.endswith(FREE_SUFFIXES) or
            any(lint_common.is_below(path, folder)
                for folder in FREE_FOLDERS) or
            MAIN.search(text) is not None)


def problem_of(path, text, headers):
    """What is wrong with a source that needs a header; "" if nothing is."""
    header = path[:-len(".cc")] + ".h"
    if header not in headers:
        return f"has no header of its own, {header}"
    first = INCLUDE.search(text)
    if first is None or first.group(1) != header:
        return f"must include its own header first, {header}"
    return ""


def findings_in(root, exceptions):
    """The findings, and the number of sources looked at."""
    sources = lint_common.files_of(root, (".cc",))
    headers = set(lint_common.files_of(root, (".h",)))
    findings = []
    unused = set(exceptions)
    for path in sources:
        text = lint_common.read(root, path)
        problem = "" if is_free(path, text) else problem_of(path, text,
                                                            headers)
        if problem and path in exceptions:
            unused.discard(path)
        elif problem:
            findings.append(f"{path}: {problem}")
    findings += [f"{path}: is an exception without need"
                 for path in sorted(unused)]
    return findings, len(sources)


def main():
    root = lint_common.root_from_arguments()
    findings, checked = findings_in(root, EXCEPTIONS)
    return lint_common.report("own header lint", findings, checked)


if __name__ == "__main__":
    sys.exit(main())
