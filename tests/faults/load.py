"""More load than a server can take, and what it says about it afterwards."""

import json
import subprocess

from harness import (FaultError, Server, bench, calls, explain_losses, fault,
                     lost, wait_until)

def small_server(setup, *more, workers=1):
    """A server on its own processors, where there are enough."""
    cpus, _ = setup.split_cores()
    return Server(setup, setup.models(), "--workers", str(workers), *more,
                  cpus=cpus)


@fault("overload", "at twice the capacity, open loop: goodput at least 90 % "
                   "of the peak, what is accepted is in time, the rest is "
                   "turned away in under 10 ms")
def overload(setup, row):
    deadline_ms = 500
    server = small_server(setup, "--queue", "64")
    _, cpus = setup.split_cores()
    seconds = setup.seconds(10, 5)
    options = ("--deadline-ms", deadline_ms, "--no-reference", "--duration",
               seconds)
    peak = bench(setup, [server], *options, "--concurrency", "4",
                 cpus=cpus)["runs"][0]
    run = bench(setup, [server], *options, "--rate",
                2 * peak["goodput_per_s"], cpus=cpus)["runs"][0]
    shed = run["shed_from_send_ms"] or {"p99": None, "p50": None}
    row.figure("peak (/s)", peak["goodput_per_s"])
    row.figure("offered (/s)", round(run["calls"] / run["measured_s"], 1))
    row.figure("goodput (/s)", run["goodput_per_s"])
    row.figure("counts", run["counts"])
    row.figure("shed p50 (ms)", shed["p50"])
    row.figure("accepted p50 (ms)", run["latency_ms"]["p50"])
    row.figure("generator", run["generator"]["cpus"])
    row.require("goodput / peak", round(
        run["goodput_per_s"] / peak["goodput_per_s"], 3), ">=", 0.9)
    # What is too late has no latency: it ended with the deadline. The 99th
    # percentile of what was accepted is in time if 99 % of it were answered.
    late, answered = run["counts"]["deadline"], run["counts"]["ok"]
    row.figure("answered p99 (ms)", run["latency_ms"]["p99"])
    row.require("late, of those accepted",
                round(late / max(1, late + answered), 4), "<=", 0.01)
    row.require("shed calls", run["counts"]["shed"], ">", 0)
    row.require("shed p99 (ms)", shed["p99"] or 1e9, "<", 10)
    row.require("failed otherwise",
                run["counts"]["failed"] + run["counts"]["cancelled"], "==", 0)
    row.require("generator saturated", run["generator"]["saturated"], "==",
                False)
    explain_losses(row, run)


def server_counts(metrics):
    """{(status, reason): calls} of Localize; the reason "none" is no reason,
    as with the client."""
    return {(status, "" if reason == "none" else reason): int(value)
            for (rpc, status, reason), value in metrics.by(
                "treeline_requests_total", "rpc", "status", "reason").items()
            if rpc == "Localize"}


def total(counts, *codes):
    return sum(n for (code, _), n in counts.items()
               if not codes or code in codes)


def wait_for_rest(server):
    """Until the server has nothing left to do: all is counted then."""
    def idle():
        metrics = server.metrics()
        return (metrics.sum("treeline_in_flight") == 0 and
                metrics.sum("treeline_queue_depth") == 0)
    wait_until(idle, "the server to be idle", 30, 0.1)


@fault("metrics-add-up", "every call, shed or not, is counted exactly once: "
                         "the server's metrics are the client's own counts")
def reconciliation(setup, row):
    setup.need("--http-listen")
    server = small_server(setup, "--queue", "4")
    seconds = setup.seconds(6, 3)
    # Nothing of this ends early on the client's side.
    result = bench(setup, [server], "--concurrency", "24", "--duration",
                   seconds, "--no-reference")
    wait_for_rest(server)
    ours, theirs = calls(result), server_counts(server.metrics())
    row.figure("client", named(ours))
    row.figure("server", named(theirs))
    row.require("calls", total(ours), "==", total(theirs))
    row.require("answered", total(ours, "OK"), "==", total(theirs, "OK"))
    row.require("shed", total(ours, "UNAVAILABLE"), "==",
                total(theirs, "UNAVAILABLE"))
    row.require("some were shed", total(ours, "UNAVAILABLE"), ">", 0)
    row.require("by code and reason",
                {k: v for k, v in ours.items() if v} ==
                {k: v for k, v in theirs.items() if v}, "==", True)
    row.require("treeline_shed_total",
                server.metrics().sum("treeline_shed_total"), "==",
                total(ours, "UNAVAILABLE"))


@fault("cancelled-add-up", "with calls that are cancelled and that run out of "
                           "time: still each is counted exactly once")
def cancelled(setup, row):
    setup.need("--http-listen")
    server = small_server(setup, "--queue", "64")
    peak = bench(setup, [server], "--concurrency", "4", "--no-reference",
                 "--duration", "2")
    wait_for_rest(server)
    before = server_counts(server.metrics())
    row.require("calls before", total(calls(peak)), "==", total(before))
    result = bench(setup, [server], "--rate",
                   1.5 * peak["runs"][0]["answers_per_s"], "--no-reference",
                   "--duration", setup.seconds(8, 4), "--deadline-ms", "200",
                   "--cancel-share", "0.3", "--cancel-after-ms", "150")
    wait_for_rest(server)
    metrics = server.metrics()
    ours = calls(result)
    theirs = {key: n - before.get(key, 0)
              for key, n in server_counts(metrics).items()}
    gave_up = total(ours, "CANCELLED", "DEADLINE_EXCEEDED")
    row.figure("client", named(ours))
    row.figure("server", named(theirs))
    # A call given up before its request has arrived never reaches the
    # service; one given up while its answer travels was answered.
    never_arrived = total(ours) - total(theirs)
    row.require("cancelled by the client", total(ours, "CANCELLED"), ">", 0)
    row.require("calls that never arrived", never_arrived, ">=", 0)
    row.require("of the calls, given up and never arrived",
                round(never_arrived / max(1, total(ours)), 4), "<=", 0.02)
    row.require("answers too few at the client",
                total(theirs, "OK") - total(ours, "OK"), ">=", 0)
    row.require("answers on their way",
                total(theirs, "OK") - total(ours, "OK"), "<=", gave_up)
    row.require("shed", total(ours, "UNAVAILABLE"), "<=",
                total(theirs, "UNAVAILABLE"))
    row.require("treeline_cancelled_total",
                metrics.sum("treeline_cancelled_total"), "==",
                total(theirs, "CANCELLED"))


def named(counts):
    return {f"{code} {reason}".strip(): n for (code, reason), n in
            sorted(counts.items()) if n}


def in_process(setup, threads, seconds, cpus):
    """The localizer without a service, on the same files."""
    done = subprocess.run(
        ["taskset", "-c", ",".join(map(str, cpus)),
         setup.program("in-process-load"), str(setup.model),
         f"7scenes:{setup.recording}", str(setup.recording / "test.txt"),
         "16", str(threads), str(seconds)],
        text=True, capture_output=True, check=False)
    if done.returncode != 0:
        raise FaultError(f"in-process-load: {done.stderr[-500:]}")
    return json.loads(done.stdout)


@fault("overhead", "served, a query takes less than 1 ms more than in process "
                   "(p50), and throughput is at least 90 % of it")
def overhead(setup, row):
    server = small_server(setup, workers=1)
    cpus, load_cpus = setup.split_cores()
    seconds = setup.seconds(5, 3)
    alone, served, rates, served_rates = [], [], [], []
    run = None
    # In turns, so that what else the machine does falls on both.
    for _ in range(3):
        alone.append(in_process(setup, 1, seconds, cpus))
        run = bench(setup, [server], "--concurrency", "1", "--duration",
                    seconds, cpus=load_cpus)["runs"][0]
        served.append(run)
        busy = bench(setup, [server], "--concurrency", "4", "--no-reference",
                     "--duration", seconds, cpus=load_cpus)["runs"][0]
        rates.append(alone[-1]["per_s"])
        served_rates.append(busy["goodput_per_s"])
        row.require(f"failed calls {len(rates)}", lost(run) + lost(busy), "==",
                    0)
    alone_p50 = min(a["p50_ms"] for a in alone)
    served_p50 = min(s["from_send_ms"]["p50"] for s in served)
    row.figure("in process p50 (ms)", alone_p50)
    row.figure("served p50 (ms)", served_p50)
    row.figure("in process (/s)", max(rates))
    row.figure("served (/s)", max(served_rates))
    # Without it the yardstick is too short.
    row.require("processors that the in-process run got",
                max(a["cpus"] for a in alone), ">=", 0.9)
    row.require("round trip without decoding and localizing, p50 (ms)",
                min(s["server"]["overhead_ms"]["p50"] for s in served), "<", 1)
    row.require("served p50 - in-process p50 (ms)",
                round(served_p50 - alone_p50, 3), "<", 1)
    row.require("served / in process",
                round(max(served_rates) / max(rates), 3), ">=", 0.9)
    row.require("wrong answers", sum(s["checks"]["different"] for s in served),
                "==", 0)
