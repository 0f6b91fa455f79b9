"""Reads the targets of every CMakeLists.txt against include_rules.txt.

Usage: link_lint.py [TREE]. A target may link what its folder may include, no
target may reach what a `never` line forbids however far down the chain, and
every source belongs to a target.
"""

import os
import re
import sys

import lint_common
import rules as rules_module

CALL = re.compile(r"\b(treeline_\w+|add_library|add_executable|"
                  r"target_link_libraries|target_sources)\s*\(([^()]*)\)")
KEYWORDS = {"SRCS", "DEPS", "PRIVATE_DEPS", "LABELS", "LABEL", "SEEDS",
            "SCRIPT", "ARGS", "PUBLIC", "PRIVATE", "INTERFACE", "STATIC",
            "OBJECT"}
DEFINING = {"treeline_library", "treeline_binary", "treeline_test",
            "treeline_benchmark", "treeline_fuzzer", "add_library",
            "add_executable"}


class Target:
    """A target, the folder that defines it and the names it links."""

    def __init__(self, name, folder):
        self.name = name
        self.folder = folder
        self.links = set()


def sections_of(arguments):
    """Maps each keyword of a call to the words after it; "" to the first."""
    sections = {"": []}
    keyword = ""
    for word in arguments:
        if word in KEYWORDS:
            keyword = word
            sections.setdefault(keyword, [])
        else:
            sections[keyword].append(word)
    return sections


def targets_in(root):
    """(targets by name, the words of the CMake files by folder)."""
    targets, words = {}, {}
    paths = lint_common.files_of(root, (".cmake",), ("CMakeLists.txt",))
    for path in paths:
        text = re.sub(r"#.*", "", lint_common.read(root, path))
        folder = os.path.dirname(path)
        words.setdefault(folder, set()).update(
            re.findall(r"[^\s()\"]+", text))
        if path.endswith(".cmake"):
            continue
        for call, inside in CALL.findall(text):
            sections = sections_of(inside.split())
            if not sections[""]:
                continue
            name = sections[""][0]
            if call in DEFINING:
                targets.setdefault(name, Target(name, folder))
            if name in targets:
                for keyword in ("DEPS", "PRIVATE_DEPS", "PUBLIC", "PRIVATE",
                                "INTERFACE"):
                    targets[name].links |= set(sections.get(keyword, []))
    return targets, words


def reached_from(targets, name):
    """Names of our targets that `name` links, directly or not."""
    reached, todo = set(), [name]
    while todo:
        for link in targets[todo.pop()].links:
            if link in targets and link not in reached:
                reached.add(link)
                todo.append(link)
    return reached


def forbidden_links(rules, targets):
    for target in targets.values():
        folder = rules.folder_of(target.folder)
        for link in sorted(target.links & set(targets)):
            other = rules.folder_of(targets[link].folder)
            if folder and other and not rules.may_know(folder, other):
                yield (f"{target.folder}/CMakeLists.txt: {target.name} links "
                       f"{link}, but {folder} may not know {other}")


def forbidden_chains(rules, targets):
    for banned, dependants in rules.never:
        for target in targets.values():
            if not any(lint_common.is_below(target.folder, folder)
                       for folder in dependants):
                continue
            for link in sorted(reached_from(targets, target.name)):
                if lint_common.is_below(targets[link].folder, banned):
                    yield (f"{target.folder}/CMakeLists.txt: {target.name} "
                           f"ends up with {link} of {banned}")


def orphans(root, words):
    """Sources that no CMake file names, relative to itself or to the root."""
    named = {os.path.normpath(os.path.join(folder, word))
             for folder, some in words.items() for word in some}
    named |= {word.removeprefix("${CMAKE_SOURCE_DIR}/")
              for some in words.values() for word in some}
    for path in lint_common.files_of(root, (".cc",)):
        if path not in named:
            yield f"{path}: no CMakeLists.txt names it"


def findings_in(root, rules):
    """(findings, number of targets looked at)."""
    targets, words = targets_in(root)
    findings = list(forbidden_links(rules, targets))
    findings += forbidden_chains(rules, targets)
    findings += orphans(root, words)
    return findings, len(targets)


def main():
    root = lint_common.root_from_arguments()
    findings, checked = findings_in(root, rules_module.load())
    return lint_common.report("link lint", findings, checked)


if __name__ == "__main__":
    sys.exit(main())
