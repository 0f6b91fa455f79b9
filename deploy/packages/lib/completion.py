"""Completion of a program's command line in bash and zsh, of its helps."""


def quoted(text):
    return "'" + text.replace("'", "'\\''") + "'"


def path_of(one):
    """" synth record": the words behind the program, each after a blank."""
    return "".join(f" {word}" for word in one.words[1:])


def patterns(paths):
    return " | ".join(quoted(path) for path in paths)


def value_cases(helps, places, words, nothing):
    """Lines of `case`: what completes an option's value.

    places, nothing: what a shell does for files, and for values that cannot be
    guessed; words: the same for a list of words.
    """
    by_action = {}
    for one in helps:
        for option in one.options:
            if not option.value:
                continue
            if option.choices:
                action = words(option.choices)
            else:
                action = places if option.is_place else nothing
            by_action.setdefault(action, []).extend(
                f"{path_of(one)} {name}" for name in option.names)
    return "".join(f"    {patterns(paths)})\n      {action}\n      return\n"
                   "      ;;\n" for action, paths in by_action.items())


def word_cases(helps, words):
    """Lines of `case`: commands and options of each command."""
    text = ""
    for one in helps:
        candidates = [command.term for command in one.commands]
        candidates += [name for option in one.options for name in option.names
                       if name.startswith("--")]
        text += (f"    {quoted(path_of(one))})\n      {words(candidates)}\n"
                 "      ;;\n")
    return text


def command_case(helps):
    paths = [path_of(one) for one in helps if len(one.words) > 1]
    if not paths:
        return "      *) ;;\n"
    return f"      {patterns(paths)}) at=\"$at $word\" ;;\n"


def bash_completion(helps):
    """A file of /usr/share/bash-completion/completions."""
    program = helps[0].words[0]
    function = "_" + program.replace("-", "_")

    def words(candidates):
        return (f"mapfile -t COMPREPLY < <(compgen -W "
                f"{quoted(' '.join(candidates))} -- \"$current\")")
    return f"""\
# Completion of {program} in bash, made of its --help.
# shellcheck shell=bash
{function}() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}}
  local at='' word
  COMPREPLY=()
  # bash makes three words of --option=value.
  if [[ "$before" == '=' ]]; then before=${{COMP_WORDS[COMP_CWORD - 2]}}; fi
  if [[ "$current" == '=' ]]; then current=''; fi
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    case "$at $word" in
{command_case(helps)}    esac
  done
  case "$at $before" in
{value_cases(helps, "compopt -o default", words, ":")}  esac
  case "$at" in
{word_cases(helps, words)}  esac
  # No option: perhaps a file.
  if [[ "$current" != -* ]]; then compopt -o default 2>/dev/null; fi
}}
complete -F {function} {program}
"""


def zsh_completion(helps):
    """A file of /usr/share/zsh/vendor-completions."""
    program = helps[0].words[0]

    def words(candidates):
        return "compadd -- " + " ".join(quoted(one) for one in candidates)
    return f"""\
#compdef {program}
# Completion of {program} in zsh, made of its --help.
local at='' word
for word in "${{(@)words[2,CURRENT-1]}}"; do
  case "$at $word" in
{command_case(helps)}  esac
done
case "$at ${{words[CURRENT-1]}}" in
{value_cases(helps, "_files", words, ":")}esac
case "$at" in
{word_cases(helps, words)}esac
if [[ "$PREFIX" != -* ]]; then _files; fi
"""
