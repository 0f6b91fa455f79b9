"""The page of metrics, from where they are declared."""

import re

from cpp_source import (STRINGS, as_cell, braced, sources_below, text_of,
                        without_comments)

INTRODUCTION = """\
# Metrics

What `GET /metrics` answers, in Prometheus' text format 0.0.4 (of the server also
in OpenMetrics 1.0, with exemplars): of
`treeline-server` on `http_listen`, of `treeline-agent run` beside the
operator's page. [operations.md](operations.md#metrics) says how the server's
are counted and has alerts to begin with.
"""

DECLARED = re.compile(
    r'(?P<how>\w+)\(\s*"(?P<name>(?:treeline|process)_[a-z_]+)",\s*'
    rf"(?P<help>{STRINGS})\s*,\s*")


def declared_in(text):
    """(name, type, labels, help) of each metric in a source file."""
    text = without_comments(text)
    matches = list(DECLARED.finditer(text))
    for match, after in zip(matches, matches[1:] + [None]):
        rest = text[match.end():after.start() if after else len(text)]
        if match["how"].startswith("Add"):
            kind = match["how"][len("Add"):].lower()
            labels = braced(rest, 0) if rest.startswith("{") else ""
        else:
            told = re.match(r"(?:metrics::)?MetricType::k(\w+)", rest)
            kind = told[1].lower() if told else "gauge"
            # A sample of no labels ends what belongs to the family.
            labels = " ".join(re.findall(r'\{("\w+"),', rest.split("\n}\n")[0]))
        names = dict.fromkeys(re.findall(r'"(\w+)"', labels))
        yield match["name"], kind, list(names), text_of(match["help"])


def rows(root, folders):
    found = {}
    for path in sources_below(root, folders, {".cc"}):
        for metric in declared_in(path.read_text(encoding="utf-8")):
            found[metric[0]] = metric
    text = "| metric | type | labels | |\n|---|---|---|---|\n"
    for name, kind, labels, said in sorted(found.values()):
        text += (f"| `{name}` | {kind} | {', '.join(labels)} | "
                 f"{as_cell(said).rstrip('.')} |\n")
    return text


def page(root):
    return (INTRODUCTION + "\n## treeline-server\n\n" + rows(root, ["server"])
            + "\n## treeline-agent\n\n" + rows(root, ["nav_agent"]))
