"""Makes Python of the .proto files when the package is built.

The contract is looked for in proto/ beside this file, where
scripts/build-python puts it. Needs protoc and grpc_python_plugin: Debian's
protobuf-compiler and protobuf-compiler-grpc.
"""

import pathlib
import shutil
import subprocess
import tempfile

from setuptools import setup
from setuptools.command.build_py import build_py

PROTO = pathlib.Path(__file__).resolve().parent / "proto"
SERVICES = ("treeline/v1/relocalization", "treeline/v1/scenes")
MESSAGES = ("treeline/rpc/status", "treeline/v1/camera", "treeline/v1/frame",
            "treeline/v1/geometry", *SERVICES)


def renamed(text):
    """google.rpc under our own name: treeline/rpc/__init__.py says why."""
    return (text.replace("package google.rpc;", "package treeline.rpc;")
            .replace("google/rpc/status.proto", "treeline/rpc/status.proto")
            .replace("google.rpc.Status", "treeline.rpc.Status"))


def make_stubs(output):
    """Writes the modules below `output`."""
    plugin = shutil.which("grpc_python_plugin")
    if plugin is None or shutil.which("protoc") is None:
        raise SystemExit("no protoc or grpc_python_plugin; Debian has them in"
                         " protobuf-compiler and protobuf-compiler-grpc")
    with tempfile.TemporaryDirectory() as folder:
        for name in MESSAGES:
            theirs = name.replace("treeline/rpc", "google/rpc")
            source = PROTO / f"{theirs}.proto"
            target = pathlib.Path(folder) / f"{name}.proto"
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(renamed(source.read_text()))
        protos = [f"{name}.proto" for name in MESSAGES]
        services = [f"{name}.proto" for name in SERVICES]
        subprocess.run(["protoc", "-I", folder, f"--python_out={output}",
                        f"--pyi_out={output}", *protos], check=True)
        subprocess.run(["protoc", "-I", folder, f"--grpc_python_out={output}",
                        f"--plugin=protoc-gen-grpc_python={plugin}",
                        *services], check=True)


class BuildWithStubs(build_py):
    """Python as it is, and the stubs."""

    def run(self):
        super().run()
        make_stubs(self.build_lib)


# Not in pyproject.toml, whose part for setuptools is not stable in Debian 12.
setup(packages=["treeline", "treeline.rpc", "treeline.v1"],
      package_data={"treeline": ["py.typed"]},
      cmdclass={"build_py": BuildWithStubs})
