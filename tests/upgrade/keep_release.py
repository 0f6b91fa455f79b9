"""Keeps small what this version writes and reads, for the versions after it.

Usage: keep_release.py TREE BIN

Writes TREE/tests/upgrade/kept/VERSION: the packages' configuration files with
every setting, a query and an answer on the wire, and a model. To be run and
committed when a release is made (docs/how-to/release.md); what is there is not
changed again.
"""

import pathlib
import re
import shutil
import subprocess
import sys

MESSAGES = {"request": "LocalizeRequest", "response": "LocalizeResponse"}
CONTRACT = "treeline/v1/relocalization.proto"


def encoded(tree, message, text):
    """The bytes of a treeline.v1 message in Protocol Buffers' text format."""
    return subprocess.run(
        ["protoc", "-I", str(tree / "proto"),
         f"--encode=treeline.v1.{message}", CONTRACT],
        input=text, capture_output=True, check=True).stdout


def decoded(tree, message, data):
    return subprocess.run(
        ["protoc", "-I", str(tree / "proto"),
         f"--decode=treeline.v1.{message}", CONTRACT],
        input=data, capture_output=True, check=True).stdout.decode()


def configuration(tree, program):
    """The package's file with every setting in force."""
    text = subprocess.run(
        [sys.executable, "-B", tree / "deploy/packages/lib/make_config.py",
         program], capture_output=True, text=True, check=True).stdout
    settings = re.findall(r"(?m)^#?(\w+: .*)$", text)
    return "".join(f"{line}\n" for line in settings)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    tree, programs = (pathlib.Path(path).resolve() for path in sys.argv[1:])
    said = subprocess.run([programs / "treeline-server", "--version"],
                          capture_output=True, text=True, check=True).stdout
    here = tree / "tests" / "upgrade"
    kept = here / "kept" / said.split()[1]
    if kept.exists():
        sys.exit(f"keep_release: {kept} is there, and is not changed again")
    part = kept.with_suffix(".part")
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir(parents=True)
    for program in ("server", "agent"):
        (part / f"{program}.yaml").write_text(configuration(tree, program))
    for name, message in MESSAGES.items():
        text = (here / f"{name}.txtpb").read_bytes()
        (part / f"{name}.binpb").write_bytes(encoded(tree, message, text))
        (part / f"{name}.txtpb").write_text(
            decoded(tree, message, encoded(tree, message, text)))
    newest = sorted((tree / "tests" / "golden").glob("model-v*.bin"),
                    key=lambda path: int(path.stem.split("-v")[1]))[-1]
    shutil.copyfile(newest, part / "model.bin")
    part.rename(kept)
    print(f"kept in {kept}")


if __name__ == "__main__":
    main()
