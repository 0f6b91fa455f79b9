"""Follows the commands of a page, as a reader would."""

import os
import pathlib
import re
import signal
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]


def steps_of(page):
    """What is fenced as ```sh in a page of docs/, in its order. What is fenced
    without a language builds Treeline, as the build that runs a test has done.
    """
    return re.findall(r"^```sh\n(.*?)^```$",
                      (ROOT / "docs" / page).read_text(), re.M | re.S)


def follow(commands, folder, programs, seconds=560, **environment):
    """Exit status and transcript of one shell, which has so many seconds. Kills
    all that it leaves."""
    shell = subprocess.Popen(
        ["bash", "-e", "-m", "-c", commands], cwd=folder, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        env={**os.environ, "PATH": f"{programs}:/usr/bin:/bin", **environment},
        start_new_session=True)
    transcript = ""
    try:
        transcript, _ = shell.communicate(timeout=seconds)
    except subprocess.TimeoutExpired:
        pass
    finally:
        for process in pathlib.Path("/proc").glob("[0-9]*/stat"):
            _end_if_of(shell.pid, process)
        shell.wait()
    return shell.returncode, transcript


def _end_if_of(session, stat):
    """Of a session of its own, so that nobody else's is ended."""
    try:
        fields = stat.read_text().rpartition(")")[2].split()
        if int(fields[3]) == session:
            os.kill(int(stat.parent.name), signal.SIGKILL)
    except (OSError, IndexError):
        pass
