"""What the fault suite judges by, judged itself."""

import struct
import unittest

from cluster import HAPROXY_CONFIGURATION, ROOT, answer_to, configuration
from harness import FaultError, Metrics, Row, calls, lost, worst_p99
from load import server_counts, total

TEXT = r'''# HELP treeline_requests_total Finished calls.
# TYPE treeline_requests_total counter
treeline_requests_total{rpc="Localize",transport="grpc",status="OK",reason="none"} 40
treeline_requests_total{rpc="Localize",transport="http",status="OK",reason="none"} 2
treeline_requests_total{rpc="Localize",transport="grpc",status="UNAVAILABLE",reason="QUEUE_FULL"} 7
treeline_requests_total{rpc="ListScenes",transport="grpc",status="OK",reason="none"} 1
treeline_queue_depth 0
treeline_scene_loads_total{scene="a\"b,c=\"d",result="ok"} 3
treeline_request_seconds_bucket{rpc="Localize",le="+Inf"} 49
'''


class MetricsTest(unittest.TestCase):
    def setUp(self):
        self.metrics = Metrics(TEXT)

    def test_sums_over_the_labels_that_are_not_named(self):
        self.assertEqual(self.metrics.sum("treeline_requests_total"), 50)
        self.assertEqual(self.metrics.sum("treeline_requests_total",
                                          status="OK", rpc="Localize"), 42)
        self.assertEqual(self.metrics.sum("treeline_queue_depth"), 0)

    def test_labels_may_hold_quotes_and_commas(self):
        self.assertEqual(self.metrics.by("treeline_scene_loads_total", "result",
                                         ), {("ok",): 3})

    def test_a_metric_that_is_not_there_is_no_zero(self):
        with self.assertRaises(FaultError):
            self.metrics.sum("treeline_shed_total")

    def test_what_is_no_exposition_is_an_error(self):
        with self.assertRaises(FaultError):
            Metrics("<html>not found</html>")

    def test_server_counts_are_comparable_with_the_clients(self):
        ours = calls({"all_calls": [
            {"code": "OK", "reason": None, "count": 42},
            {"code": "UNAVAILABLE", "reason": "QUEUE_FULL", "count": 7}]})
        self.assertEqual(server_counts(self.metrics), ours)
        self.assertEqual(total(ours), 49)
        self.assertEqual(total(ours, "UNAVAILABLE"), 7)


class RowTest(unittest.TestCase):
    def test_a_row_without_requirements_does_not_pass(self):
        row = Row("name", "claim")
        row.figure("calls", 1)
        self.assertFalse(row.passed)

    def test_one_requirement_that_is_not_held_fails_the_row(self):
        row = Row("name", "claim")
        row.require("failed", 0, "==", 0)
        self.assertTrue(row.passed)
        row.require("p99", 30, "<=", 20)
        self.assertFalse(row.passed)
        self.assertEqual([r["held"] for r in row.as_json()["requirements"]],
                         [True, False])

    def test_an_error_fails_the_row(self):
        row = Row("name", "claim")
        row.require("failed", 0, "==", 0)
        row.error = "no server"
        self.assertFalse(row.passed)


class ClusterTest(unittest.TestCase):

    @staticmethod
    def question(name, kind):
        labels = b"".join(bytes([len(part)]) + part.encode()
                          for part in name.split(".")) + b"\0"
        return struct.pack(">HHHHHH", 7, 0x0100, 1, 0, 0, 0) + labels + \
            struct.pack(">HH", kind, 1)

    def test_the_name_server_answers_with_every_address(self):
        question = self.question("pods.default.svc", 1)
        answer = answer_to(question, ["127.1.2.3", "127.1.2.4"])
        self.assertEqual(answer[:2], question[:2])
        self.assertEqual(answer[6:8], b"\0\2")
        self.assertEqual(answer[12:len(question)], question[12:])
        self.assertTrue(answer.endswith(b"\0\4\x7f\1\2\4"))

    def test_other_types_have_no_addresses(self):
        answer = answer_to(self.question("pods", 28), ["127.1.2.3"])
        self.assertEqual(answer[6:8], b"\0\0")

    def test_what_is_no_question_is_refused(self):
        for bytes_ in (b"", b"\0" * 11, self.question("pods", 1)[:-3],
                       b"\0" * 12 + b"\xff"):
            with self.assertRaises(ValueError):
                answer_to(bytes_, [])

    def test_a_change_that_fits_nowhere_or_twice_is_an_error(self):
        self.assertEqual(configuration("a b", [("a", "c")]), "c b")
        for text in ("b", "a a"):
            with self.assertRaises(FaultError):
                configuration(text, [("a", "c")])


    def test_all_balancers_that_are_shipped_have_the_same_limits(self):
        def limits(path):
            lines = [line.strip().removesuffix(" table clients")
                     for line in path.read_text().splitlines()]
            return [line for line in lines if line.startswith(
                ("stick-table", "tcp-request", "http-request deny deny_status "
                 "429", "tune.h2", "maxconn"))]
        first = limits(HAPROXY_CONFIGURATION)
        self.assertEqual(len(first), 6)
        compose = limits(ROOT / "deploy" / "haproxy.cfg")
        self.assertEqual(set(first), set(compose))
        # Those of a listener: of gRPC, and of browsers.
        for line in first[3:]:
            self.assertEqual(compose.count(line), 2, line)


class RunTest(unittest.TestCase):
    RUN = {"counts": {"ok": 5, "shed": 1, "failed": 2},
           "intervals": [{"at_s": 0, "ok": 3, "p99_ms": 10},
                         {"at_s": 1, "ok": 0, "p99_ms": 0},
                         {"at_s": 2, "ok": 2, "p99_ms": 40}]}

    def test_lost_is_what_was_not_answered(self):
        self.assertEqual(lost(self.RUN), 3)

    def test_the_worst_interval_counts(self):
        self.assertEqual(worst_p99(self.RUN, 0, 3), 40)
        self.assertEqual(worst_p99(self.RUN, 0, 2), 10)

    def test_no_answer_is_no_fast_answer(self):
        with self.assertRaises(FaultError):
            worst_p99(self.RUN, 1, 2)


if __name__ == "__main__":
    unittest.main()
