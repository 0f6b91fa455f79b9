"""What `docker build` gets to see of a folder: its .dockerignore, applied."""

import pathlib
import re
import shutil


def pattern_regex(pattern):
    """A pattern as Docker reads it: like Go's filepath.Match, ** for folders.

    https://docs.docker.com/build/concepts/context/#dockerignore-files
    """
    regex = ""
    at = 0
    while at < len(pattern):
        if pattern.startswith("**/", at):
            regex += "(?:.*/)?"
            at += 3
        elif pattern.startswith("**", at):
            regex += ".*"
            at += 2
        elif pattern[at] == "*":
            regex += "[^/]*"
            at += 1
        elif pattern[at] == "?":
            regex += "[^/]"
            at += 1
        elif pattern[at] == "[" and "]" in pattern[at + 1:]:
            end = pattern.index("]", at + 1) + 1
            regex += pattern[at:end]
            at = end
        else:
            regex += re.escape(pattern[at])
            at += 1
    return re.compile(regex + r"\Z")


class DockerIgnore:
    """The rules of a .dockerignore; the last one that matches decides."""

    def __init__(self, text):
        self.rules = []
        for line in text.splitlines():
            line = line.strip()
            if not line or line.startswith("#"):
                continue
            excludes = not line.startswith("!")
            pattern = line if excludes else line[1:].strip()
            self.rules.append((pattern_regex(pattern.strip("/")), excludes))

    def excludes(self, path):
        """Whether `path`, relative to the context, is left out.

        A rule that matches a folder holds for all that is in it.
        """
        path = pathlib.PurePosixPath(path)
        names = [str(path)] + [str(p) for p in path.parents if str(p) != "."]
        excluded = False
        for regex, excludes in self.rules:
            if any(regex.match(name) for name in names):
                excluded = excludes
        return excluded


def copy_context(source, target, ignore):
    """Copies the files of `source` that `ignore` leaves.

    Files that no rule takes back are not looked at: no rule of ours starts
    with ** or names a path below a folder that is left out.
    """
    for entry in sorted(source.iterdir()):
        if ignore.excludes(entry.name):
            continue
        if entry.is_file():
            shutil.copy2(entry, target / entry.name)
            continue
        for path in sorted(entry.rglob("*")):
            name = path.relative_to(source)
            if not path.is_file() or ignore.excludes(name):
                continue
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(path, target / name)
