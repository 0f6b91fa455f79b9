"""Builds wheel and Debian package for the other tests.

    build_package.py SCRIPT OUTPUT

Exits with 77 where what builds them is not installed.
"""

import importlib.util
import shutil
import subprocess
import sys

SKIPPED = 77


def main():
    script, output = sys.argv[1:]
    missing = [name for name in ("build", "grpc", "numpy", "setuptools",
                                 "wheel")
               if importlib.util.find_spec(name) is None]
    missing += [name for name in ("dh_python3", "dpkg-buildpackage", "protoc",
                                  "grpc_python_plugin")
                if shutil.which(name) is None]
    if missing:
        print(f"SKIPPED: no {', '.join(missing)}; scripts/install-deps --tools")
        return SKIPPED
    return subprocess.run([script, "--deb", "--output", output],
                          check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
