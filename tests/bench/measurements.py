"""The groups of figures: learning, query, service, micro.

A group is a function that takes a Bench and returns figures.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

from figures import Figure
from programs import BenchError, run

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "faults"))
import harness  # noqa: E402  (servers and load, as the faults use them)

GROUPS = {}


def group(name, what):
    """Registers a function as a group of figures."""
    def register(function):
        GROUPS[name] = (what, function)
        return function
    return register


class Bench:
    """Programs, a recording with its lists, and how long to measure."""

    def __init__(self, programs, recording, poses, work, quick):
        self.programs = pathlib.Path(programs)
        self.recording = pathlib.Path(recording)
        self.poses = ["--poses", str(poses)] if poses else []
        self.work = pathlib.Path(work)
        self.quick = quick
        self.repeats = 1 if quick else 3
        self._learnt = None

    def program(self, name):
        path = self.programs / name
        if not path.is_file():
            raise BenchError(f"no {path}; scripts/bench builds it")
        return str(path)

    def frames(self, option, which):
        """Arguments that name the recording and one of its lists."""
        prefix = "" if option == "dataset" else "training-"
        return [f"--{prefix}dataset", f"7scenes:{self.recording}",
                f"--{prefix}frames", str(self.recording / f"{which}.txt"),
                *([f"--{prefix}poses", *self.poses[1:]] if self.poses else [])]

    @property
    def model(self):
        return self.work / "scene.treeline"

    def learnt(self):
        """How the default method learnt the recording; once a run."""
        if self._learnt is None:
            self._learnt = run([self.program("treeline"), "train",
                                *self.frames("dataset", "train"), "--quiet",
                                "--output", str(self.model)])
        return self._learnt


@group("learning", "the default method learns the recording")
def learning(bench):
    used = bench.learnt()
    return [
        Figure("learning, all processors", "s", [used.seconds]),
        Figure("learning, processor time", "s", [used.processor_s]),
        Figure("learning, peak memory", "MiB", [used.peak_mib]),
        Figure("model", "MB", [bench.model.stat().st_size / 1e6]),
    ]


def evaluated(bench, *arguments):
    """The JSON of treeline evaluate on the test list, one thread."""
    out = bench.work / "evaluated.json"
    run([bench.program("treeline"), "evaluate",
         *bench.frames("dataset", "test"), "--json", str(out), "--quiet",
         "--threads", "1", *arguments])
    return json.loads(out.read_text())


@group("query", "one query on one core, beside decoding and features of OpenCV")
def query(bench):
    bench.learnt()
    runs = [evaluated(bench, "--model", str(bench.model), "--perturb",
                      "no-depth") for _ in range(bench.repeats)]
    without = [next(p for p in r["perturbations"] if p["name"] == "no-depth")
               for r in runs]
    figures = [
        Figure("decoding a frame, p50", "ms",
               [r["decode_ms"]["p50"] for r in runs]),
        Figure("query with depth, processor time p50", "ms",
               [r["cpu_ms"]["p50"] for r in runs],
               yardstick="decoding a frame, p50"),
        Figure("query with depth, right", "%",
               [100 * r["correct_5cm_5deg"] for r in runs], better="more"),
        Figure("query without depth, processor time p50", "ms",
               [w["cpu_ms"]["p50"] for w in without],
               yardstick="ORB + PnP, processor time p50"),
        Figure("query without depth, right", "%",
               [100 * w["share_right"] for w in without], better="more"),
    ]
    others = [("orb-pnp", "ORB + PnP")]
    if not bench.quick:
        others.append(("sift-pnp", "SIFT + PnP"))
    for name, title in others:
        other = evaluated(bench, "--baseline", name,
                          *bench.frames("training", "train"))
        figures += [
            Figure(f"{title}, processor time p50", "ms",
                   [other["cpu_ms"]["p50"]]),
            Figure(f"{title}, right", "%", [100 * other["correct_5cm_5deg"]],
                   better="more"),
        ]
    return figures


@group("service", "the same queries over gRPC on loopback, beside in process")
def service(bench):
    bench.learnt()
    scene = bench.work / "served"
    scene.mkdir(exist_ok=True)
    for link, target in (("recording", bench.recording),
                         ("room.treeline", bench.model)):
        (scene / link).unlink(missing_ok=True)
        (scene / link).symlink_to(pathlib.Path(target).resolve())
    seconds = 2 if bench.quick else 5
    alone, served, busy = [], [], []
    with harness.Setup(bench.programs, scene, bench.work,
                       bench.quick) as setup:
        cpus, load_cpus = setup.split_cores()
        server = harness.Server(setup, setup.models(), "--load-all",
                                "--workers", str(len(cpus)), cpus=cpus)
        # In turns, so that what else the machine does falls on all.
        for _ in range(bench.repeats):
            alone.append(in_process(bench, setup, seconds, cpus))
            served.append(harness.bench(
                setup, [server], "--concurrency", "1", "--duration", seconds,
                cpus=load_cpus)["runs"][0])
            busy.append(harness.bench(
                setup, [server], "--concurrency", str(4 * len(cpus)),
                "--no-reference", "--duration", seconds,
                cpus=load_cpus)["runs"][0])
    lost = sum(harness.lost(r) for r in served + busy)
    if lost:
        raise BenchError(f"{lost} calls were not answered")
    return [
        Figure("in process, p50", "ms", [a["p50_ms"] for a in alone]),
        Figure("in process, queries a second and core", "1/s",
               [a["per_s"] / len(cpus) for a in alone], better="more"),
        Figure("round trip, p50", "ms",
               [s["from_send_ms"]["p50"] for s in served],
               yardstick="in process, p50"),
        Figure("served, queries a second and core", "1/s",
               [b["goodput_per_s"] / len(cpus) for b in busy], better="more",
               yardstick="in process, queries a second and core"),
    ]


def in_process(bench, setup, seconds, cpus):
    """The localizer without a service, decoding included."""
    done = run(["taskset", "-c", ",".join(map(str, cpus)),
                bench.program("in-process-load"), str(bench.model),
                f"7scenes:{bench.recording}",
                str(setup.recording / "test.txt"), "16", str(len(cpus)),
                str(seconds)])
    return json.loads(done.output)


# What a benchmark is held against, where its own program measures that, too.
MICRO_YARDSTICKS = {
    ("localizer_benchmark", "BM_Localize"): "BM_OpenCvSiftExtraction",
    ("sift_benchmark", "BM_Sift"): "BM_OpenCvSift/3000",
    ("sift_benchmark", "BM_FastSift"): "BM_OpenCvSift/3000",
}


@group("micro", "the Google Benchmarks of all parts")
def micro(bench):
    figures = []
    listed = bench.programs.parent / "benchmarks.txt"
    for program in listed.read_text().split():
        if (bench.programs / program).is_file():
            figures += micro_program(bench, program)
    if not figures:
        raise BenchError(f"no program of {listed} was built")
    return figures


def micro_program(bench, program):
    with tempfile.TemporaryDirectory(dir=bench.work) as folder:
        out = pathlib.Path(folder) / "figures.json"
        run([bench.program(program), f"--benchmark_out={out}",
             "--benchmark_out_format=json",
             f"--benchmark_repetitions={bench.repeats}",
             f"--benchmark_min_time={0.05 if bench.quick else 0.3}"],
            environment={"TREELINE_BENCHMARK_MODEL": str(bench.model)})
        return micro_figures(program, json.loads(out.read_text()))


def micro_figures(program, results):
    """Figures of Google Benchmark's JSON; skipped benchmarks are left out."""
    repeats = {}
    for one in results["benchmarks"]:
        if one.get("run_type") == "iteration" and not one.get("error_occurred"):
            repeats.setdefault((one["run_name"], one["time_unit"]),
                               []).append(one["cpu_time"])
    figures = []
    for (name, unit), values in repeats.items():
        stick = MICRO_YARDSTICKS.get((program, name.split("/")[0]))
        figures.append(Figure(
            f"{program} {name}", unit, values,
            yardstick=f"{program} {stick}" if stick else None))
    return figures


def measure(names, bench, say):
    """The figures of the groups, and why a group has none."""
    figures, failed = [], {}
    for name in names:
        say(f"== {name}: {GROUPS[name][0]}")
        try:
            figures += GROUPS[name][1](bench)
        except (BenchError, harness.FaultError, OSError, KeyError, ValueError,
                StopIteration, subprocess.SubprocessError) as error:
            failed[name] = f"{type(error).__name__}: {error}"
    return figures, failed
