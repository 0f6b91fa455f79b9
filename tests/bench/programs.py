"""Runs a program to its end, and says what it took."""

import dataclasses
import os
import subprocess
import tempfile
import time


class BenchError(Exception):
    """Why something could not be measured."""


@dataclasses.dataclass
class Used:
    """What a program that succeeded wrote to stdout, and what it took."""

    output: str
    seconds: float
    processor_s: float
    peak_mib: float


def run(command, environment=None):
    """Runs it; BenchError with the end of what it said if it fails."""
    with tempfile.TemporaryFile("w+") as out, \
            tempfile.TemporaryFile("w+") as errors:
        start = time.monotonic()
        process = subprocess.Popen(command, stdout=out, stderr=errors,
                                   env={**os.environ, **(environment or {})})
        try:
            _, status, usage = os.wait4(process.pid, 0)
        except BaseException:
            process.kill()
            process.wait()
            raise
        seconds = time.monotonic() - start
        # Popen does not know that it was waited for.
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        errors.seek(0)
        if process.returncode != 0:
            raise BenchError(f"{' '.join(command)} ended with "
                             f"{process.returncode}: {errors.read()[-800:]}")
        return Used(out.read(), seconds, usage.ru_utime + usage.ru_stime,
                    usage.ru_maxrss / 1024)
