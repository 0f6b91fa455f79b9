"""Servers that stop, die and hang while clients ask them."""

import time

from harness import (CONT, KILL, STOP, TERM, Bench, Server, bench,
                     explain_losses, fault, lost, worst_p99)

# As the shipped client library tries.
ATTEMPTS = ("--attempts", "4")


def three(setup):
    models = setup.models()
    return [Server(setup, models, "--drain-s", "1", "--workers", "1")
            for _ in range(3)]


def after_warm_up(load, seconds):
    """Sleeps until the load has run for some seconds."""
    time.sleep(1.0 + seconds)
    if not load.running():
        load.result()  # says why


@fault("rolling-sigterm",
       "three replicas restart one after the other under load: no failed call")
def rolling_sigterm(setup, row):
    servers = three(setup)
    load = Bench(setup, servers, *ATTEMPTS, "--concurrency", "4",
                 "--duration", setup.seconds(20, 9))
    after_warm_up(load, 1)
    exits = []
    for i, server in enumerate(servers):
        server.send(TERM)
        exits.append(server.wait())
        servers[i] = server.again("--drain-s", "1", "--workers", "1")
        time.sleep(setup.seconds(1, 0.2))
    restarted_under_load = load.running()
    run = load.result()["runs"][0]
    row.figure("calls", run["calls"])
    row.require("failed calls", lost(run), "==", 0)
    row.require("wrong answers", run["checks"]["different"], "==", 0)
    row.require("exit codes other than 0", sum(e != 0 for e in exits), "==", 0)
    row.require("all restarts under load", restarted_under_load, "==", True)
    explain_losses(row, run)


@fault("sigkill", "one of three replicas is killed under load: no call lost "
                  "after retries")
def sigkill(setup, row):
    servers = three(setup)
    load = Bench(setup, servers, *ATTEMPTS, "--concurrency", "6",
                 "--duration", setup.seconds(10, 4))
    after_warm_up(load, 1.5)
    servers[1].send(KILL)
    killed = load.running()
    run = load.result()["runs"][0]
    row.figure("calls", run["calls"])
    row.figure("p99_ms", run["latency_ms"]["p99"])
    row.require("lost calls", lost(run), "==", 0)
    row.require("wrong answers", run["checks"]["different"], "==", 0)
    row.require("killed under load", killed, "==", True)
    explain_losses(row, run)


@fault("sigstop", "one of three replicas hangs for 5 s: no call lost, and the "
                  "99th percentile recovers")
def sigstop(setup, row):
    servers = three(setup)
    peak = bench(setup, servers, "--concurrency", "6", "--no-reference",
                 "--duration", setup.seconds(4, 2))["runs"][0]["answers_per_s"]
    before_s, hang_s, recover_s, after_s = 5, 5, 2, setup.seconds(6, 5)
    load = Bench(setup, servers, *ATTEMPTS, "--rate", 0.3 * peak, "--warm-up",
                 "1", "--duration", before_s + hang_s + recover_s + after_s)
    after_warm_up(load, before_s)
    stopped_at = time.time()
    servers[0].send(STOP)
    time.sleep(hang_s)
    servers[0].send(CONT)
    run = load.result()["runs"][0]
    begin = stopped_at - run["measured_from_unix_s"]
    end = begin + hang_s
    last = before_s + hang_s + recover_s + after_s
    before = worst_p99(run, 0, begin - 1)
    during = worst_p99(run, begin - 1, end + recover_s)
    after = worst_p99(run, end + recover_s, last)
    row.figure("rate_per_s", round(0.3 * peak, 1))
    row.figure("calls", run["calls"])
    row.figure("p99 before (ms)", before)
    row.figure("p99 while it hangs (ms)", during)
    row.require("lost calls", lost(run), "==", 0)
    row.require("p99 from 2 s after (ms)", after, "<=",
                round(max(2 * before, before + 20), 3))
    row.figure("generator saturated", run["generator"]["saturated"])
    explain_losses(row, run)
