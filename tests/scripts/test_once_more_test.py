"""scripts/test runs one or two tests that failed once more, and no others."""

import unittest

from stub_programs import ScriptTest

# Stands in for ctest: its first run fails as FAILURES says (name=why,...), in
# ctest's words; a run of what failed ends with the status AGAIN.
CTEST = r"""#!/usr/bin/env bash
printf '%s\n' "$*" >>"$CALLS"
if [[ " $* " == *" --rerun-failed "* ]]; then exit "$AGAIN"; fi
printf '1/2 Test #1: good ....   Passed    0.02 sec\n'
[[ -n "$FAILURES" ]] || exit 0
printf '\nThe following tests FAILED:\n'
IFS=,
for failure in $FAILURES; do
  printf '\t  7 - %s (%s)\n' "${failure%=*}" "${failure#*=}"
done
printf 'Errors while running CTest\n' >&2
exit 8
"""


class OnceMoreTest(ScriptTest):

    def setUp(self):
        super().setUp()
        (self.root / "build" / "dev").mkdir(parents=True)
        for name in ("install-deps", "build"):
            self.write_program(self.root / "scripts" / name,
                               "#!/bin/sh\nexit 0\n")
        self.stub("ctest", CTEST)
        self.calls = self.root / "calls"

    def run_tests(self, failures, again=0, preset="dev"):
        self.calls.write_text("", encoding="utf-8")
        return self.run_script("test", "--preset", preset, FAILURES=failures,
                               AGAIN=str(again), CALLS=str(self.calls))

    def runs(self):
        return len(self.calls.read_text(encoding="utf-8").splitlines())

    def test_all_pass(self):
        self.assertEqual(self.run_tests("").returncode, 0)
        self.assertEqual(self.runs(), 1)

    def test_one_that_passes_the_second_time_is_named(self):
        done = self.run_tests("slow_test=Failed,other_test=Timeout")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.runs(), 2)
        self.assertIn("passed only when run again, alone: slow_test other_test",
                      done.stdout)

    def test_one_that_fails_twice_fails(self):
        done = self.run_tests("slow_test=Failed", again=8)
        self.assertEqual(done.returncode, 8)
        self.assertNotIn("passed only", done.stdout)

    def test_what_crashed_is_not_run_again(self):
        for failures in ("a=SEGFAULT", "a=Failed,b=Subprocess aborted"):
            done = self.run_tests(failures)
            self.assertEqual(done.returncode, 8)
            self.assertEqual(self.runs(), 1)

    def test_three_are_not_run_again(self):
        done = self.run_tests("a=Failed,b=Failed,c=Failed")
        self.assertEqual(done.returncode, 8)
        self.assertEqual(self.runs(), 1)

    def test_what_a_sanitizer_finds_is_not_forgiven(self):
        for preset in ("asan-ubsan", "tsan"):
            (self.root / "build" / preset).mkdir()
            done = self.run_tests("a=Failed", preset=preset)
            self.assertEqual(done.returncode, 8)
            self.assertEqual(self.runs(), 1)


if __name__ == "__main__":
    unittest.main()
