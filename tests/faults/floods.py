"""HTTP/2 floods: frames by the hundred thousand, beside honest clients."""

import os
import pathlib
import threading
import time

import http2_attack as attack
from clients import Authority, Credentials, day
from cluster import Balancer, Deployment, haproxy_version
from harness import (Bench, Server, bench, explain_losses, fault, lost,
                     wait_until)

# Loopback addresses of those who attack; honest clients have 127.0.0.1.
ATTACKERS = tuple(f"127.0.0.{i}" for i in range(2, 6))
HONEST_RATE = 10
# What is sent, how it is paced (per second; None: as fast as it goes), on how
# many connections, and over TLS.
FLOODS = {
    "resets": (attack.resets, None, 1, False),
    "resets over TLS": (attack.resets, None, 1, True),
    "resets with data": (attack.resets_after_data, None, 1, False),
    "resets with 16 KiB": (attack.resets_after_payload, None, 1, False),
    "resets on 12 connections": (attack.resets, None, 12, False),
    "resets at 1000/s": (attack.resets, 1000, 1, False),
    "calls without end": (attack.calls_without_end, None, 1, False),
    "calls without end at 300/s": (attack.calls_without_end, 300, 1, False),
    "empty calls": (attack.empty_calls, None, 1, False),
    "empty calls over TLS": (attack.empty_calls, None, 1, True),
    "SETTINGS": (attack.settings, None, 1, False),
    "SETTINGS over TLS": (attack.settings, None, 1, True),
    "PING": (attack.pings, None, 1, False),
    "PRIORITY": (attack.priorities, None, 1, False),
    "WINDOW_UPDATE": (attack.window_updates, None, 1, False),
    "unknown frames": (attack.unknown_frames, None, 1, False),
    "RST_STREAM of old streams": (attack.late_resets, None, 1, False),
    "empty DATA": (attack.empty_data, None, 1, False),
    "DATA of one byte": (attack.crumbs, None, 1, False),
    "CONTINUATION": (attack.continuations, None, 1, False),
    "CONTINUATION over TLS": (attack.continuations, None, 1, True),
    "empty CONTINUATION": (attack.empty_continuations, None, 1, False),
    "repeated headers": (attack.repeated_headers, None, 1, False),
    "headers that fill the table": (attack.table_churn, None, 1, False),
}
QUICK = ("resets", "resets over TLS")


def processor_s(server):
    fields = pathlib.Path(f"/proc/{server.pid}/stat").read_text().rsplit(
        ")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Flood:
    """Attackers who come back as often as they are cut off, until stopped."""

    def __init__(self, address, kind, authority):
        make, per_s, connections, tls = kind
        self.sent = 0
        self.cuts = 0
        self._stop = threading.Event()
        self._lock = threading.Lock()
        self._address = address
        self._authority = authority if tls else None
        self._make = make
        self._per_s = per_s
        self._threads = [
            threading.Thread(target=self._run,
                             args=(ATTACKERS[i % len(ATTACKERS)],))
            for i in range(connections)]
        for thread in self._threads:
            thread.start()

    def _run(self, source):
        while not self._stop.is_set():
            try:
                one = attack.Attack(self._address, self._make,
                                    self._authority, source=source)
            except OSError:
                one = None
            if one is not None:
                while not self._stop.is_set() and self._send(one):
                    pass
                one.close()
            with self._lock:
                self.sent += one.index if one else 0
                self.cuts += 1
            # Or the attackers would take the processors of this machine
            # themselves.
            self._stop.wait(0.02)

    def _send(self, one):
        if self._per_s is not None:
            return one.send_paced(self._per_s, 0.2)
        return one.send(2000)

    def stop(self):
        self._stop.set()
        for thread in self._threads:
            thread.join()


def flooded(setup, server, kind, authority, trust):
    """(run of honest clients, flood, processors, MiB at the peak that the
    server had not when it began to serve)."""
    _, others = setup.split_cores()
    # The attackers are threads of this process.
    os.sched_setaffinity(0, others)
    seconds = setup.seconds(5, 2)
    pathlib.Path(f"/proc/{server.pid}/clear_refs").write_text("5")
    spent, start = processor_s(server), time.monotonic()
    flood = Flood(server.address, kind, authority) if kind else None
    run = bench(setup, [server], *trust, "--rate", HONEST_RATE, "--duration",
                seconds, "--warm-up", "0.5", "--no-reference", cpus=others)["runs"][0]
    if flood:
        flood.stop()
    os.sched_setaffinity(0, setup.cores)
    # A server that has fallen behind still works.
    spent_s, took_s = processor_s(server) - spent, time.monotonic() - start
    peak_mib = (server.status_kib("VmHWM") - server.began_kib) / 1024
    return run, flood, spent_s / took_s, peak_mib


def p99_of(run):
    latency = run["latency_ms"]
    return latency["p99"] if latency else float("inf")


def guarded_servers(setup):
    """Over TCP, or over TLS; (server, authority, flags for clients)."""
    authority = Authority(setup.folder("ca"))
    credentials = Credentials(setup.folder("tls"))
    credentials.put(authority.issue("flooded", -60, day()))
    cpus, _ = setup.split_cores()
    servers = (Server(setup, setup.models(), cpus=cpus),
               Server(setup, setup.models(), *credentials.flags(), cpus=cpus))
    for server in servers:
        # With its scene.
        bench(setup, [server], *(("--tls-ca", authority.ca)
                                 if server is servers[1] else ()),
              "--duration", "0.5", "--no-reference")
        server.began_kib = server.status_kib("VmRSS")
    return *servers, authority.ca


@fault("http2-floods", "frames without queries, as many as can be sent: honest "
                       "clients are answered as before, and little memory "
                       "is taken")
def floods(setup, row):
    setup.need("--flood-limit")
    begun = time.monotonic()
    tcp, tls, authority = guarded_servers(setup)
    usual, _, usual_cpus, _ = flooded(setup, tcp, None, None, ())
    usual_p99 = p99_of(usual)
    row.figure("p99 before (ms)", usual_p99)
    for name in QUICK if setup.quick else FLOODS:
        kind = FLOODS[name]
        server, trust = (tls, ("--tls-ca", authority)) if kind[3] else (tcp, ())
        run, flood, cpus, peak_mib = flooded(setup, server, kind, authority,
                                             trust)
        row.figure(f"{name}: sent, cut", f"{flood.sent}, {flood.cuts}")
        row.require(f"{name}: lost calls", lost(run), "==", 0)
        if setup.quick:
            row.figure(f"{name}: p99 (ms)", p99_of(run))
        else:
            # Each address has an allowance of its own, which takes the
            # server some hundredths of a second at once.
            slack_ms = 100 * min(kind[2], len(ATTACKERS))
            row.require(f"{name}: p99 (ms)", p99_of(run), "<=",
                        round(max(2 * usual_p99, usual_p99 + slack_ms), 1))
        row.require(f"{name}: MiB more", round(peak_mib, 1), "<=", 256)
        row.require(f"{name}: processors more", round(cpus - usual_cpus, 2),
                    "<=", 0.75)
        explain_losses(row, run)
    cuts = tcp.metrics().by("treeline_grpc_connections_cut_total", "reason")
    row.figure("connections cut", {k[0]: int(v) for k, v in cuts.items() if v})
    row.require("kinds of attack that were cut",
                sum(1 for v in cuts.values() if v), ">=", 2)
    wait_until(lambda: "cut off 127.0.0." in tcp.log(), "the log to say so")
    row.require("lines of the log", tcp.log().count("cut off 127.0.0."), "<=",
                1 + time.monotonic() - begun)


@fault("http2-floods-balanced", "resets through haproxy: it limits their "
                                "address, and its own connections stay")
def balanced(setup, row):
    row.figure("balancer", haproxy_version())
    deployment = Deployment(setup, setup.models(), "--workers", "1")
    deployment.scale(2)
    balancer = Balancer(setup, deployment)
    load = Bench(setup, balancer.address, "--rate", HONEST_RATE, "--attempts",
                 "4", "--no-reference", "--duration", setup.seconds(8, 4))
    time.sleep(1)
    flood = Flood(balancer.address, FLOODS["resets"], None)
    run = load.result()["runs"][0]
    flood.stop()
    row.figure("sent, cut", f"{flood.sent}, {flood.cuts}")
    row.figure("p99 (ms)", p99_of(run))
    row.require("failed calls", lost(run), "==", 0)
    row.require("connections of the balancer that were cut", sum(
        pod.metrics().sum("treeline_grpc_connections_cut_total")
        for pod in deployment.pods), "==", 0)
    row.require("resets that were sent", flood.sent, ">", 2000)
    explain_losses(row, run)


@fault("flood-lookalikes", "clients that give up, watch and wait a lot are no "
                           "flood: nobody is cut off")
def lookalikes(setup, row):
    setup.need("--flood-limit")
    server = Server(setup, setup.models(), "--workers", "1")
    seconds = setup.seconds(8, 3)
    # Ten of them, each 30 times a second; most are cancelled within 20 ms.
    impatient = Bench(setup, [server], "--rate", 10 * 30, "--cancel-share",
                      "0.9", "--cancel-after-ms", "20", "--no-reference",
                      "--duration", seconds)
    busy = Bench(setup, [server], "--concurrency", "32", "--no-reference",
                 "--duration", seconds)
    stream = Bench(setup, [server], "--concurrency", "4", "--stream", "4",
                   "--no-reference", "--duration", seconds)
    watchers = [attack.Attack(server.address, watch) for _ in range(100)]
    for watcher in watchers:
        watcher.send(1)
    # gRPC allows a ping every 5 s.
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        time.sleep(0.2)
    pinged = sum(watcher.send(1) for watcher in watchers)
    time.sleep(1)
    for name, load in (("impatient", impatient), ("busy", busy),
                       ("stream", stream)):
        run = load.result()["runs"][0]
        row.figure(f"{name}: calls", run["counts"])
        if load is impatient:
            row.require("cancelled calls", run["counts"]["cancelled"], ">",
                        100)
        row.require(f"{name}: failed", run["counts"]["failed"], "==", 0)
    row.require("watchers that are still there", pinged, "==", len(watchers))
    row.require("watchers cut off", sum(watcher.wait_cut(0.01)
                                        for watcher in watchers), "==", 0)
    cut = server.metrics().sum("treeline_grpc_connections_cut_total")
    row.require("connections cut", cut, "==", 0)


def watch(calls, _):
    """grpc.health.v1.Health/Watch once, then pings."""
    if calls.stream > 0:
        return attack.frame(attack.PING, 0, 0, bytes(8))
    calls.path = "/grpc.health.v1.Health/Watch"
    return calls.open() + attack.frame(attack.DATA, attack.END_STREAM, 1,
                                       bytes(5))
