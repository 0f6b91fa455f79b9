"""treeline-client bench and watch against treeline-server itself.

    bench_program_test.py PROGRAMS SCENE HARNESS

PROGRAMS holds treeline-server and treeline-client; SCENE is a folder with
recording/ and room.treeline, of tests/integration/make_scene.cmake; HARNESS has
real_server.py.
"""

import json
import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest
import urllib.request

PROGRAMS, SCENE, HARNESS = (pathlib.Path(a) for a in sys.argv[1:4])
sys.path.insert(0, str(HARNESS))
from real_server import RealServer, put_scene  # noqa: E402

CLIENT = PROGRAMS / "treeline-client"
SHORT = {"--duration": "1", "--warm-up": "0.2", "--max-frames": "6"}


def short(*arguments):
    """What is not said keeps a test short."""
    more = [word for flag, value in SHORT.items() if flag not in arguments
            for word in (flag, value)]
    return [*arguments, *more]


def run(*arguments):
    return subprocess.run([str(part) for part in (CLIENT, *arguments)],
                          capture_output=True, text=True, check=False)


class BenchProgram(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        put_scene(cls.folder / "models", SCENE / "room.treeline")
        cls.server = RealServer(PROGRAMS / "treeline-server",
                                cls.folder / "models")
        cls.addClassCleanup(cls.server.stop)

    def bench(self, *arguments, target="grpc", status=0):
        address = self.server.address if target == "grpc" else self.server.http
        done = run("bench", "--server", address, "--target", target, "--scene",
                   f"room={SCENE / 'recording'}", *short(*arguments))
        self.assertEqual(done.returncode, status, done.stderr + done.stdout)
        return done

    def result(self, *arguments, **options):
        return json.loads(self.bench("--json", *arguments, **options).stdout)

    def test_every_target_is_answered_alike(self):
        for target in ("grpc", "connect", "connect-json", "geopose"):
            with self.subTest(target):
                result = self.result("--concurrency", "2", target=target)
                self.assertEqual(result["target"], target)
                run_, = result["runs"]
                self.assertGreater(run_["counts"]["ok"], 3)
                self.assertEqual(run_["counts"]["ok"], run_["calls"],
                                 run_["outcomes"])
                checks = run_["checks"]
                self.assertEqual(checks["as_before_load"], run_["calls"])
                self.assertGreater(run_["localized"], 0.7 * run_["calls"])
                if target == "geopose":
                    # Of the Earth, without timings.
                    self.assertEqual(checks["with_truth"], 0)
                    self.assertIsNone(run_["server"]["total_ms"])
                else:
                    self.assertGreater(checks["within_tolerance"],
                                       0.7 * run_["calls"])
                    self.assertGreater(run_["server"]["total_ms"]["mean"], 0)

    def test_conditions_decide_the_exit_status(self):
        self.bench("--fail-if", "p50>100s,failed>0")
        broken = self.result("--fail-if", "p50>1us,failed>0", status=4)
        failures = broken["runs"][0]["failures"]
        self.assertEqual(len(failures), 1)
        self.assertRegex(failures[0], r"^p50 is \d+\.\d\d ms \(p50>1us\)$")
        wrong = self.bench("--fail-if", "p50>1", status=2)
        self.assertIn("the unit of p50 is us, ms or s", wrong.stderr)
        self.assertEqual(wrong.stdout, "")

    def test_ramps_go_up(self):
        by_rate = self.result("--ramp-rate", "4:8:+2", "--warm-up", "0")
        self.assertEqual([r["rate_per_s"] for r in by_rate["runs"]], [4, 6, 8])
        by_clients = self.result("--ramp-concurrency", "1:2:x2")
        self.assertEqual([r["concurrency"] for r in by_clients["runs"]], [1, 2])
        begun = [r["measured_from_unix_s"] for r in by_clients["runs"]]
        self.assertGreaterEqual(begun[1] - begun[0], 1)
        self.assertIn("FROM:TO:+STEP",
                      self.bench("--ramp-rate", "8:4:+2", status=2).stderr)

    def test_processes_are_merged(self):
        for target in ("grpc", "connect"):
            result = self.result("--processes", "2", "--concurrency", "3",
                                 target=target)
            run_, = result["runs"]
            self.assertEqual(result["processes"], 2)
            self.assertEqual(run_["concurrency"], 3)
            self.assertGreater(run_["calls"], 3)
            self.assertEqual(run_["checks"]["as_before_load"], run_["calls"])
            self.assertEqual(run_["latency_ms"]["count"], run_["calls"])
            # Each has asked for every answer before, in all twice 6.
            self.assertGreaterEqual(sum(c["count"] for c in
                                        result["all_calls"]),
                                    12 + run_["calls"])
        self.assertIn("for each", self.bench(
            "--processes", "2", "--concurrency", "1", status=2).stderr)
        gone = run("bench", "--server", "127.0.0.1:1", "--scene",
                   f"room={SCENE / 'recording'}",
                   *short("--processes", "2", "--concurrency", "2"))
        self.assertEqual(gone.returncode, 1)
        self.assertIn("UNAVAILABLE", gone.stderr)

    def test_the_servers_metrics_are_in_it(self):
        result = self.result("--duration", "2.5", "--metrics",
                             f"http://{self.server.http}", "--report",
                             self.folder / "page.html")
        metrics = result["server_metrics"]
        self.assertEqual(metrics["missed"], 0)
        self.assertGreaterEqual(len(metrics["points"]), 2)
        self.assertGreater(max(p["answers_per_s"] for p in metrics["points"]),
                           1)
        self.assertGreater(metrics["workers"], 0)
        written = [path for path in (self.folder / "page.html",
                                     self.folder / "page.data.json")
                   if path.is_file()]
        self.assertEqual(len(written), 1)
        self.assertIn('"kind": "bench"', written[0].read_text())
        wrong = self.bench("--metrics", "http://127.0.0.1:1", status=1)
        self.assertIn("http://127.0.0.1:1/metrics", wrong.stderr)

    def test_what_does_not_go_together_is_said(self):
        for arguments, said in (
                (["--stream", "4"], "--stream needs"),
                (["--attempts", "4"], "--attempts needs")):
            self.assertIn(said, self.bench(*arguments, target="connect",
                                           status=2).stderr)
        self.assertIn("connect-json", self.bench(target="rest",
                                                 status=2).stderr)
        self.assertIn("raw colour", self.bench(
            "--encoding", "raw", target="geopose", status=1).stderr)

    def test_ctrl_c_keeps_what_was_measured(self):
        for processes in ("1", "2"):
            before = self.answered()
            program = subprocess.Popen(
                [CLIENT, "bench", "--server", self.server.address, "--scene",
                 f"room={SCENE / 'recording'}", "--max-frames", "2",
                 "--warm-up", "0", "--duration", "600", "--json",
                 "--concurrency", "2", "--processes", processes],
                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            # Two queries of each process come before the load.
            while self.answered() < before + 2 * int(processes) + 3:
                self.assertIsNone(program.poll())
            program.send_signal(signal.SIGINT)
            out, err = program.communicate(timeout=60)
            self.assertEqual(program.returncode, 130, err)
            run_, = json.loads(out)["runs"]
            self.assertTrue(run_["interrupted"])
            self.assertLess(run_["measured_s"], 599)
            self.assertGreater(run_["calls"], 0)

    def answered(self):
        """By the server, since it was started."""
        with urllib.request.urlopen(
                f"http://{self.server.http}/metrics") as answer:
            return sum(float(line.split()[-1])
                       for line in answer.read().decode().splitlines()
                       if line.startswith("treeline_outcomes_total{"))

    def test_watch_ends_after_its_views(self):
        done = run("watch", f"http://{self.server.http}", "--every-s", "0.1",
                   "--count", "3")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(done.stdout.splitlines()), 3)
        self.assertRegex(done.stdout, r"queue 0 of \d+, \d\.\d\d processors")

    def test_watch_explains_what_it_cannot_read(self):
        self.assertEqual(run("watch", "127.0.0.1:8080").returncode, 2)
        gone = run("watch", "http://127.0.0.1:1")
        self.assertEqual(gone.returncode, 1)
        self.assertIn("http://127.0.0.1:1/metrics", gone.stderr)
        other = run("watch", f"http://{self.server.http}/healthz")
        self.assertEqual(other.returncode, 1)
        self.assertIn("/healthz", other.stderr)


class WithTls(unittest.TestCase):
    """The same against a server that speaks TLS alone."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        put_scene(cls.folder / "models", SCENE / "room.treeline")
        cls.certificate, key = cls.folder / "tls.crt", cls.folder / "tls.key"
        subprocess.run(
            ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes",
             "-keyout", key, "-out", cls.certificate, "-days", "2", "-subj",
             "/CN=treeline", "-addext",
             "subjectAltName=DNS:localhost,IP:127.0.0.1"],
            check=True, capture_output=True)
        cls.server = RealServer(
            PROGRAMS / "treeline-server", cls.folder / "models",
            "--tls-cert", cls.certificate, "--tls-key", key)
        cls.addClassCleanup(cls.server.stop)

    def bench(self, target, *trust):
        address = self.server.address if target == "grpc" else self.server.http
        return run("bench", "--server", address, "--target", target, "--scene",
                   f"room={SCENE / 'recording'}", "--json", *trust, *short(
                       "--metrics", f"https://{self.server.http}"))

    def test_load_and_metrics_go_over_tls(self):
        for target in ("grpc", "connect", "connect-json", "geopose"):
            with self.subTest(target):
                done = self.bench(target, "--tls-ca", self.certificate)
                self.assertEqual(done.returncode, 0, done.stderr)
                result = json.loads(done.stdout)
                run_, = result["runs"]
                self.assertGreater(run_["counts"]["ok"], 3)
                self.assertEqual(run_["counts"]["ok"], run_["calls"])
                self.assertGreater(len(result["server_metrics"]["points"]), 0)

    def test_who_is_not_trusted_gets_nothing(self):
        other = self.folder / "other.crt"
        subprocess.run(
            ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes",
             "-keyout", self.folder / "other.key", "-out", other, "-days", "2",
             "-subj", "/CN=other"], check=True, capture_output=True)
        for target in ("grpc", "connect"):
            done = self.bench(target, "--tls-ca", other)
            self.assertEqual(done.returncode, 1, done.stdout)
            self.assertEqual(done.stdout, "")
            self.assertIn("certificate", done.stderr.lower())

    def test_watch_goes_over_tls(self):
        url = f"https://{self.server.http}"
        done = run("watch", url, "--tls-ca", self.certificate, "--every-s",
                   "0.1", "--count", "2")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(done.stdout.splitlines()), 2)
        for url_ in (url, f"http://{self.server.http}"):
            refused = run("watch", url_, "--count", "1")
            self.assertEqual(refused.returncode, 1, refused.stdout)
            self.assertIn(self.server.http, refused.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
