"""Runs that were kept: one line of JSON a run."""

import json
import os
import pathlib

import machine
from figures import Figure


class HistoryError(Exception):
    """A history that cannot be read: which line, and why."""


def read(path):
    """All runs, the oldest first; none if there is no such file."""
    try:
        lines = pathlib.Path(path).read_text().splitlines()
    except FileNotFoundError:
        return []
    runs = []
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            run = json.loads(line)
            figures_of(run)
            run["machine"].get("preset")
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            raise HistoryError(f"{path}:{number}: not a run ({error}); remove "
                               "the line, or name another --history") from None
        runs.append(run)
    return runs


def append(path, run):
    """Adds a run as one write, so that one that is killed leaves none."""
    path = pathlib.Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    line = json.dumps(run, separators=(",", ":")) + "\n"
    descriptor = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
    try:
        os.write(descriptor, line.encode())
    finally:
        os.close(descriptor)


def figures_of(run):
    """The figures of a run by their names."""
    return {f["name"]: Figure.of_json(f) for f in run["figures"]}


def last_comparable(runs, now):
    """The newest run of the same work on a machine like this one that has all
    groups of this one; None if there is none."""
    for run in reversed(runs):
        if (machine.is_comparable(now["machine"], run["machine"])
                and run["workload"] == now["workload"]
                and set(now["groups"]) <= set(run["groups"])):
            return run
    return None
