#!/usr/bin/env python3
"""Measures Treeline beside its yardsticks, and names what became slower.

Exit codes: 0 measured; 1 something could not be measured, or with
--fail-if-worse something became worse; 2 wrong usage; 130 interrupted.
"""

import argparse
import datetime
import json
import pathlib
import sys
import tempfile

import history
import machine
from figures import changes
from measurements import GROUPS, Bench, measure


def parse_arguments(arguments=None):
    parser = argparse.ArgumentParser(
        prog="scripts/bench", description=__doc__.split("\n\n")[0],
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Groups:\n" + "\n".join(
            f"  {name:9} {what}" for name, (what, _) in GROUPS.items()))
    parser.add_argument("--programs", required=True,
                        help="folder of the programs that were built")
    parser.add_argument("--preset", required=True, help="what they were built as")
    parser.add_argument("--recording", required=True, metavar="DIR",
                        help="7-Scenes recording with train.txt and test.txt")
    parser.add_argument("--poses", metavar="FILE",
                        help="poses in place of the recording's own")
    parser.add_argument("--only", action="append", metavar="GROUP",
                        choices=list(GROUPS),
                        help="only this group; may be repeated")
    parser.add_argument("--quick", action="store_true",
                        help="each figure once and shorter: less exact")
    parser.add_argument("--json", metavar="FILE", help="write this run there")
    parser.add_argument("--history", metavar="FILE",
                        help="runs to compare with, and to add this one to")
    parser.add_argument("--fail-if-worse", action="store_true",
                        help="end with 1 if a figure became worse")
    return parser.parse_args(arguments)


def formatted(value):
    return f"{value:.3g}" if abs(value) < 100 else f"{value:.0f}"


def table(figures, compared):
    """Lines: figure, value, its yardstick's, change since the run before."""
    by_name = {figure.name: figure for figure in figures}
    since = {change.figure.name: change for change in compared}
    width = max(len(name) for name in by_name)
    yield f"{'':{width}}  {'now':>10}      {'yardstick':>9}  {'before':>9}"
    for figure in figures:
        stick = by_name.get(figure.yardstick)
        against = (f"{figure.value / stick.value:8.2f}x"
                   if stick and stick.value else "")
        change = since.get(figure.name)
        before = formatted(change.before.value) if change else ""
        word = ""
        if change and change.is_certain:
            word = (f"  {abs(change.worse):.0%} "
                    f"{'WORSE' if change.worse > 0 else 'better'}")
        yield (f"{figure.name:{width}}  {formatted(figure.value):>10} "
               f"{figure.unit:4} {against:>9}  {before:>9}{word}")


def run_of(arguments, names, figures, failed, facts):
    return {
        "at": datetime.datetime.now(datetime.timezone.utc).isoformat(
            timespec="seconds"),
        "machine": facts,
        "workload": {"recording": pathlib.Path(arguments.recording).name,
                     "quick": arguments.quick},
        "groups": names,
        "failed": failed,
        "figures": [figure.as_json() for figure in figures],
    }


def main():
    arguments = parse_arguments()
    root = pathlib.Path(__file__).resolve().parents[2]
    names = arguments.only or list(GROUPS)
    facts = machine.facts(root, arguments.preset)
    try:
        earlier = history.read(arguments.history) if arguments.history else []
    except history.HistoryError as error:
        print(f"scripts/bench: {error}", file=sys.stderr)
        return 2
    if facts["load_before"] > 0.5:
        print(f"Something else computes (load {facts['load_before']}): figures "
              "are worse than the machine.", file=sys.stderr)
    with tempfile.TemporaryDirectory(prefix="treeline-bench-") as work:
        figures, failed = measure(
            names, Bench(arguments.programs, arguments.recording,
                         arguments.poses, work, arguments.quick),
            lambda line: print(line, file=sys.stderr, flush=True))
    run = run_of(arguments, names, figures, failed, facts)
    before = history.last_comparable(earlier, run)
    now = {figure.name: figure for figure in figures}
    compared = changes(now, history.figures_of(before)) if before else []
    if figures:
        print("\n".join(table(figures, compared)))
    print(f"\nCompared with {before['at']}, commit {before['machine']['commit']}."
          if before else "\nNo earlier run of such a machine to compare with.")
    for name, why in failed.items():
        print(f"{name} was not measured: {why}", file=sys.stderr)
    if arguments.json:
        pathlib.Path(arguments.json).write_text(json.dumps(run, indent=1) + "\n")
    if arguments.history and figures:
        history.append(arguments.history, run)
    worse = [change for change in compared if change.is_regression]
    if worse:
        print("Worse: " + "; ".join(f"{c.figure.name} ({c.worse:.0%})"
                                    for c in worse), file=sys.stderr)
    return 1 if failed or (arguments.fail_if_worse and worse) else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
