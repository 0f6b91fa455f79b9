"""Reads every #include line against the table in include_rules.txt.

Usage: include_lint.py [TREE]. Exits with 1 and names file, line and reason
for each include that the table does not allow.
"""

import pathlib
import re
import sys

import lint_common
import rules as rules_module

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
SUFFIXES = (".h", ".cc")


def objection_to(rules, root, path, quote, header):
    """Why `path` must not include `header`, or None."""
    top = header.split("/", 1)[0]
    ours = any(folder.split("/", 1)[0] == top for folder in rules.allowed)
    if not ours or "/" not in header:
        beside = pathlib.Path(root, path).parent / header
        if quote == '"' and beside.exists():
            return "spell it from the root of the repository"
        return rules.header_objection(path, header)
    if quote == "<":
        return 'our own headers stand in "", not in <>'
    if reason := rules.header_objection(path, header):
        return reason
    generated = header.endswith(".pb.h")
    if not generated and not pathlib.Path(root, header).is_file():
        return "there is no such file"
    folder, other = rules.folder_of(path), rules.folder_of(header)
    if other is None:
        return f"{header} lies in no folder of include_rules.txt"
    if not rules.may_know(folder, other):
        return f"{folder} may not know {other}"
    return None


def findings_in(root, rules):
    """(findings, number of files looked at)."""
    findings = []
    paths = lint_common.files_of(root, SUFFIXES)
    for path in paths:
        if rules.folder_of(path) is None:
            findings.append(f"{path}: its folder has no line in "
                            "include_rules.txt")
            continue
        lines = lint_common.read(root, path).splitlines()
        for number, line in enumerate(lines, 1):
            match = INCLUDE.match(line)
            if not match:
                continue
            reason = objection_to(rules, root, path, match[1], match[2])
            if reason:
                findings.append(f"{path}:{number}: {match[2]}: {reason}")
    return findings, len(paths)


def main():
    root = lint_common.root_from_arguments()
    findings, checked = findings_in(root, rules_module.load())
    return lint_common.report("include lint", findings, checked)


if __name__ == "__main__":
    sys.exit(main())
