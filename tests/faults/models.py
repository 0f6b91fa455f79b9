"""Models that are replaced, broken, too many, or do not fit on the disk."""

import hashlib
import http.server
import json
import os
import pathlib
import signal
import threading
import time

from harness import (Bench, FaultError, Server, bench, client, explain_losses,
                     fault, first_frame, lost, wait_until)

POLL = ("--poll-s", "1")


def steady_rate(setup, server, share):
    """A share of what a closed loop gets."""
    run = bench(setup, [server], "--concurrency", "4", "--no-reference",
                "--duration", setup.seconds(4, 2))["runs"][0]
    return share * run["answers_per_s"]


@fault("model-swap", "a new version appears under load: no error, and no p99 "
                     "over twice the usual")
def model_swap(setup, row):
    setup.need("--poll-s")
    models = setup.models()
    server = Server(setup, models, *POLL)
    rate = steady_rate(setup, server, 0.4)
    part_s = setup.seconds(8, 4)
    load = Bench(setup, [server], "--rate", rate, "--interval-s", part_s,
                 "--duration", 3 * part_s)
    # In the middle of the second of three parts.
    time.sleep(1 + 1.25 * part_s)
    setup.put_model(models, "room", "2")
    run = load.result()["runs"][0]
    parts = run["intervals"]
    if len(parts) < 3:
        raise FaultError(f"only {len(parts)} of 3 parts have answers")
    row.figure("rate_per_s", round(rate, 1))
    row.figure("answered_by", run["answered_by"])
    row.figure("p99 before (ms)", parts[0]["p99_ms"])
    row.figure("p99 after (ms)", parts[2]["p99_ms"])
    row.require("errors", lost(run), "==", 0)
    row.require("wrong answers", run["checks"]["different"], "==", 0)
    row.require("answers by the old version",
                run["answered_by"].get("room/1", 0), ">", 0)
    row.require("answers by the new version",
                run["answered_by"].get("room/2", 0), ">", 0)
    row.require("p99 around the swap (ms)", parts[1]["p99_ms"], "<=",
                round(2 * max(parts[0]["p99_ms"], parts[2]["p99_ms"]), 3))
    explain_losses(row, run)


def broken_models(data):
    """Name and bytes of what is no model, or not one that can be read."""
    middle = len(data) // 2
    yield "empty", b""
    yield "truncated", data[:middle]
    yield "one byte short", data[:-1]
    yield "one byte more", data + b"\0"
    yield "not a model", os.urandom(4096)
    yield "zeros behind the half", data[:middle] + bytes(len(data) - middle)
    # Byte 9 is of the format's version (docs/reference/model-format.md): it
    # looks newer than it is.
    for name, at in (("version", 9), ("header", 20), ("quarter", len(data) // 4),
                     ("middle", middle), ("end", len(data) - 5)):
        flipped = bytearray(data)
        flipped[at] ^= 0x10
        yield f"bit flipped: {name}", bytes(flipped)


@fault("broken-models", "corrupt, truncated and bit-flipped versions are "
                        "refused with DATA_LOSS; the old one goes on serving")
def refused_models(setup, row):
    setup.need("--poll-s", "--admin-listen")
    models = setup.models()
    server = Server(setup, models, *POLL)
    admin = f"127.0.0.1:{server.admin_port}"
    load = Bench(setup, [server], "--concurrency", "2", "--duration",
                 setup.seconds(20, 10))
    time.sleep(1.5)
    refused, wrong = 0, []
    for i, (name, data) in enumerate(
            broken_models(setup.model.read_bytes())):
        version = str(2 + i)
        setup.put_model(models, "room", version, data)
        answer = client(setup, "scenes", admin, "--scene", "room", "--load",
                        "--model-version", version)
        code = ("FAILED_PRECONDITION" if name.endswith("version")
                else "DATA_LOSS")
        if answer.returncode == 1 and code in answer.stderr:
            refused += 1
        else:
            wrong.append(f"{name}: {(answer.stderr or answer.stdout)[:200]}")
    under_load = load.running()
    run = load.result()["runs"][0]
    if wrong:
        row.figure("not refused as it should be", wrong)
    row.figure("answers", run["counts"]["ok"])
    row.require("broken models", refused + len(wrong), ">", 5)
    row.require("refused as they should be", refused, "==",
                refused + len(wrong))
    row.require("failed calls", lost(run), "==", 0)
    row.require("answers by other versions",
                sum(n for by, n in run["answered_by"].items()
                    if by != "room/1"), "==", 0)
    row.require("all of it under load", under_load, "==", True)
    explain_losses(row, run)


def serve_folder(setup, folder):
    """An HTTP server on loopback; its port."""
    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_):
            pass

    def handler(*arguments):
        return Quiet(*arguments, directory=str(folder))

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    setup.on_exit(server.shutdown)
    return server.server_address[1]


def publish(folder, names, data):
    """An index of different models: the same scene, but not the same file."""
    models = []
    for name in names:
        (folder / f"{name}.treeline").write_bytes(data)
        models.append({"scene": name, "version": "1", "bytes": len(data),
                       "sha256": hashlib.sha256(data).hexdigest(),
                       "url": f"{name}.treeline"})
    (folder / "index.json").write_text(json.dumps({"models": models}))


def ignore_file_size_signal():
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)


@fault("disk-full", "the cache's disk is full: the fetched scene fails, the "
                    "server serves on, and recovers when there is room")
def disk_full(setup, row):
    setup.need("--cache")
    web, cache = setup.folder("web"), setup.folder("cache")
    data = setup.model.read_bytes()
    publish(web, ["room"], data)
    # A file system of its own, seen by the server alone, with room for half of
    # the model.
    size = len(data) + (2 << 20)
    script = (f'mount -t tmpfs -o size={size} tmpfs "{cache}" && '
              f'head -c {size - len(data) // 2} /dev/zero > "{cache}/filler" '
              '&& exec "$@"')
    wrap = ("unshare", "--mount", "--map-root-user", "sh", "-c", script, "sh")
    server = Server(setup, f"http://127.0.0.1:{serve_folder(setup, web)}/",
                    "--cache", cache, *POLL, wrap=wrap,
                    preexec=ignore_file_size_signal)
    color, depth = first_frame(setup)
    ask = ("--scene", "room", "--color", color, "--depth", depth)
    full = client(setup, "localize", server.address, *ask)
    row.figure("answer while it is full", full.stderr.strip()[:200])
    listed = client(setup, "scenes", server.address)
    filler = pathlib.Path(f"/proc/{server.pid}/root{cache}/filler")
    filler.unlink()

    def localized():
        return client(setup, "localize", server.address,
                      *ask).returncode == 0
    recovered_s = wait_until(localized, "the scene once there is room", 30, 0.2)
    row.require("exit code of localize while it is full", full.returncode,
                "==", 1)
    row.require("error is RESOURCE_EXHAUSTED or UNAVAILABLE",
                "RESOURCE_EXHAUSTED" in full.stderr or
                "UNAVAILABLE" in full.stderr, "==", True)
    row.require("exit code of scenes while it is full", listed.returncode,
                "==", 0)
    row.require("seconds to recover", round(recovered_s, 2), "<=", 10)
    row.require("server running", server.running(), "==", True)
    leftovers = [p.name for p in filler.parent.rglob("*")
                 if ".tmp" in p.name or ".part" in p.name]
    row.require("left-over temporary files", len(leftovers), "==", 0)


@fault("many-scenes", "100 scenes in a memory budget for 10: every query is "
                      "answered, and the budget holds")
def many_scenes(setup, row):
    setup.need("--memory-budget-mib", "--http-listen")
    count, fit = setup.seconds(100, 30), setup.seconds(10, 3)
    scenes = [f"room-{i:03}" for i in range(count)]
    # The model's own size decides what a budget for ten of them is.
    probe = Server(setup, setup.models())
    bench(setup, [probe], "--duration", "0.3", "--warm-up", "0",
          max_frames=1)
    one = probe.metrics().sum("treeline_scene_resident_bytes")
    probe.kill()
    row.figure("resident bytes of one scene", one)
    row.require("a loaded scene has a size", one, ">", 0)
    budget_mib = max(1, int(fit * one / (1 << 20)) + 1)
    server = Server(setup, setup.models(scenes), "--memory-budget-mib",
                    budget_mib)
    load = Bench(setup, [server], "--concurrency", "4", "--no-reference",
                 "--duration", setup.seconds(15, 5), scenes=scenes,
                 max_frames=1)
    largest = 0
    while load.running():
        largest = max(largest, server.metrics().sum(
            "treeline_scene_resident_bytes"))
        time.sleep(0.2)
    run = load.result()["runs"][0]
    metrics = server.metrics()
    row.figure("scenes", count)
    row.figure("answers", run["counts"]["ok"])
    row.figure("p50_ms", run["latency_ms"]["p50"])
    row.figure("p99_ms", run["latency_ms"]["p99"])
    row.figure("loads", metrics.sum(
        "treeline_scene_loads_total", result="ok"))
    row.require("evictions",
                metrics.sum("treeline_scene_evictions_total"), ">", 0)
    row.require("scenes that answered", len(run["answered_by"]), "==", count)
    row.require("failed calls", lost(run), "==", 0)
    row.require("largest resident MiB", round(largest / (1 << 20), 2), "<=",
                budget_mib)
    explain_losses(row, run)
