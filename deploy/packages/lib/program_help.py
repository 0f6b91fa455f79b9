"""What a program's --help says, taken apart; its subcommands' too."""

import dataclasses
import re
import subprocess

# What CLI11 prints behind an option's names and its value's.
REMARKS = re.compile(r"\s+(REQUIRED\b|Needs:|Excludes:|Env:|\.\.\.).*")
CHOICES_IN_TYPE = re.compile(r"\{([^{}]+)\}")
# "[debug, info, off; default info; SIGHUP]" at the end of a setting's text.
CHOICES_IN_TEXT = re.compile(r"\[((?:[\w-]+, )+[\w-]+)(?:;[^\]]*)?\]$")
PLACES = re.compile(
    r"FILE|DIR|PATH|FOLDER|BUNDLE|MODEL|CAPTURE|RECORDING|DATASET|LOG\b")


class HelpError(Exception):
    """A program's --help is not what this can read."""


@dataclasses.dataclass(frozen=True)
class Item:
    """A line of a list: an option, a positional or a subcommand."""
    term: str
    text: str

    @property
    def names(self):
        """Of an option: ["-h", "--help"]."""
        return self.term.split(" ", 1)[0].split(",")

    @property
    def value(self):
        """What its value is called; empty if it takes none."""
        rest = REMARKS.sub("", self.term + " ").strip()
        return rest.split(" ", 1)[1].strip() if " " in rest else ""

    @property
    def choices(self):
        """The values that it takes, where it says which."""
        found = CHOICES_IN_TYPE.search(self.value)
        if found:
            return [choice.strip() for choice in found[1].split(",")]
        found = CHOICES_IN_TEXT.search(self.text)
        return found[1].split(", ") if found and self.value else []

    @property
    def is_place(self):
        """Whether a file or folder can be its value."""
        return bool(PLACES.search(self.value))


@dataclasses.dataclass(frozen=True)
class Help:
    """The help of a program or of one of its subcommands."""
    words: tuple        # ("treeline", "synth", "record")
    description: str
    usage: str          # "[OPTIONS] CAPTURE"
    lists: tuple        # ((heading, (Item, ...)), ...), without subcommands
    commands: tuple     # (Item, ...)
    footer: str

    @property
    def page(self):
        """The name of its manual page: "treeline-synth-record"."""
        return "-".join(self.words)

    @property
    def options(self):
        return [item for _, items in self.lists for item in items
                if item.term.startswith("-")]


def read_items(lines):
    items = []
    for line in lines:
        start = re.match(r"  (\S.*?)(?:\s{2,}(\S.*))?$", line)
        if start:
            items.append([start[1], start[2] or ""])
        elif items:
            items[-1][1] = f"{items[-1][1]} {line.strip()}".strip()
    return tuple(Item(*item) for item in items)


def is_list(heading, lines):
    """Whether these lines are a list of CLI11's, and not of a footer."""
    if not re.match(r"\S.*:$", heading) or not lines:
        return False
    if heading in ("Positionals:", "Options:", "Subcommands:"):
        return True
    return all(line.startswith("  -") for line in lines
               if re.match(r"  \S", line))


def read_help(words, text):
    """The Help of what `PROGRAM COMMAND... --help` printed."""
    head, separator, rest = text.partition("Usage: ")
    if not separator:
        raise HelpError(f"{' '.join(words)} --help has no line `Usage:`")
    usage, _, rest = rest.partition("\n")
    usage = re.sub(rf"^(\S*/)?{re.escape(' '.join(words))}\s*", "", usage)
    lines = rest.split("\n")
    lists, commands, at = [], (), 0
    while at < len(lines):
        if not lines[at].strip():
            at += 1
            continue
        end = at + 1
        while end < len(lines) and lines[end].startswith(" "):
            end += 1
        if not is_list(lines[at], lines[at + 1:end]):
            break
        items = read_items(lines[at + 1:end])
        if lines[at] == "Subcommands:":
            commands = items
        else:
            lists.append((lines[at].rstrip(":"), items))
        at = end
    footer = "\n".join(lines[at:]).strip("\n")
    return Help(tuple(words), " ".join(head.split()), usage.strip(),
                tuple(lists), commands, footer)


def ask(program, arguments):
    done = subprocess.run([str(program), *arguments], capture_output=True,
                          text=True, check=False, stdin=subprocess.DEVNULL)
    if done.returncode != 0:
        raise HelpError(f"{program} {' '.join(arguments)} ended with status "
                        f"{done.returncode}: {done.stderr[-500:]}")
    return done.stdout


def helps_of(program, words=None):
    """The Help of `program`, a path, and of all its subcommands, depth first.

    Raises HelpError.
    """
    words = words or [program.name]
    own = read_help(words, ask(program, [*words[1:], "--help"]))
    if not own.options:
        raise HelpError(f"{' '.join(words)} --help lists no options")
    found = [own]
    for command in own.commands:
        found += helps_of(program, [*words, command.term])
    return found


def version_of(program):
    """"0.1.0" of `treeline-server 0.1.0`."""
    said = ask(program, ["--version"]).split()
    if len(said) != 2 or said[0] != program.name:
        raise HelpError(f"{program} --version says {' '.join(said)!r}; "
                        f"expected {program.name} and a version")
    return said[1]
