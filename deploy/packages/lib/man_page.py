"""A manual page of a program's help."""

import re
import time


def escaped(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    # At the start of a line these would be requests.
    return re.sub(r"^(?=[.'])", r"\\&", text, flags=re.M)


def paragraph(text):
    return ".PP\n" + escaped(text) + "\n"


def verbatim(lines):
    return (".PP\n.RS 4\n.nf\n" +
            "\n".join(escaped(line) for line in lines) + "\n.fi\n.RE\n")


def entry(item):
    """An option, a positional or a command, and what it is."""
    names, _, rest = item.term.partition(" ")
    term = f"\\fB{escaped(names)}\\fR"
    if rest:
        term += f" \\fI{escaped(rest)}\\fR"
    return f".TP\n{term}\n{escaped(item.text) or chr(92) + '&'}\n"


def dedented(lines):
    indent = min(len(line) - len(line.lstrip()) for line in lines if line)
    return [line[indent:] for line in lines]


def block_of_footer(block):
    """Paragraphs and what is set in; "Examples:" is a heading."""
    lines = block.split("\n")
    text = ""
    if lines[0] == "Examples:":
        return ".SH EXAMPLES\n" + verbatim(dedented(lines[1:]))
    if lines[0].startswith("Exit codes: "):
        return (".SH \"EXIT STATUS\"\n" +
                escaped(" ".join(lines).removeprefix("Exit codes: ")) + "\n")
    plain = []
    for line in [*lines, None]:
        if line is not None and not line.startswith(" "):
            plain.append(line)
            continue
        if plain:
            text += paragraph("\n".join(plain))
            plain = []
        if line is not None:
            text += verbatim([line.strip()])
    # Neighbouring lines that are set in belong together.
    return text.replace("\n.fi\n.RE\n.PP\n.RS 4\n.nf\n", "\n")


def footer_text(footer):
    blocks = [block for block in re.split(r"\n\s*\n", footer) if block.strip()]
    # Sections come last: what follows one would seem to belong to it.
    ranks = {"Examples:": 1, "Exit codes:": 2}

    def rank(block):
        return max(place for start, place in [("", 0), *ranks.items()]
                   if block.startswith(start))
    return "".join(block_of_footer(block)
                   for block in sorted(blocks, key=rank))


def see_also(one, everything):
    """Its program or the command above it, and what is below it."""
    near = [other.page for other in everything
            if other.words == one.words[:-1] or
            other.words[:-1] == one.words]
    return ", ".join(f"\\fB{escaped(page)}\\fR(1)" for page in near)


def man_page(one, everything, version, seconds):
    """The page, in roff, of `one` of `everything` that a program's helps are.

    seconds: the page's date, since 1970.
    """
    date = time.strftime("%Y-%m-%d", time.gmtime(seconds))
    purpose = re.split(r"[:.](?:\s|$)", one.description)[0]
    parts = [
        ".\\\" Made of --help.\n",
        f".TH {escaped(one.page.upper())} 1 {date} \"Treeline {version}\" "
        "\"Treeline\"\n",
        # Names of settings must not be broken.
        ".nh\n.ad l\n",
        f".SH NAME\n{escaped(one.page)} \\- "
        f"{escaped(purpose[:1].lower() + purpose[1:])}\n",
        f".SH SYNOPSIS\n\\fB{escaped(' '.join(one.words))}\\fR "
        f"{escaped(one.usage)}\n",
        f".SH DESCRIPTION\n{escaped(one.description)}\n"]
    for heading, items in one.lists:
        parts.append(f".SH \"{escaped(heading.upper())}\"\n")
        parts += [entry(item) for item in items]
    if one.commands:
        parts.append(".SH COMMANDS\n")
        parts += [entry(item) for item in one.commands]
    if one.footer:
        text = footer_text(one.footer)
        if not text.startswith(".SH"):
            text = ".SH NOTES\n" + text
        parts.append(text)
    if also := see_also(one, everything):
        parts.append(f".SH \"SEE ALSO\"\n{also}\n")
    return "".join(parts)
