"""A fleet behind haproxy, as deploy/kubernetes has it: restarted, scaled, lost.

Every scene is on every server; the balancer sends the calls of a scene to the
same one. Clients try again as the client library does.
"""

import time

from cluster import Balancer, Deployment, haproxy_version
from harness import (INT, Bench, bench, explain_losses, fault, lost,
                     wait_until)

# As the shipped client library tries.
ATTEMPTS = ("--attempts", "4")
SERVER = ("--workers", "1", "--drain-s", "3", "--grace-s", "5")
SCENES = tuple(f"room-{i}" for i in range(8))
# A load that ends by itself long after the fault has.
ENOUGH_S = "600"


def fleet(setup, row, pods):
    row.figure("balancer", haproxy_version())
    deployment = Deployment(setup, setup.models(SCENES), *SERVER)
    deployment.scale(pods)
    return deployment, Balancer(setup, deployment)


def answers_of(deployment):
    """Of each pod."""
    counts = [pod.metrics() for pod in deployment.pods]
    return [metrics.sum("treeline_requests_total", rpc="Localize", status="OK")
            if metrics.has("treeline_requests_total") else 0
            for metrics in counts]


class Load:
    """Clients that ask as long as something is being done to the fleet."""

    def __init__(self, setup, address):
        self._bench = Bench(setup, address, *ATTEMPTS, "--concurrency",
                            "4", "--duration", ENOUGH_S, scenes=SCENES,
                            max_frames=2)
        time.sleep(setup.seconds(4, 2))

    def end(self, setup, row):
        """After some more time; the run, its losses in the row."""
        time.sleep(setup.seconds(4, 1))
        under_load = self._bench.running()
        # Ctrl-C: it ends with what was measured.
        self._bench.send(INT)
        run = self._bench.result()["runs"][0]
        row.figure("calls", run["calls"])
        row.figure("p99_ms", run["latency_ms"]["p99"])
        row.require("answers", run["counts"]["ok"], ">", 0)
        row.require("failed calls", lost(run), "==", 0)
        row.require("wrong answers", run["checks"]["different"], "==", 0)
        row.require("all of it under load", under_load, "==", True)
        explain_losses(row, run)
        return run


@fault("fleet-rolling", "a rolling restart behind haproxy: no failed call")
def rolling(setup, row):
    deployment, balancer = fleet(setup, row, setup.seconds(3, 2))
    load = Load(setup, balancer.address)
    for _ in range(setup.seconds(2, 1)):
        deployment.restart()
    load.end(setup, row)
    row.figure("pods started", len(deployment.exits) + len(deployment.pods))
    row.require("exit codes other than 0",
                sum(code != 0 for code in deployment.exits), "==", 0)


@fault("fleet-scale", "from 1 server to 4 and back behind haproxy: no failed "
                      "call, and all four work")
def scale(setup, row):
    deployment, balancer = fleet(setup, row, 1)
    load = Load(setup, balancer.address)
    deployment.scale(4)
    balancer.await_servers(4)
    time.sleep(setup.seconds(6, 3))
    worked = answers_of(deployment)
    deployment.scale(1)
    balancer.await_servers(1)
    load.end(setup, row)
    row.figure("answers by pod", worked)
    row.require("pods that answered", sum(n > 0 for n in worked), ">=", 3)
    row.require("exit codes other than 0",
                sum(code != 0 for code in deployment.exits), "==", 0)


@fault("fleet-node-loss", "two of four servers are killed at once behind "
                          "haproxy, and replaced: no call lost after retries")
def node_loss(setup, row):
    deployment, balancer = fleet(setup, row, 4)
    load = Load(setup, balancer.address)
    gone = deployment.lose(2)
    balancer.await_servers(2)
    time.sleep(setup.seconds(3, 1))
    for pod in gone:
        deployment.start()
        deployment.zone.remove(pod.host)
    balancer.await_servers(4)
    load.end(setup, row)


@fault("fleet-dns", "no balancer: clients look the pods up in the DNS; rolling "
                    "restart, and from 1 to 3 and back: no failed call")
def dns(setup, row):
    # As base/settings.env has it: until then clients know of nothing new.
    deployment = Deployment(setup, setup.models(SCENES), *SERVER,
                            "--max-connection-age-s", "60")
    deployment.scale(1)
    load = Load(setup, f"dns://127.0.0.1:{deployment.zone.port}/treeline-pods:"
                       f"{deployment.port}")
    for _ in range(setup.seconds(3, 1)):
        deployment.restart()
    # Or it takes a minute until clients know of the new ones.
    deployment.flags = (*SERVER, "--max-connection-age-s", "2")
    deployment.restart()
    deployment.scale(3)
    wait_until(lambda: all(answers_of(deployment)), "all pods to answer")
    row.figure("answers by pod", answers_of(deployment))
    deployment.scale(1)
    load.end(setup, row)
    row.figure("pods started", len(deployment.exits) + len(deployment.pods))
    row.require("exit codes other than 0",
                sum(code != 0 for code in deployment.exits), "==", 0)


def loads_of(deployment):
    return sum(pod.metrics().sum("treeline_scene_loads_total", result="ok")
               for pod in deployment.pods
               if pod.metrics().has("treeline_scene_loads_total"))


def zipf_lists(setup, count, frames):
    """NAME=ROOT,LIST of so many scenes: the n-th is asked for count / n times
    as often as the last."""
    lines = [line for line in (setup.recording / "test.txt").read_text()
             .splitlines() if line and not line.startswith("#")]
    folder = setup.folder("lists")
    for i in range(count):
        wanted = max(1, round(frames / (1 + i)))
        file = folder / f"{i}.txt"
        file.write_text("\n".join((lines * wanted)[:wanted]) + "\n")
        yield f"room-{i:04}={setup.recording},{file}"


@fault("fleet-sharding", "more scenes than a server has memory for: with the "
                         "balancer's hashing a model is loaded far less often "
                         "than in turn")
def sharding(setup, row):
    pods, count = setup.seconds(20, 4), setup.seconds(200, 24)
    names = [f"room-{i:04}" for i in range(count)]
    models = setup.models(names)
    probe = Deployment(setup, models)
    pod = probe.start()
    bench(setup, [pod], "--duration", "0.3", "--warm-up", "0",
          scenes=names[:1], max_frames=1)
    one = pod.metrics().sum("treeline_scene_resident_bytes")
    probe.stop(pod)
    # Twice its share of the scenes, as hashing shares unevenly.
    budget_mib = int(2 * count / pods * one / (1 << 20)) + 1
    row.figure("servers", pods)
    row.figure("scenes", count)
    row.figure("memory budget of a server (MiB)", budget_mib)
    row.figure("balancer", haproxy_version())
    found = {}
    for name, changes in (("hashed", ()), ("in turn", (
            ("balance hdr(x-treeline-scene)", "balance roundrobin"),
            ("hash-type consistent sdbm avalanche", ""),
            ("hash-balance-factor 200", "")))):
        deployment = Deployment(setup, models, "--workers", "1", "--drain-s",
                                "0", "--memory-budget-mib", budget_mib)
        deployment.scale(pods)
        balancer = Balancer(setup, deployment, *changes)
        found[name] = ask_city(setup, row, name, deployment, balancer, count)
        deployment.scale(0)
        balancer.kill()
    row.require("loads hashed / loads in turn",
                round(found["hashed"] / found["in turn"], 3), "<=", 0.5)


def ask_city(setup, row, name, deployment, balancer, count):
    """Loads for each 1000 answers."""
    scenes = []
    for scene in zipf_lists(setup, count, count):
        scenes += ["--scene", scene]
    load = Bench(setup, balancer.address, *ATTEMPTS, *scenes, "--concurrency",
                 "4", "--no-reference", "--warm-up", "0", "--duration",
                 ENOUGH_S, scenes=(), max_frames=count)
    # Calls and not seconds, or a busy machine would count first loads alone.
    wanted = setup.seconds(5000, 400)
    wait_until(lambda: sum(answers_of(deployment)) >= wanted or
               not load.running(), f"{wanted} answers", 600, 0.2)
    load.send(INT)
    run = load.result()["runs"][0]
    answers, loads = run["counts"]["ok"], loads_of(deployment)
    evictions = sum(pod.metrics().sum("treeline_scene_evictions_total")
                    for pod in deployment.pods
                    if pod.metrics().has("treeline_scene_evictions_total"))
    row.figure(f"{name}: answers", answers)
    row.figure(f"{name}: loads", loads)
    row.figure(f"{name}: evictions", evictions)
    row.figure(f"{name}: p50 and p99 (ms)",
               [run["latency_ms"]["p50"], run["latency_ms"]["p99"]])
    row.require(f"{name}: failed calls", lost(run), "==", 0)
    explain_losses(row, run)
    return 1000 * loads / max(1, answers)
