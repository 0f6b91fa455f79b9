#!/usr/bin/env python3
"""Breaks things under a running service, and says what came of it.

One row for each fault, with its figures; exit code 0 if every requirement of
every fault held, 1 if not, 2 for wrong usage.
"""

import argparse
import json
import os
import pathlib
import platform
import shutil
import subprocess
import sys
import tempfile
import time

import clients  # noqa: F401  (each of these registers its faults)
import crowds  # noqa: F401
import fleet  # noqa: F401
import floods  # noqa: F401
import load  # noqa: F401
import models  # noqa: F401
import object_store  # noqa: F401
import replicas  # noqa: F401
from harness import FAULTS, FaultError, Row, Setup


def parse_arguments():
    parser = argparse.ArgumentParser(
        description=__doc__.split("\n\n")[0],
        epilog="Faults: " + ", ".join(FAULTS))
    parser.add_argument("--programs", required=True,
                        help="folder of treeline-server and treeline-client")
    parser.add_argument("--scene", required=True,
                        help="folder with recording/ and room.treeline")
    parser.add_argument("--only", action="append", default=[], metavar="NAME",
                        help="only this fault; may be repeated")
    parser.add_argument("--quick", action="store_true",
                        help="shorter runs, less exact figures")
    parser.add_argument("--json", metavar="FILE",
                        help="write the rows there, too")
    arguments = parser.parse_args()
    unknown = [name for name in arguments.only if name not in FAULTS]
    if unknown:
        parser.error(f"no fault {', '.join(unknown)}; there are "
                     + ", ".join(FAULTS))
    return arguments


def run_fault(name, arguments, work):
    claim, function = FAULTS[name]
    row = Row(name, claim)
    start = time.monotonic()
    with Setup(arguments.programs, arguments.scene, work,
               arguments.quick) as setup:
        try:
            function(setup, row)
        except (FaultError, OSError, subprocess.SubprocessError, KeyError,
                TypeError, ValueError) as error:
            row.error = f"{type(error).__name__}: {error}"
    row.seconds = time.monotonic() - start
    return row


def print_row(row):
    figures = ", ".join(f"{name} {value}" for name, value in
                        row.figures.items())
    print(f"{'PASS' if row.passed else 'FAIL'}  {row.name} "
          f"({row.seconds:.1f} s): {row.claim}\n      {figures}", flush=True)
    for requirement in row.requirements:
        if not requirement["held"]:
            print("      NOT HELD: {figure}: {value}, must be {relation} "
                  "{limit}".format(**requirement), flush=True)
    if row.error:
        print(f"      ERROR: {row.error}", flush=True)


def machine():
    cpu = ""
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        for line in file:
            if line.startswith("model name"):
                cpu = line.split(":", 1)[1].strip()
                break
    return {"cpu": cpu, "cores": len(os.sched_getaffinity(0)),
            "system": f"{platform.system()} {platform.release()}",
            "load_average": os.getloadavg()}


def main():
    arguments = parse_arguments()
    before = machine()
    started = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    work = tempfile.mkdtemp(prefix="treeline-faults-")
    rows = []
    try:
        for name in arguments.only or FAULTS:
            rows.append(run_fault(name, arguments, work))
            print_row(rows[-1])
    finally:
        shutil.rmtree(work, ignore_errors=True)
    failed = [row.name for row in rows if not row.passed]
    if arguments.json:
        pathlib.Path(arguments.json).write_text(json.dumps(
            {"started_utc": started, "quick": arguments.quick,
             "machine": before, "load_average_after": os.getloadavg(),
             "rows": [row.as_json() for row in rows]}, indent=1) + "\n",
            encoding="utf-8")
    print(f"{len(rows) - len(failed)} of {len(rows)} faults passed"
          + (": failed: " + ", ".join(failed) if failed else ""))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
