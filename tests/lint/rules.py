"""Reads include_rules.txt: who may know whom."""

import fnmatch
import pathlib
import re

from lint_common import is_below

DEFAULT_RULES = pathlib.Path(__file__).with_name("include_rules.txt")


class RulesError(Exception):
    """The table itself is wrong."""


class Rules:
    """The table of include_rules.txt; see there for what its lines mean."""

    def __init__(self, text):
        self.allowed = {}  # folder -> set of folders, or {"*"}
        self.only = []  # (pattern, folders)
        self.not_in_headers = []  # (pattern, folders)
        self.never = []  # (folder, dependants)
        self.namespaces = {}  # folder -> its namespace below treeline
        for number, line in enumerate(text.splitlines(), 1):
            line = line.split("#", 1)[0].strip()
            if line:
                self._read(line, number)
        self._check_names()
        self._reach = {folder: self._reachable(folder, ())
                       for folder in self.allowed}

    def _read(self, line, number):
        if match := re.fullmatch(r"no (\S+) in headers but of:(.*)", line):
            self.not_in_headers.append((match[1], match[2].split()))
        elif match := re.fullmatch(r"only (\S+):(.*)", line):
            self.only.append((match[1], match[2].split()))
        elif match := re.fullmatch(r"namespace (\S+): (\w+)", line):
            self.namespaces[match[1]] = match[2]
        elif match := re.fullmatch(r"never (\S+) <- (.+)", line):
            self.never.append((match[1], match[2].split()))
        elif match := re.fullmatch(r"(\S+):(.*)", line):
            if match[1] in self.allowed:
                raise RulesError(f"line {number}: {match[1]} stands twice")
            self.allowed[match[1]] = set(match[2].split())
        else:
            raise RulesError(f"line {number}: not a rule: {line}")

    def _check_names(self):
        for folder, others in self.allowed.items():
            for other in others - {"*"} - set(self.allowed):
                raise RulesError(f"{folder}: {other} has no line of its own")

    def _reachable(self, folder, path):
        if folder in path:
            raise RulesError("a circle: " + " -> ".join(path + (folder,)))
        reached = {folder}
        for other in self.allowed[folder]:
            reached |= ({"*"} if other == "*"
                        else self._reachable(other, path + (folder,)))
        return reached

    def folder_of(self, path):
        """The folder of the table that path lies in, or None."""
        holders = [folder for folder in self.allowed
                   if is_below(path, folder)]
        return max(holders, key=len, default=None)

    def may_know(self, folder, other):
        reached = self._reach[folder]
        return "*" in reached or other in reached

    def header_objection(self, path, header):
        """Why path may not include this third-party header, or None."""
        for pattern, folders in self.only:
            if (fnmatch.fnmatchcase(header, pattern)
                    and not any(is_below(path, f) for f in folders)):
                return "only " + ", ".join(folders) + " may include it"
        if path.endswith(".h"):
            for pattern, folders in self.not_in_headers:
                if (fnmatch.fnmatchcase(header, pattern)
                        and not any(is_below(path, f) for f in folders)):
                    return "not in a header: include it in the .cc file"
        return None


def load(path=DEFAULT_RULES):
    return Rules(pathlib.Path(path).read_text(encoding="utf-8"))
