"""The Java of the pages compiles against the client and signatures of Android's
and ARCore's classes (stubs/); every name in their Kotlin is one of somebody.

Run by ctest: pages_test.py JAR PROTOBUF_JAR
"""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
HERE = pathlib.Path(__file__).resolve().parent
CLASSPATH = ":".join(sys.argv[1:3])
PAGES = ("client/java/README.md", "docs/how-to/use-from-java-and-kotlin.md")
# Kotlin's own, Gradle's and the applications'.
OTHERS = set("""
await let use openRawResource raw authority token kts google com protobuf
example local
""".split())


def blocks(language):
    for page in PAGES:
        text = (ROOT / page).read_text(encoding="utf-8")
        yield from re.findall(rf"^```{language}\n(.*?)^```$", text,
                              re.M | re.S)


def without_words(code):
    return re.sub(r"//.*", "", re.sub(r'"[^"]*"', '""', code))


class Pages(unittest.TestCase):

    def test_java_compiles(self):
        examples = list(blocks("java"))
        self.assertGreaterEqual(len(examples), 4)
        with tempfile.TemporaryDirectory() as folder:
            work = pathlib.Path(folder)
            files = sorted((HERE / "stubs").rglob("*.java"))
            for code in examples:
                name = re.search(r"^final class (\w+)", code, re.M)[1]
                files.append(work / f"{name}.java")
                files[-1].write_text(code, encoding="utf-8")
            made = subprocess.run(
                ["javac", "-Xlint:all,-options", "-Werror", "--release", "8",
                 "-classpath", CLASSPATH, "-d", work / "classes", *files],
                check=False, capture_output=True, text=True)
            self.assertEqual(made.returncode, 0, made.stderr)

    def test_names_of_kotlin_are_somebodys(self):
        sources = "\n".join(
            path.read_text(encoding="utf-8") for folder in
            (ROOT / "client/java/src/main/java", HERE / "stubs")
            for path in sorted(folder.rglob("*.java")))
        known = set(re.findall(r"\b\w+\b", sources)) | OTHERS
        used = set()
        for code in blocks("kotlin"):
            used |= set(re.findall(r"[.:](\w+)", without_words(code)))
        self.assertGreater(len(used), 15)
        for name in used:
            getter = "get" + name[0].upper() + name[1:]
            self.assertTrue(name in known or getter in known, name)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
