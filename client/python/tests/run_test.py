"""Runs a test with the package that was built, or skips it without one.

    run_test.py LIB FILE [ARGUMENT...]

LIB is the folder lib/ of scripts/build-python. Exits with 77 where Debian's
packages of the client are not installed.
"""

import importlib
import pathlib
import runpy
import sys

SKIPPED = 77


def main():
    lib, file, *arguments = sys.argv[1:]
    sys.path[:0] = [lib, str(pathlib.Path(file).resolve().parent)]
    for name in ("grpc", "google.protobuf", "numpy", "PIL", "matplotlib",
                 "jsonschema"):
        try:
            importlib.import_module(name)
        except ImportError:
            print(f"SKIPPED: no {name}; scripts/install-deps --tools")
            return SKIPPED
    sys.argv = [file, *arguments]
    runpy.run_path(file, run_name="__main__")
    return 0


if __name__ == "__main__":
    sys.exit(main())
