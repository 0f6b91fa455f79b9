"""Writes a package's configuration file: every setting, its default, and what
it does, from the tables that docs/reference is made of.

Usage: make_config.py server|agent

The file goes to standard output. Its settings are comments, but for those that
the package needs.
"""

import pathlib
import sys
import textwrap

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "scripts" / "lib" / "reference"))
import settings  # noqa: E402

WIDTH = 78

SERVER_HEAD = """\
# Settings of the service treeline-server.
#
# A line that begins with `#name: value` shows a setting that is not set, with
# its default or an example. Remove the # to set it. Then
#
#   systemctl reload treeline-server    takes what is marked as live
#   systemctl restart treeline-server   takes everything
#
# Before that, this shows what would be in force, or the line that is wrong:
#
#   treeline-server --config /etc/treeline/server.yaml --print-config
#
# The service runs as the user treeline. Keys and certificates must be readable
# for it, and should be for nobody else:
#
#   install -o root -g treeline -m 0640 key.pem /etc/treeline/tls.key
"""

AGENT_HEAD = """\
# Settings of the service treeline-agent.
#
# A line that begins with `#name: value` shows a setting that is not set, with
# its default or an example. Remove the # to set it. The service needs a robot
# (hardware, ros2 or simulate) and, to know where it is, a map. Then
#
#   systemctl enable --now treeline-agent
#
# Before that, this shows what would be in force, or the line that is wrong:
#
#   treeline-agent run --config /etc/treeline/agent.yaml --print-config
#
# The service runs as the user treeline-agent and may write below
# /var/lib/treeline-agent. Maps, and a token for the server, must be readable
# for it:
#
#   install -o root -g treeline-agent -m 0640 token /etc/treeline/agent.token
"""

# Program: the place of its table, the head, what is set, and examples.
PROGRAMS = {
    "server": (("server", "server_config", "ServerConfig"), SERVER_HEAD,
               {"models": "/var/lib/treeline/models", "poll_s": "5"},
               {"cache": "/var/cache/treeline",
                "record": "/var/lib/treeline/failed-queries",
                "tls_cert": "/etc/treeline/tls.crt",
                "tls_key": "/etc/treeline/tls.key",
                "auth_keys": "/etc/treeline/keys"}),
    "agent": (("nav_agent", "agent_config", "AgentConfig"), AGENT_HEAD, {},
              {"hardware": "/etc/treeline/robot.yaml",
               "map": "/var/lib/treeline-agent/map",
               "record": "/var/lib/treeline-agent/robot.tlog",
               "token_file": "/etc/treeline/agent.token"}),
}


def plain(cell):
    """A cell of a Markdown table as text."""
    return cell.replace("\\|", "|").replace("`", "")


def value_line(name, default, given, examples):
    if name in given:
        return f"{name}: {given[name]}"
    if name in examples:
        return f"#{name}: {examples[name]}"
    return f"#{name}: {'[]' if default == 'none' else default}"


def config_text(root, program):
    """The configuration file of `program`, "server" or "agent"."""
    place, head, given, examples = PROGRAMS[program]
    parts = [head]
    known = set()
    for heading, rows in settings.table(root, *place).items():
        parts.append(f"# ---- {heading}\n")
        for name, default, values, live, text in rows:
            name, default = plain(name), plain(default)
            known.add(name)
            note = "; ".join(filter(None, [
                plain(values), live and "live",
                "required" if default == "required" else ""]))
            told = plain(text) + (f" [{note}]" if note else "")
            wrapped = textwrap.wrap(told, WIDTH, break_on_hyphens=False)
            parts.append("".join(f"# {line}\n" for line in wrapped) +
                         value_line(name, default, given, examples) + "\n")
    unknown = (given.keys() | examples.keys()) - known
    if unknown:
        raise ValueError(f"no such settings: {', '.join(sorted(unknown))}")
    return "\n".join(parts)


def main():
    if sys.argv[1:] not in (["server"], ["agent"]):
        sys.exit(__doc__)
    sys.stdout.write(config_text(ROOT, sys.argv[1]))


if __name__ == "__main__":
    main()
