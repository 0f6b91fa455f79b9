"""The page of the wire contract, from proto/treeline/v1."""

import re

from cpp_source import as_cell

INTRODUCTION = """\
# The wire contract

Every service, message and enum of [proto/treeline/v1](../../proto/treeline/v1).
[service.md](service.md) explains the relocalization service,
[http.md](http.md) its form over HTTP, [agent.md](agent.md) the robot's
services, [frames.md](../frames.md) the frames.
"""

SCALARS = {"double", "float", "int32", "int64", "uint32", "uint64", "sint32",
           "sint64", "bool", "string", "bytes", "fixed32", "fixed64"}


def prose(comment):
    """Comment lines as Markdown: what is indented is a block of its own."""
    text, inside = [], False
    for line in comment:
        indented = line.startswith("  ") or (inside and not line)
        if indented != inside:
            text += ["```", ""] if inside else ["", "```"]
            inside = indented
        text.append(line if inside else line.replace("<", r"\<"))
    if inside:
        text.append("```")
    joined = re.sub(r"\n\n\n+", "\n\n", "\n".join(text).strip("\n"))
    return re.sub(r"\n+```\n(?=\n|$)", "\n```\n", joined).strip("\n")


def sentence(comment):
    return as_cell(" ".join(comment)).replace("<", r"\<")


def statements(lines):
    """(comment lines, statement) of a file; a statement ends with ; { or }."""
    comment, code = [], ""
    for line in lines:
        stripped = line.strip()
        if stripped.startswith("//") and not code:
            comment.append(stripped[2:].removeprefix(" "))
            continue
        if not stripped:
            if not code:
                comment = []
            continue
        code = f"{code} {stripped.split(' //')[0]}".strip()
        if code[-1] in ";{}":
            yield comment, code
            comment, code = [], ""


def link(name):
    if name in SCALARS or "." in name:
        return f"`{name}`"
    return f"[{name}](#{name.lower()})"


def field_row(comment, code, group):
    match = re.match(r"(repeated |optional )?(map<[^>]+>|[\w.]+) (\w+) = "
                     r"(\d+)", code)
    if not match:
        return None
    kind = link(match[2]) if "<" not in match[2] else f"`{match[2]}`"
    kind = (match[1] or "") + kind + (f", one of `{group}`" if group else "")
    return f"| `{match[3]}` | {kind} | {match[4]} | {sentence(comment)} |"


def file_text(path):
    out, scope, table, group = [], [], False, ""
    lines = path.read_text(encoding="utf-8").splitlines()
    head = []
    for line in lines:
        if not line.startswith("//"):
            break
        head.append(line[2:].removeprefix(" "))
    out += [f"## {path.name}", "", prose(head)]
    for comment, code in statements(lines[len(head):]):
        opened = re.match(r"(service|message|enum|oneof) (\w+) {", code)
        if opened:
            kind, name = opened[1], opened[2]
            scope.append(kind)
            if kind == "oneof":
                group = name
                continue
            table = False
            out += ["", f"### {name}", ""]
            out += [f"*{kind.capitalize()}.* {prose(comment)}".rstrip()]
            if code.endswith("}"):
                scope.pop()
        elif code.startswith("}"):
            scope.pop()
            group = ""
        elif code.startswith("rpc ") and code[-1] in ";}{":
            call = re.match(r"rpc (\w+)\((stream )?(\w+)\)\s*returns "
                            r"\((stream )?(\w+)\)", code)
            out += ["", f"**{call[1]}**: {call[2] or ''}{link(call[3])} to "
                        f"{call[4] or ''}{link(call[5])}. {prose(comment)}"]
            if code.endswith("{"):
                scope.append("rpc")
        elif scope and scope[-1] == "enum":
            value = re.match(r"(\w+) = (\d+)", code)
            if value:
                if not table:
                    out += ["", "| value | number | |", "|---|---|---|"]
                    table = True
                out += [f"| `{value[1]}` | {value[2]} | "
                        f"{sentence(comment)} |"]
        elif scope and scope[-1] in ("message", "oneof"):
            row = field_row(comment, code, group)
            if row:
                if not table:
                    out += ["", "| field | type | number | |",
                            "|---|---|---|---|"]
                    table = True
                out += [row]
    return "\n".join(out) + "\n"


def page(root):
    paths = sorted((root / "proto/treeline/v1").glob("*.proto"))
    return INTRODUCTION + "".join("\n" + file_text(path) for path in paths)
