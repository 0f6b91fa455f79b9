"""docs/how-to/use-from-csharp-and-swift.md: every name of its C# is in what
protoc makes of the contract, and every field of its Swift is in the contract.
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROTO = ROOT / "proto"
PAGE = (ROOT / "docs" / "how-to" /
        "use-from-csharp-and-swift.md").read_text()
# What is not of the contract: the languages' own, and their libraries'.
OTHERS = set("""
AddSeconds Address Async ByteString Console CopyFrom DateTime File ForAddress
GetValueBytes Google Grpc GrpcChannel Net ParseFrom Parser Protobuf
ReadAllBytes Rpc RpcException Trailers TryUnpack UtcNow WriteLine Client
Treeline V1
""".split())


def blocks(language):
    return "\n".join(re.findall(rf"^```{language}\n(.*?)^```$", PAGE,
                                re.M | re.S))


def without_strings(code):
    return re.sub(r"//.*", "", re.sub(r'"[^"]*"', '""', code))


class CSharp(unittest.TestCase):

    def test_names_are_those_of_the_stubs(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run(
                [shutil.which("protoc"), "-I", PROTO, f"--csharp_out={folder}",
                 *sorted(PROTO.glob("treeline/v1/*.proto")),
                 PROTO / "google" / "rpc" / "status.proto"], check=True)
            made = "\n".join(path.read_text()
                             for path in pathlib.Path(folder).glob("*.cs"))
        self.assertTrue("namespace Treeline.V1 {" in made)
        # protoc's own C# has messages; the calls come from gRPC's plugin, by
        # the names of services and methods.
        contract = (PROTO / "treeline/v1/relocalization.proto").read_text()
        services = set(re.findall(r"^service (\w+)", contract, re.M))
        methods = set(re.findall(r"^  rpc (\w+)", contract, re.M))
        names = set(re.findall(r"\b[A-Z]\w+", without_strings(
            blocks("csharp")))) - OTHERS
        self.assertGreater(len(names), 20)
        for name in names:
            plain = name.removesuffix("Client").removesuffix("Async")
            if plain in services | methods:
                continue
            self.assertTrue(re.search(
                rf"(class|enum) {name}\b|public [\w:.<>]+ {name} {{"
                rf"|\] {name} = \d", made), name)
        self.assertTrue('"OUTCOME_LOCALIZED")] Localized = 1' in made)


class Swift(unittest.TestCase):

    def test_fields_are_those_of_the_contract(self):
        contract = "\n".join(path.read_text() for path in
                             PROTO.glob("treeline/v1/*.proto"))
        fields = {re.sub(r"_(\w)", lambda m: m[1].upper(), name) for name in
                  re.findall(r"^ +(?:repeated |optional )?[\w.]+ (\w+) = \d+;",
                             contract, re.M)}
        code = without_strings(blocks("swift"))
        paths = re.findall(r"\b(?:request|answer)((?:\.[a-z]\w*)+)", code)
        self.assertGreater(len(paths), 6)
        for path in paths:
            for name in path.strip(".").split("."):
                self.assertIn(name, fields)
        for message in re.findall(r"\bTreeline_V1_(\w+)", code):
            if not message.endswith("ServiceClient"):
                self.assertRegex(contract, rf"(?m)^message {message} ")

    def test_it_names_files_that_are_there(self):
        folder, names = re.search(r"proto/(treeline/v1)/\{([\w,]+)\}\.proto",
                                  PAGE).groups()
        for name in names.split(","):
            self.assertTrue((PROTO / folder / f"{name}.proto").is_file())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
