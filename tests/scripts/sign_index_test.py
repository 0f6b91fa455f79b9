"""deploy/sign-index makes addresses that an object store takes."""

import contextlib
import datetime
import importlib.machinery
import importlib.util
import io
import json
import os
import pathlib
import tempfile
import unittest
from unittest import mock

from stub_programs import REPOSITORY

LOADER = importlib.machinery.SourceFileLoader(
    "sign_index", str(REPOSITORY / "deploy" / "sign-index"))
sign_index = importlib.util.module_from_spec(
    importlib.util.spec_from_loader(LOADER.name, LOADER))
LOADER.exec_module(sign_index)

# Of Amazon's documentation: "Authenticating Requests: Using Query Parameters
# (AWS Signature Version 4)".
KEY = ("AKIAIOSFODNN7EXAMPLE", "wJalrXUtnFEMI/K7MDENG/bPxRfiCYEXAMPLEKEY", "")
MOMENT = datetime.datetime(2013, 5, 24, tzinfo=datetime.timezone.utc)
SIGNED = (
    "https://examplebucket.s3.amazonaws.com/test.txt"
    "?X-Amz-Algorithm=AWS4-HMAC-SHA256"
    "&X-Amz-Credential=AKIAIOSFODNN7EXAMPLE%2F20130524%2Fus-east-1%2Fs3%2F"
    "aws4_request&X-Amz-Date=20130524T000000Z&X-Amz-Expires=86400"
    "&X-Amz-SignedHeaders=host&X-Amz-Signature="
    "aeeed9bbccd4d02ee5c0109b86d86835f995330da4c265957d157751f604d404")
ENVIRONMENT = {"AWS_ACCESS_KEY_ID": KEY[0], "AWS_SECRET_ACCESS_KEY": KEY[1]}


class Signatures(unittest.TestCase):

    def test_are_amazons_example(self):
        self.assertEqual(sign_index.presigned(
            "https://examplebucket.s3.amazonaws.com/test.txt", KEY, "us-east-1",
            MOMENT, 86400), SIGNED)

    def test_sign_the_path_as_it_is_sent(self):
        url = sign_index.presigned("https://h/b/a b/\u00e9", KEY, "r", MOMENT, 1)
        self.assertTrue(url.startswith("https://h/b/a%20b/%C3%A9?"), url)
        self.assertEqual(url, sign_index.presigned(
            "https://h/b/a%20b/%C3%A9", KEY, "r", MOMENT, 1))

    def test_name_the_session(self):
        url = sign_index.presigned("https://h/b", (*KEY[:2], "to/ken"), "r",
                                   MOMENT, 1)
        self.assertIn("X-Amz-Security-Token=to%2Fken", url)


class Program(unittest.TestCase):

    def run_on(self, index, *more, environment=None):
        """(exit code, standard output, standard error)."""
        out, err = io.StringIO(), io.StringIO()
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "index.json")
            file.write_text(index)
            with mock.patch.dict(os.environ, ENVIRONMENT if environment is None
                                 else environment, clear=True), \
                    contextlib.redirect_stdout(out), \
                    contextlib.redirect_stderr(err):
                try:
                    code = sign_index.main(
                        [str(file), "--endpoint", "https://h/models",
                         "--region", "r", *more])
                except SystemExit as end:
                    code = end.code
        return code, out.getvalue(), err.getvalue()

    INDEX = json.dumps({"models": [
        {"scene": "a", "version": "1", "bytes": 1, "sha256": "0",
         "url": "a/1/model.treeline"},
        {"scene": "b", "version": "1", "bytes": 1, "sha256": "0",
         "url": "https://elsewhere/b"}], "scenes": {"a": {}}})

    def test_signs_what_is_relative_and_keeps_the_rest(self):
        code, out, err = self.run_on(self.INDEX)
        self.assertEqual(code, 0, err)
        index = json.loads(out)
        self.assertTrue(index["models"][0]["url"].startswith(
            "https://h/models/a/1/model.treeline?X-Amz-Algorithm="))
        self.assertEqual(index["models"][1]["url"], "https://elsewhere/b")
        self.assertEqual(index["scenes"], {"a": {}})
        self.assertIn("https://h/models/signed.json?", err)

    def test_never_shows_the_secret(self):
        _, out, err = self.run_on(self.INDEX)
        self.assertNotIn(KEY[1], out + err)

    def test_refuses_what_it_cannot_do(self):
        self.assertEqual(self.run_on(self.INDEX, environment={})[0], 1)
        self.assertEqual(self.run_on("no json")[0], 1)
        self.assertEqual(self.run_on("{}")[0], 1)
        self.assertEqual(self.run_on("[]")[0], 1)
        for more in (["--valid-s", "0"], ["--valid-s", "604801"],
                     ["--endpoint", "h/models"],
                     ["--endpoint", "https://h/models?a=b"]):
            self.assertEqual(self.run_on(self.INDEX, *more)[0], 2, more)


if __name__ == "__main__":
    unittest.main()
