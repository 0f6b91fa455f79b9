"""Pages of settings, from the tables that declare them."""

import re

from cpp_source import (STRINGS, as_cell, braced, designated, the_file,
                        text_of, without_comments)

SERVER_INTRODUCTION = """\
# Settings of treeline-server

Each setting has one name for file, environment and flag:
`max_message_mib: 64` in a YAML file, `TREELINE_SERVER_MAX_MESSAGE_MIB=64`,
`--max-message-mib 64`. A flag overrides the environment, the environment
overrides the file, the file overrides the default.
[operations.md](operations.md) explains how they are read.

"Live": a change takes effect on SIGHUP; other settings need a restart.
"""

AGENT_INTRODUCTION = """\
# Settings of treeline-agent run

Each setting has one name for file (`--config FILE`), environment and flag:
`max_forward_mps: 0.5` in a YAML file, `TREELINE_AGENT_MAX_FORWARD_MPS=0.5`,
`--max-forward-mps 0.5`. A flag overrides the environment, the environment
overrides the file, the file overrides the default. [agent.md](agent.md)
explains the program.
"""

ZEROS = {"std::string": '""', "bool": "false",
         "std::vector<std::string>": "none"}


def fields_of(header, struct):
    """{field: (default, heading)} of the struct, in its order."""
    begin = re.search(rf"struct {struct} {{", header).end() - 1
    fields, heading, is_heading = {}, "", False
    for line in braced(header, begin).splitlines():
        line = line.strip()
        comment = re.match(r"// (?:-+ )?(.*?)(?: -+)?$", line)
        if comment and not is_heading:
            heading = comment[1].split(";")[0].strip(". ")
            heading = heading[:1].upper() + heading[1:]
        is_heading = bool(comment)
        field = re.match(r"([\w:<>]+) (\w+)(?: = (.*))?;$", line)
        if field:
            fields[field[2]] = (field[3] or ZEROS.get(field[1], "0"), heading)
    return fields


def number(text):
    shift = re.match(r"(\d+) << (\d+)$", text)
    value = int(shift[1]) << int(shift[2]) if shift else float(text)
    return f"{value:.0f}" if value == int(value) else f"{value:g}"


def values_of(body, kind_default):
    choices = designated(body, "choices")
    if choices:
        return ", ".join(f"`{text_of(choice)}`"
                         for choice in re.findall(STRINGS, choices))
    low, high = designated(body, "min"), designated(body, "max")
    if low is not None and high is not None:
        return f"{number(low)} to {number(high)}"
    if kind_default in ("true", "false"):
        return "true, false"
    return as_cell(designated(body, "value_name") or "")


def table(root, folder, name, struct):
    """The rows, under the headings of the struct's comments."""
    header = the_file(root, [folder], f"{name}.h").read_text(encoding="utf-8")
    source = without_comments(
        the_file(root, [folder], f"{name}.cc").read_text(encoding="utf-8"))
    fields = fields_of(header, struct)
    rows = {}
    for match in re.finditer(r"\.Add\(\s*&(?:\w+::)*(\w+),\s*(?={)", source):
        body = braced(source, match.end())
        default, heading = fields[match[1]]
        if designated(body, "required") == "true" and default == '""':
            default = "required"
        rows.setdefault(heading, []).append((
            f"`{designated(body, 'name')}`", as_cell(default),
            values_of(body, default),
            "yes" if designated(body, "live") == "true" else "",
            as_cell(designated(body, "help"))))
    return rows


def page(root, introduction, folder, name, struct, has_live):
    text = introduction
    for heading, rows in table(root, folder, name, struct).items():
        live = "live | " if has_live else ""
        text += f"\n## {heading}\n\n| setting | default | values | {live}|\n"
        text += "|---|---|---|---|---|\n" if has_live else "|---|---|---|---|\n"
        for row in rows:
            cells = row if has_live else row[:3] + row[4:]
            text += "| " + " | ".join(cells) + " |\n"
    return text


def server_page(root):
    return page(root, SERVER_INTRODUCTION, "server", "server_config",
                "ServerConfig", True)


def agent_page(root):
    return page(root, AGENT_INTRODUCTION, "nav_agent", "agent_config",
                "AgentConfig", False)
