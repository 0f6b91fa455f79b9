"""What is in the jar of the Java client, and what it asks of others.

Run by ctest: package_test.py JAR PROTOBUF_JAR
"""

import pathlib
import re
import struct
import subprocess
import sys
import unittest
import zipfile

JAR, PROTOBUF = map(pathlib.Path, sys.argv[1:3])
# Of Java 8, whose library Android 8 has.
CLASS_FILE_VERSION = 52
# What protobuf-javalite has not.
FULL_RUNTIME = ("GeneratedMessageV3", "Descriptors", "AbstractMessage",
                "DynamicMessage", "TextFormat", "JsonFormat", "Message")


class Package(unittest.TestCase):

    def setUp(self):
        self.jar = zipfile.ZipFile(JAR)
        self.addCleanup(self.jar.close)

    def test_it_has_what_users_need_and_nothing_else(self):
        names = [name for name in self.jar.namelist()
                 if not name.endswith("/")]
        for name in ("META-INF/LICENSE",
                     "META-INF/proguard/treeline-client.pro",
                     "dev/treeline/client/TreelineClient.class",
                     "dev/treeline/proto/LocalizeRequest.class"):
            self.assertIn(name, names)
        strange = [name for name in names if not re.fullmatch(
            r"META-INF/(MANIFEST.MF|LICENSE|proguard/treeline-client.pro)|"
            r"dev/treeline/(camera|client|fusion|geometry|proto)/[\w$]+.class",
            name)]
        self.assertEqual(strange, [])
        self.assertEqual([name for name in names if "Test" in name], [])

    def test_classes_are_of_java_8(self):
        for name in self.jar.namelist():
            if name.endswith(".class"):
                version = struct.unpack(">I2xH", self.jar.read(name)[:8])[1]
                self.assertEqual(version, CLASS_FILE_VERSION, name)

    def test_it_needs_java_base_and_lite_messages_alone(self):
        needs = subprocess.run(
            ["jdeps", "-v", "--multi-release", "base", "-cp", PROTOBUF, JAR],
            check=True, capture_output=True, text=True).stdout
        used = set(re.findall(r"-> ([\w.$]+)", needs))
        self.assertIn("com.google.protobuf.GeneratedMessageLite", used)
        for name in used:
            if re.match(r"dev\.treeline\.|javax\.net\.ssl\.|java\."
                        r"(base$|(io|lang|net|nio|security|util)\.)", name):
                continue
            if name.endswith(".jar"):
                continue
            self.assertTrue(name.startswith("com.google.protobuf."), name)
            self.assertNotIn(name.split(".")[-1].split("$")[0], FULL_RUNTIME)

    def test_beside_it_are_sources_documents_and_a_pom(self):
        folder, name = JAR.parent, JAR.name.removesuffix(".jar")
        with zipfile.ZipFile(folder / f"{name}-sources.jar") as sources:
            self.assertIn("dev/treeline/client/TreelineClient.java",
                          sources.namelist())
            self.assertIn("dev/treeline/proto/LocalizeRequest.java",
                          sources.namelist())
        with zipfile.ZipFile(folder / f"{name}-javadoc.jar") as documents:
            self.assertIn("dev/treeline/client/TreelineClient.html",
                          documents.namelist())
            self.assertFalse(any("/proto/" in page
                                 for page in documents.namelist()))
        pom = (folder / f"{name}.pom").read_text(encoding="utf-8")
        self.assertIn("protobuf-javalite", pom)
        self.assertIn(f"<version>{name.split('-')[-1]}</version>", pom)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
