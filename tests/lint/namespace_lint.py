"""Every folder has a namespace of its own: treeline::<last part of its path>.

Usage: namespace_lint.py [TREE]. Folders whose last part is another folder's,
or a library's namespace, have a `namespace` line in include_rules.txt. A file
opens no other namespace of ours, but for declaring what another folder defines.
Tests of several folders (tests/) are in treeline itself.
"""

import collections
import os
import re
import sys

import lint_common
import rules as rules_module

OPENING = re.compile(r"^namespace treeline(?:::(\w+))?(?:::\w+)* \{",
                     re.MULTILINE)
# Names of another folder that are declared and not defined.
DECLARATIONS = re.compile(r"^namespace treeline::\w+ \{\n"
                          r"(?:(?:class|struct) \w+;\n)+\}[^\n]*\n",
                          re.MULTILINE)
FREE = ("tests", "proto")


def namespace_of(rules, folder):
    return rules.namespaces.get(folder, folder.rsplit("/", 1)[-1])


def is_free(path):
    return any(lint_common.is_below(path, folder) for folder in FREE)


def wrong_namespaces(root, rules, paths):
    for path in paths:
        wanted = namespace_of(rules, os.path.dirname(path))
        text = DECLARATIONS.sub(lambda found: "\n" * found[0].count("\n"),
                                lint_common.read(root, path))
        for match in OPENING.finditer(text):
            if match[1] != wanted:
                line = text[:match.start()].count("\n")
                yield (f"{path}:{line + 1}: opens {match[0][10:-2]}, but its "
                       f"folder's is treeline::{wanted}")


def shared_namespaces(rules, paths):
    folders = collections.defaultdict(set)
    for folder in {os.path.dirname(path) for path in paths}:
        folders[namespace_of(rules, folder)].add(folder)
    for name, some in sorted(folders.items()):
        if len(some) > 1:
            yield (f"treeline::{name} is of {', '.join(sorted(some))}: give all "
                   "but one a `namespace` line in include_rules.txt")


def idle_lines(rules, paths):
    folders = {os.path.dirname(path) for path in paths}
    for folder in sorted(set(rules.namespaces) - folders):
        yield f"include_rules.txt: namespace {folder}: no sources there"


def findings_in(root, rules):
    """(findings, number of files looked at)."""
    paths = [path for path in lint_common.files_of(root, (".h", ".cc"))
             if not is_free(path)]
    findings = list(wrong_namespaces(root, rules, paths))
    findings += shared_namespaces(rules, paths)
    findings += idle_lines(rules, paths)
    return findings, len(paths)


def main():
    root = lint_common.root_from_arguments()
    findings, checked = findings_in(root, rules_module.load())
    return lint_common.report("namespace lint", findings, checked)


if __name__ == "__main__":
    sys.exit(main())
