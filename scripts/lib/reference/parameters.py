"""The page of the constants of server and client, from the tables that hold them.

The robot's page, parameters.md, is printed by `treeline-agent run
--print-parameters`.
"""

import re

from cpp_source import (STRING, as_cell, braced, designated, sources_below,
                        text_of, without_comments)

INTRODUCTION = """\
# Parameters of server, training and client

Constants that no setting changes, as the sources declare them (`Parameter` in
[common/base/parameter.h](../../common/base/parameter.h)). Those of the robot
are in [parameters.md](parameters.md). "Origin" says where a value comes from: `geometry` of the robot, its sensors or
a grid; `physics`, a law or a limit of the hardware; `measured` noise or time;
`tuned` by trial.
"""

DECLARED = re.compile(r"\bParameter<[^>]+>\s+\w+\s*=?\s*(?={)")
NAMES = ("name", "value", "unit", "origin", "why")


def fields_of(body):
    """The five fields, by name or in their order."""
    if designated(body, "name") is not None:
        return {name: designated(body, name) or "" for name in NAMES}
    parts = re.findall(rf"\s*((?:{STRING}|[^,\"])+)\s*(?:,|$)", body)
    texts = [text_of(part) if '"' in part else part.strip() for part in parts]
    return dict(zip(NAMES, texts)) if len(texts) == len(NAMES) else None


def rows_of(path):
    text = without_comments(path.read_text(encoding="utf-8"))
    for match in DECLARED.finditer(text):
        fields = fields_of(braced(text, match.end()))
        if fields is None:
            continue
        yield (f"`{fields['name']}`", as_cell(fields["value"]),
               as_cell(fields["unit"]),
               fields["origin"].rpartition("::k")[2].lower(),
               as_cell(fields["why"]))


def page(root):
    text = INTRODUCTION
    folders = {}
    for path in sources_below(root, ["client", "common", "server"], {".h", ".cc"}):
        folder = path.parent.relative_to(root).as_posix()
        folders.setdefault(folder, []).extend(rows_of(path))
    for folder, rows in sorted(folders.items()):
        if not rows:
            continue
        text += (f"\n## {folder}\n\n| parameter | value | unit | origin | |\n"
                 "|---|---|---|---|---|\n")
        text += "".join("| " + " | ".join(row) + " |\n" for row in rows)
    return text
