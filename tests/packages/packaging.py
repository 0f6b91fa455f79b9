"""What the tests of the packages share."""

import pathlib
import sys

SKIPPED = 77

# The programs of the packages; treeline-demo is a script beside them.
PROGRAMS = ("treeline", "treeline-agent", "treeline-client",
            "treeline-emulator", "treeline-server")


def arguments(count):
    """The paths that CMake names: deploy/packages first."""
    if len(sys.argv) <= count:
        sys.exit(f"usage: {sys.argv[0]} with {count} paths")
    paths = [pathlib.Path(path) for path in sys.argv[1:count + 1]]
    sys.path.insert(0, str(paths[0] / "lib"))
    return paths


def skip(why):
    print(f"SKIPPED: {why}")
    sys.exit(SKIPPED)
