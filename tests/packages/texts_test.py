"""The packages' changelog, licences and descriptions.

    texts_test.py PACKAGING
"""

import json
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from packaging import arguments

PACKAGING, = arguments(1)
import make_changelog  # noqa: E402
import make_copyright  # noqa: E402

CHANGES = """\
# Changes

## 1.2.0 – 2026-12-01

### Added

* One thing ([page.md](docs/page.md)), told
  over two lines.
* Another.

## 1.1.0 – 2026-11-01

* Old.
"""


class ChangelogTest(unittest.TestCase):

    def test_it_has_the_newest_section_alone(self):
        text = make_changelog.changelog("treeline", "1.2.0", 1763000000,
                                        CHANGES)
        self.assertTrue(text.startswith("treeline (1.2.0) bookworm; urgency"))
        self.assertIn("  * One thing (page.md), told over two lines.\n", text)
        self.assertIn("  * Another.\n", text)
        self.assertNotIn("Old", text)
        self.assertTrue(text.endswith(
            "  Thu, 13 Nov 2025 02:13:20 +0000\n"), text)

    def test_debian_reads_that_of_this_tree(self):
        if shutil.which("dpkg-parsechangelog") is None:
            self.skipTest("there is no dpkg-parsechangelog here")
        tree = PACKAGING.parents[1]
        text = make_changelog.changelog(
            "treeline", "0.1.0", 1763000000,
            (tree / "CHANGELOG.md").read_text(encoding="utf-8"))
        done = subprocess.run(["dpkg-parsechangelog", "-l-", "-S", "Version"],
                              input=text, capture_output=True, text=True,
                              check=True)
        self.assertEqual(done.stdout, "0.1.0\n")
        self.assertEqual(done.stderr, "")

    def test_without_a_section_it_is_refused(self):
        with self.assertRaisesRegex(ValueError, "no section"):
            make_changelog.changelog("treeline", "1", 0, "# Changes\n")


class CopyrightTest(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.work = pathlib.Path(folder.name)
        self.packages = {"": {}}
        self.base = (PACKAGING / "debian" / "copyright").read_text()

    def package(self, name, licence, text=None, **more):
        self.packages[f"node_modules/{name}"] = {
            "version": "1.0.0", "license": licence, **more}
        place = self.work / "node_modules" / name
        place.mkdir(parents=True)
        (place / "package.json").write_text(json.dumps({"license": licence}))
        if text is not None:
            (place / "LICENSE").write_text(text)

    def text(self):
        (self.work / "package-lock.json").write_text(
            json.dumps({"packages": self.packages}))
        return make_copyright.copyright_text(
            self.base, [("usr/share/treeline/page/*", self.work)])

    def test_it_names_what_is_in_the_page_and_nothing_else(self):
        self.package("alpha", "MIT", "Copyright (c) 2020 Ann\n\nPermission.\n")
        self.package("tool", "MIT", "Copyright (c) 2020 Bob\n", dev=True)
        text = self.text()
        self.assertIn("\nFiles: usr/share/treeline/page/*\n", text)
        self.assertIn(" Copyright (c) 2020 Ann\n", text)
        self.assertIn("License: Apache-2.0 and MIT\n", text)
        self.assertIn(" alpha 1.0.0 (MIT)\n", text)
        self.assertIn("\nLicense: MIT\n [alpha]\n .\n Permission.\n", text)
        self.assertNotIn("tool", text)

    def test_one_text_stands_there_once(self):
        self.package("alpha", "MIT", "Copyright (c) 2020 Ann\n\nPermission.\n")
        self.package("beta", "MIT", "Copyright (c) 2021 Bob\n\npermission.\n")
        self.package("gamma", "MIT", "Copyright (c) 2021 Eve\n\nOther.\n")
        text = self.text()
        self.assertEqual(text.lower().count("permission."), 1)
        self.assertIn(" Copyright (c) 2021 Bob\n", text)
        self.assertIn("[gamma]\n .\n Other.", text)

    def test_a_licence_may_stand_in_the_sources(self):
        self.package("alpha", "(Apache-2.0 AND BSD-3-Clause)")
        (self.work / "node_modules/alpha/index.js").write_text(
            "// Copyright 2008 Somebody\n//\n// Redistribution.\nlet x;\n")
        text = self.text()
        self.assertIn("License: Apache-2.0 and BSD-3-Clause\n", text)
        self.assertIn("\nLicense: BSD-3-Clause\n [alpha]\n .\n"
                      " Redistribution.\n", text)

    def test_a_package_without_a_text_is_refused(self):
        self.package("alpha", "MIT")
        with self.assertRaisesRegex(make_copyright.CopyrightError, "alpha"):
            self.text()

    def test_a_package_that_was_not_fetched_is_refused(self):
        self.packages["node_modules/alpha"] = {"version": "1", "license": "MIT"}
        with self.assertRaisesRegex(make_copyright.CopyrightError, "alpha"):
            self.text()


class ControlTest(unittest.TestCase):

    def test_every_package_is_filled(self):
        control = (PACKAGING / "debian" / "control").read_text()
        packages = re.findall(r"(?m)^Package: (\S+)$", control)
        stage = (PACKAGING / "stage").read_text()
        self.assertGreater(len(packages), 5)
        for package in packages:
            self.assertRegex(stage, rf"install_component \S+ {package}\n")
        self.assertEqual(len(re.findall("install_component [^(]", stage)),
                         len(packages))


if __name__ == "__main__":
    unittest.main(argv=["texts_test.py"])
