"""The little of C++ that declarations of settings and metrics are made of."""

import ast
import re

STRING = r'"(?:[^"\\\n]|\\.)*"'
STRINGS = rf"{STRING}(?:\s*{STRING})*"

SKIPPED_FOLDERS = {".git", ".cache", "build", "out", "node_modules", "tests"}


def sources_below(root, folders, suffixes):
    """Source files in these folders of the tree, sorted, without tests."""
    found = []
    for folder in folders:
        for path in (root / folder).rglob("*"):
            parts = set(path.relative_to(root).parts)
            if (path.suffix in suffixes and not parts & SKIPPED_FOLDERS
                    and not path.stem.endswith("_test")):
                found.append(path)
    return sorted(found)


def the_file(root, folders, name):
    """The one file of this name; folders may move."""
    found = [path for folder in folders
             for path in (root / folder).rglob(name)
             if not set(path.relative_to(root).parts) & SKIPPED_FOLDERS]
    if len(found) != 1:
        raise SystemExit(f"{name}: expected one in {folders}, found {found}")
    return found[0]


def without_comments(text):
    """The text with // comments blanked; strings stay as they are."""
    pattern = re.compile(rf"({STRING})|//[^\n]*")
    return pattern.sub(lambda m: m[1] or "", text)


def text_of(literals):
    """What adjacent string literals say together."""
    return "".join(ast.literal_eval(part)
                   for part in re.findall(STRING, literals))


def braced(text, begin):
    """What stands between the brace at `begin` and its partner."""
    depth = 0
    for match in re.compile(rf"{STRING}|[{{}}]").finditer(text, begin):
        if match[0] == "{":
            depth += 1
        elif match[0] == "}":
            depth -= 1
            if depth == 0:
                return text[begin + 1:match.start()]
    raise SystemExit("a brace without its partner")


def designated(body, name):
    """The text of `.name = ...` in an initialiser, or None."""
    match = re.search(rf"\.{name}\s*=\s*", body)
    if not match:
        return None
    rest = body[match.end():]
    if rest.startswith('"'):
        return text_of(re.match(STRINGS, rest)[0])
    if rest.startswith("{"):
        return braced(rest, 0)
    return re.match(r"[^,}]*", rest)[0].strip()


def as_cell(text):
    """Text as a cell of a Markdown table."""
    return " ".join(text.split()).replace("|", r"\|")
