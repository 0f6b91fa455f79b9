"""scripts/release checks before it works, and versions agree or are named."""

import hashlib
import shutil
import subprocess
import sys
import unittest

from stub_programs import REPOSITORY, ScriptTest

FILES = {
    "CMakeLists.txt": "project(treeline VERSION 1.2.0 LANGUAGES CXX)\n",
    "Dockerfile": 'LABEL org.opencontainers.image.version="1.2.0"\n',
    "client/python/pyproject.toml": 'version = "1.2.0"\n',
    "client/python/debian/changelog": "treeline-client (1.2.0) bookworm;\n",
    "client/typescript/package.json": '{\n  "version": "1.2.0",\n}\n',
    "client/typescript/package-lock.json":
        '{"name": "@treeline/client",\n "version": "1.2.0",\n'
        '{"name": "@treeline/client",\n "version": "1.2.0"}}\n',
    "client/java/pom.xml":
        "<version>1.2.0</version>\n  <packaging>jar</packaging>\n",
    "docs/how-to/use-from-java-and-kotlin.md": "treeline-client-1.2.0.jar\n",
    "docs/how-to/use-from-python.md":
        "python3-treeline_1.2.0_all.deb treeline-1.2.0-py3-none-any.whl\n",
    "docs/how-to/use-from-typescript.md": "treeline-client-1.2.0.tgz\n",
    "CHANGELOG.md": "# Changes\n\n## 1.2.0 – 2026-12-01\n\n* New.\n",
}

# Each notes that it ran; those that make files make one.
STUB = r"""#!/bin/sh
echo "$(basename "$0") $*" >>"$CALLS"
[ "$(basename "$0")" != "${FAILS:-}" ] || exit 1
while [ $# -gt 1 ]; do
  case "$1" in
    --out | --output) mkdir -p "$2"; echo "$FILE" >"$2/NAME.EXT" ;;
  esac
  shift
done
"""


class ReleaseTest(ScriptTest):

    def setUp(self):
        super().setUp()
        self.calls = self.root.parent / "calls"
        self.calls.write_text("")
        for path, text in FILES.items():
            place = self.root / path
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_text(text, encoding="utf-8")
        for script, ending in (("package", "deb"), ("package-check", "none"),
                               ("build-python", "whl"),
                               ("build-typescript", "tgz"),
                               ("build-java", "jar")):
            # Of all that is built of Java, all is taken.
            name = ("treeline-client-1.2.0" if script == "build-java" else
                    f"made-by-{script}")
            self.write_program(
                self.root / "scripts" / script,
                STUB.replace("NAME", name).replace("EXT", ending))
        self.write_program(self.root / ".ci" / "run", STUB)
        (self.root / ".gitignore").write_text("/build/\n/out/\n__pycache__/\n")
        self.git("init", "--quiet", "--initial-branch=main")
        self.commit()

    def git(self, *words):
        done = subprocess.run(
            ["git", "-c", "user.name=N", "-c", "user.email=n@n.invalid",
             *words], cwd=self.root, capture_output=True, text=True,
            check=True)
        return done.stdout

    def commit(self):
        self.git("add", "--all")
        self.git("commit", "--quiet", "--message=All")

    def release(self, *words, **variables):
        return self.run_script(
            "release", *words, CALLS=str(self.calls), GIT_AUTHOR_NAME="N",
            GIT_AUTHOR_EMAIL="n@n.invalid", GIT_COMMITTER_NAME="N",
            GIT_COMMITTER_EMAIL="n@n.invalid", **variables)

    def refused(self, *words):
        """What it says when it refuses, having run nothing."""
        done = self.release(*words)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertEqual(self.calls.read_text(), "")
        self.assertFalse((self.root / "out").exists())
        return done.stderr

    def test_a_dry_run_does_nothing_and_says_what_it_would(self):
        done = self.release("--dry-run", "--tag")
        self.assertEqual(done.returncode, 0, done.stderr)
        for words in ("would run: .ci/run", "would run: scripts/package-check",
                      "out/release/1.2.0 with SHA256SUMS",
                      "would tag: v1.2.0"):
            self.assertIn(words, done.stdout)
        self.assertEqual(self.calls.read_text(), "")
        self.assertFalse((self.root / "out").exists())
        self.assertEqual(self.git("tag"), "")

    def test_it_tests_packs_verifies_and_sums_up(self):
        done = self.release()
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(
            [line.split()[0] for line in self.calls.read_text().splitlines()],
            ["run", "package", "package-check", "build-python",
             "build-typescript", "build-java"])
        folder = self.root / "out" / "release" / "1.2.0"
        sums = dict(reversed(line.split()) for line in
                    (folder / "SHA256SUMS").read_text().splitlines())
        self.assertEqual(sorted(sums), [
            "made-by-build-python.whl", "made-by-build-typescript.tgz",
            "made-by-package.deb", "treeline-1.2.0.tar.gz",
            "treeline-client-1.2.0.jar"])
        for name, digest in sums.items():
            self.assertEqual(
                hashlib.sha256((folder / name).read_bytes()).hexdigest(),
                digest)
        self.assertEqual(self.git("tag"), "")

    def test_it_tags_when_asked_to(self):
        done = self.release("--tag")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(self.git("tag"), "v1.2.0\n")
        # And not twice.
        done = self.release("--tag")
        self.assertEqual(done.returncode, 1)
        self.assertIn("v1.2.0 is there already", done.stderr)

    def test_what_fails_leaves_no_release_and_no_tag(self):
        done = self.release("--tag", FAILS="package-check")
        self.assertEqual(done.returncode, 1)
        self.assertNotIn("build-python", self.calls.read_text())
        self.assertFalse((self.root / "out/release/1.2.0").exists())
        self.assertEqual(self.git("tag"), "")
        # It can be tried again.
        self.assertEqual(self.release().returncode, 0)

    def test_uncommitted_changes_are_no_release(self):
        (self.root / "new.txt").write_text("new")
        self.assertIn("uncommitted changes", self.refused("--dry-run"))

    def test_the_changelog_must_be_of_this_version(self):
        for heading in ("Unreleased", "1.1.0 – 2026-12-01", "1.2.0"):
            (self.root / "CHANGELOG.md").write_text(
                f"# Changes\n\n## {heading}\n\n## 1.2.0 – 2026-12-01\n")
            self.commit()
            self.assertIn(f"section of CHANGELOG.md is '{heading}'",
                          self.refused())

    def test_all_that_is_wrong_is_said_at_once(self):
        (self.root / "Dockerfile").write_text(
            'LABEL org.opencontainers.image.version="1.1.0"\n')
        self.git("tag", "v1.2.0")
        said = self.refused()
        for words in ("uncommitted", "Dockerfile: 1.1.0", "v1.2.0 is there"):
            self.assertIn(words, said)

    def test_a_version_is_written_everywhere(self):
        done = self.release("--set-version", "1.3.0")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        for path, text in FILES.items():
            if path != "CHANGELOG.md":
                self.assertEqual(
                    (self.root / path).read_text(encoding="utf-8"),
                    text.replace("1.2.0", "1.3.0"), path)
        done = self.release("--set-version", "next")
        self.assertEqual(done.returncode, 1)
        self.assertIn("not like 1.2.3", done.stderr)


class VersionsTest(ScriptTest):

    def check(self):
        return subprocess.run(
            [sys.executable, "-B", REPOSITORY / "scripts/lib/versions.py",
             "--root", self.root], capture_output=True, text=True, check=False)

    def setUp(self):
        super().setUp()
        for path in FILES:
            place = self.root / path
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(REPOSITORY / path, place)

    def test_this_tree_agrees(self):
        done = self.check()
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_each_file_is_looked_at(self):
        for path in FILES:
            if path in ("CMakeLists.txt", "CHANGELOG.md"):
                continue
            place = self.root / path
            text = place.read_text(encoding="utf-8")
            place.write_text("nothing here\n")
            done = self.check()
            self.assertEqual(done.returncode, 1)
            self.assertIn(path, done.stdout)
            place.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    unittest.main()
