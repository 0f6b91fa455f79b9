"""The comparison, the history, and reading what programs say."""

import json
import pathlib
import sys
import tempfile
import unittest

import history
import machine
from figures import Figure, changes
from measurements import micro_figures
from programs import BenchError, run
from run_bench import table


def by_name(*figures):
    return {figure.name: figure for figure in figures}


class FiguresTest(unittest.TestCase):
    def test_the_best_of_the_repeats_counts(self):
        self.assertEqual(Figure("t", "ms", [3, 2, 9]).value, 2)
        self.assertEqual(Figure("r", "1/s", [3, 2, 9], better="more").value, 9)

    def test_refuses_what_was_not_measured(self):
        with self.assertRaisesRegex(ValueError, "t was not measured"):
            Figure("t", "ms", [])

    def test_slower_by_more_than_the_scatter_is_a_regression(self):
        (change,) = changes(by_name(Figure("t", "ms", [2.4, 2.41, 2.42])),
                            by_name(Figure("t", "ms", [2.0, 2.01, 2.02])))
        self.assertTrue(change.is_regression)
        self.assertAlmostEqual(change.worse, 0.2)

    def test_within_the_scatter_nothing_is_said(self):
        (change,) = changes(by_name(Figure("t", "ms", [2.4, 3.1, 3.2])),
                            by_name(Figure("t", "ms", [2.0, 2.4, 2.5])))
        self.assertFalse(change.is_certain)

    def test_fewer_a_second_is_worse(self):
        (change,) = changes(
            by_name(Figure("r", "1/s", [100], better="more")),
            by_name(Figure("r", "1/s", [200], better="more")))
        self.assertTrue(change.is_regression)
        self.assertAlmostEqual(change.worse, 1.0)

    def test_a_slower_machine_slows_the_yardstick_too(self):
        stick = "their query"
        now = by_name(Figure("query", "ms", [4], yardstick=stick),
                      Figure(stick, "ms", [80]))
        before = by_name(Figure("query", "ms", [2], yardstick=stick),
                         Figure(stick, "ms", [40]))
        query = changes(now, before)[0]
        self.assertAlmostEqual(query.worse, 0)

    def test_another_unit_is_another_figure(self):
        self.assertEqual(changes(by_name(Figure("t", "us", [2])),
                                 by_name(Figure("t", "ms", [2]))), [])

    def test_json_and_back(self):
        figure = Figure("t", "ms", [1.5, 2], yardstick="s")
        self.assertEqual(Figure.of_json(json.loads(json.dumps(
            figure.as_json()))), figure)

    def test_the_table_names_what_became_worse(self):
        now = by_name(Figure("query", "ms", [4]))
        lines = list(table(list(now.values()),
                           changes(now, by_name(Figure("query", "ms", [2])))))
        self.assertIn("100% WORSE", lines[1])


def made_run(**more):
    facts = {"processor": {"name": "x", "vector": []}, "processors": 2,
             "memory_mib": 1, "preset": "dev", "commit": "a"}
    return {"at": "now", "machine": facts, "groups": ["query", "micro"],
            "workload": {"recording": "room", "quick": True},
            "figures": [Figure("t", "ms", [1]).as_json()], **more}


class HistoryTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name) / "kept" / "history.jsonl"

    def test_what_is_appended_is_read(self):
        history.append(self.path, made_run(at="first"))
        history.append(self.path, made_run(at="second"))
        self.assertEqual([r["at"] for r in history.read(self.path)],
                         ["first", "second"])

    def test_none_is_no_error(self):
        self.assertEqual(history.read(self.path), [])

    def test_a_torn_line_is_named(self):
        history.append(self.path, made_run())
        with self.path.open("a") as file:
            file.write('{"at": "now", "mach')
        with self.assertRaisesRegex(history.HistoryError, "jsonl:2: not a run"):
            history.read(self.path)

    def test_json_that_is_no_run_is_named(self):
        self.path.parent.mkdir()
        for line in ("[]", "3", '{"figures": []}', '{"figures": [{}]}'):
            self.path.write_text(line)
            with self.assertRaisesRegex(history.HistoryError, ":1: not a run"):
                history.read(self.path)

    def test_compares_with_the_newest_of_the_same_work_and_machine(self):
        runs = [made_run(at="old"), made_run(at="good"),
                made_run(at="other work", workload={"recording": "kitchen"}),
                made_run(at="fewer groups", groups=["micro"]),
                made_run(at="other machine",
                         machine={**made_run()["machine"], "processors": 64})]
        self.assertEqual(history.last_comparable(runs, made_run())["at"],
                         "good")
        self.assertIsNone(history.last_comparable(runs[2:], made_run()))


class ProgramsTest(unittest.TestCase):
    def test_says_what_it_took(self):
        used = run([sys.executable, "-c", "print('x' * 3)"])
        self.assertEqual(used.output, "xxx\n")
        self.assertGreater(used.processor_s, 0)
        self.assertGreater(used.peak_mib, 1)

    def test_says_why_it_failed(self):
        with self.assertRaisesRegex(BenchError, "ended with 3: no luck"):
            run([sys.executable, "-c",
                 "import sys; print('no luck', file=sys.stderr); sys.exit(3)"])

    def test_benchmarks_that_were_skipped_are_no_figures(self):
        results = {"benchmarks": [
            {"run_name": "BM_Localize/500", "run_type": "iteration",
             "time_unit": "ms", "cpu_time": 3.0},
            {"run_name": "BM_Localize/500", "run_type": "iteration",
             "time_unit": "ms", "cpu_time": 2.0},
            {"run_name": "BM_Localize/500", "run_type": "aggregate",
             "time_unit": "ms", "cpu_time": 2.5},
            {"run_name": "BM_Skipped", "run_type": "iteration",
             "error_occurred": True, "time_unit": "ms", "cpu_time": 0.0}]}
        (figure,) = micro_figures("localizer_benchmark", results)
        self.assertEqual(figure.value, 2.0)
        self.assertEqual(figure.yardstick,
                         "localizer_benchmark BM_OpenCvSiftExtraction")


class MachineTest(unittest.TestCase):
    def test_knows_this_one(self):
        facts = machine.facts(pathlib.Path(__file__).parent, "dev")
        self.assertTrue(facts["processor"]["name"])
        self.assertGreater(facts["memory_mib"], 0)
        self.assertTrue(machine.is_comparable(facts, dict(facts)))


if __name__ == "__main__":
    unittest.main()
