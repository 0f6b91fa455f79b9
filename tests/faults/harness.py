"""Real programs, and what a fault did to them.

A fault is a function that takes a Setup and a Row: it starts servers and load,
breaks something, and states with row.require() what must hold.
"""

import contextlib
import http.client
import json
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time

# Longer than anything here takes on a busy machine; nothing waits for it to
# pass.
PATIENCE_S = 120


class FaultError(Exception):
    """Why a fault could not be tried at all."""


class Row:
    """What one fault came to: figures, and the requirements on them."""

    def __init__(self, name, claim):
        self.name = name
        self.claim = claim
        self.figures = {}
        self.requirements = []
        self.error = None
        self.seconds = 0.0

    def figure(self, name, value):
        self.figures[name] = value

    def require(self, name, value, relation, limit):
        """value RELATION limit, with a relation of ==, <=, >=, <, >."""
        held = {"==": lambda: value == limit, "<=": lambda: value <= limit,
                ">=": lambda: value >= limit, "<": lambda: value < limit,
                ">": lambda: value > limit}[relation]()
        self.figures[name] = value
        self.requirements.append({"figure": name, "value": value,
                                  "relation": relation, "limit": limit,
                                  "held": bool(held)})

    @property
    def passed(self):
        return (self.error is None and bool(self.requirements) and
                all(r["held"] for r in self.requirements))

    def as_json(self):
        return {"fault": self.name, "claim": self.claim, "passed": self.passed,
                "error": self.error, "seconds": round(self.seconds, 1),
                "requirements": self.requirements, "figures": self.figures}


FAULTS = {}


def fault(name, claim):
    """Registers a function as a fault."""
    def register(function):
        FAULTS[name] = (claim, function)
        return function
    return register


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def wait_until(condition, what, patience_s=PATIENCE_S, step_s=0.02):
    """Polls; returns the seconds it took, or raises FaultError."""
    start = time.monotonic()
    while not condition():
        if time.monotonic() - start > patience_s:
            raise FaultError(f"waited {patience_s} s for {what}")
        time.sleep(step_s)
    return time.monotonic() - start


class Setup:
    """Programs, a learned scene, a folder to work in, processes to end."""

    def __init__(self, programs, scene, work, quick):
        self.programs = pathlib.Path(programs)
        self.scene_folder = pathlib.Path(scene)
        self.work = pathlib.Path(work)
        self.quick = quick
        self.cores = sorted(os.sched_getaffinity(0))
        self._exits = contextlib.ExitStack()
        self._server_help = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._exits.close()

    def program(self, name):
        return str(self.programs / name)

    @property
    def recording(self):
        return self.scene_folder / "recording"

    @property
    def model(self):
        return self.scene_folder / "room.treeline"

    def seconds(self, full, quick):
        return quick if self.quick else full

    def folder(self, prefix):
        return pathlib.Path(tempfile.mkdtemp(prefix=prefix + "-",
                                             dir=self.work))

    def on_exit(self, function, *arguments):
        self._exits.callback(function, *arguments)

    def server_has(self, flag):
        if self._server_help is None:
            self._server_help = subprocess.run(
                [self.program("treeline-server"), "--help"], text=True,
                capture_output=True, check=True).stdout
        return flag in self._server_help

    def need(self, *flags):
        missing = [flag for flag in flags if not self.server_has(flag)]
        if missing:
            raise FaultError("this treeline-server has no "
                             + ", ".join(missing))

    def models(self, scenes=("room",), version="1"):
        """A repository with the learned model as each of these scenes."""
        root = self.folder("models")
        for scene in scenes:
            self.put_model(root, scene, version)
        return root

    def put_model(self, root, scene, version, data=None):
        """Puts a version as an operator should: whole, by a rename."""
        place = pathlib.Path(root) / scene
        place.mkdir(parents=True, exist_ok=True)
        temporary = place / f".new-{version}"
        temporary.mkdir()
        target = temporary / "model.treeline"
        if data is None:
            try:
                os.link(self.model, target)
            except OSError:
                shutil.copyfile(self.model, target)
        else:
            target.write_bytes(data)
        temporary.rename(place / version)

    def split_cores(self):
        """(for the server, for the load); all to both on a single core."""
        if len(self.cores) < 2:
            return self.cores, self.cores
        half = len(self.cores) // 2
        return self.cores[:half], self.cores[half:]


class Program:
    """A child process; ended with the Setup."""

    def __init__(self, setup, command, cpus=None, environment=None,
                 preexec=None):
        self.command = [str(part) for part in command]
        self._log = tempfile.TemporaryFile(mode="w+", dir=setup.work)

        def prepare():
            if cpus:
                os.sched_setaffinity(0, cpus)
            if preexec:
                preexec()

        self.process = subprocess.Popen(
            self.command, stdout=subprocess.PIPE, stderr=self._log, text=True,
            env=environment, preexec_fn=prepare)
        setup.on_exit(self.kill)

    @property
    def pid(self):
        return self.process.pid

    def running(self):
        return self.process.poll() is None

    def send(self, number):
        if self.running():
            self.process.send_signal(number)

    def kill(self):
        if self.running():
            # Of a stopped process, too.
            self.process.kill()
        self.process.wait()

    def wait(self, patience_s=PATIENCE_S):
        return self.process.wait(patience_s)

    def log(self):
        self._log.seek(0)
        return self._log.read()


class Server(Program):
    """treeline-server, serving."""

    def __init__(self, setup, models, *more, port=None, cpus=None, wrap=(),
                 listen_others=True, environment=None, preexec=None,
                 host="127.0.0.1", http_port=None):
        self.setup = setup
        self.host = host
        self.port = port or free_port()
        self.address = f"{host}:{self.port}"
        # None: the environment names them.
        named = [] if models is None else ["--models", models]
        command = [*wrap, setup.program("treeline-server"), *named, "--listen",
                   self.address, *more]
        self.http_port = self.admin_port = None
        # Else every server would want the same default ports.
        if setup.server_has("--http-listen"):
            if listen_others:
                self.http_port = http_port or free_port()
            command += ["--http-listen", f"{host}:{self.http_port}"
                        if self.http_port else ""]
        if setup.server_has("--admin-listen"):
            self.admin_port = free_port() if listen_others else None
            command += ["--admin-listen", f"{host}:{self.admin_port}"
                        if self.admin_port else ""]
        super().__init__(setup, command, cpus=cpus, environment=environment,
                         preexec=preexec)
        self._serving = threading.Event()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        wait_until(lambda: self._serving.is_set() or not self.running(),
                   "treeline-server to serve")
        if not self._serving.is_set():
            raise FaultError("treeline-server ended: " + self.log()[-2000:])

    def _read(self):
        for line in self.process.stdout:
            if re.match(rf"listening on \S*:{self.port}\b", line):
                self._serving.set()

    def again(self, *more, **options):
        """Another one in its place, once it has ended."""
        return Server(self.setup, self.command[self.command.index("--models")
                                               + 1],
                      *more, port=self.port, **options)

    def get(self, path, timeout_s=10):
        connection = http.client.HTTPConnection(self.host, self.http_port,
                                                timeout=timeout_s)
        try:
            connection.request("GET", path)
            answer = connection.getresponse()
            return answer.status, answer.read().decode()
        finally:
            connection.close()

    def metrics(self):
        if self.http_port is None:
            raise FaultError("this treeline-server has no --http-listen, and "
                             "so no metrics")
        status, text = self.get("/metrics")
        if status != 200:
            raise FaultError(f"/metrics answered {status}")
        return Metrics(text)

    def status_kib(self, key):
        """A line of /proc/PID/status, in KiB: VmRSS, VmHWM."""
        text = pathlib.Path(f"/proc/{self.pid}/status").read_text()
        return int(re.search(rf"^{key}:\s+(\d+) kB", text, re.M).group(1))

    def open_files(self):
        return len(os.listdir(f"/proc/{self.pid}/fd"))


class Metrics:
    """What /metrics said."""

    SAMPLE = re.compile(r'^([a-zA-Z_:][a-zA-Z0-9_:]*)(?:\{(.*)\})?\s+(\S+)')
    LABEL = re.compile(r'([a-zA-Z_][a-zA-Z0-9_]*)="((?:[^"\\]|\\.)*)"')

    def __init__(self, text):
        self.samples = []
        for line in text.splitlines():
            if not line or line.startswith("#"):
                continue
            match = self.SAMPLE.match(line)
            if not match:
                raise FaultError(f"not Prometheus text: {line!r}")
            labels = dict(self.LABEL.findall(match.group(2) or ""))
            self.samples.append((match.group(1), labels,
                                 float(match.group(3))))

    def has(self, name):
        return any(sample[0] == name for sample in self.samples)

    def sum(self, name, **labels):
        """Over all samples with these labels."""
        if not self.has(name):
            raise FaultError(f"/metrics has no {name}")
        return sum(value for sample, given, value in self.samples
                   if sample == name and
                   all(given.get(k) == v for k, v in labels.items()))

    def by(self, name, *keys):
        """Sums of a metric by the values of these labels."""
        sums = {}
        for sample, given, value in self.samples:
            if sample == name:
                key = tuple(given.get(k, "") for k in keys)
                sums[key] = sums.get(key, 0) + value
        return sums


class Bench(Program):
    """treeline-client bench, running."""

    def __init__(self, setup, servers, *more, scenes=("room",), cpus=None,
                 environment=None, max_frames=16):
        if not isinstance(servers, str):
            servers = ",".join(s.address for s in servers)
        command = [setup.program("treeline-client"), "bench", "--json",
                   "--server", servers, "--max-frames", max_frames]
        for scene in scenes:
            command += ["--scene", f"{scene}={setup.recording}"]
        super().__init__(setup, [*command, *more], cpus=cpus,
                         environment=environment)

    def result(self):
        """The JSON object; FaultError if there is none."""
        out, _ = self.process.communicate(timeout=PATIENCE_S + 3600)
        try:
            return json.loads(out)
        except json.JSONDecodeError as error:
            raise FaultError("treeline-client bench: exit code "
                             f"{self.process.returncode}: {self.log()[-2000:]}"
                             ) from error


def bench(setup, servers, *more, **options):
    return Bench(setup, servers, *more, **options).result()


def calls(result):
    """{(code, reason): count} of all calls that the client made."""
    return {(c["code"], c["reason"] or ""): c["count"]
            for c in result["all_calls"]}


def lost(run):
    """Calls of a run that were not answered."""
    return sum(run["counts"].values()) - run["counts"]["ok"]


def explain_losses(row, run):
    """Which errors there were, for whoever reads the row."""
    errors = [f'{o["count"]} x {o["code"]} {o["reason"] or o["example"] or ""}'
              for o in run["outcomes"] if o["code"] != "OK"]
    if errors:
        row.figure("errors", "; ".join(errors))


def worst_p99(run, begin_s, end_s):
    """The largest p99 of the intervals that lie in [begin, end)."""
    values = [i["p99_ms"] for i in run["intervals"]
              if begin_s <= i["at_s"] < end_s and i["ok"] > 0]
    if not values:
        raise FaultError(f"no answers between {begin_s} and {end_s} s")
    return max(values)


def client(setup, command, server, *more, environment=None):
    """treeline-client COMMAND to its end."""
    return subprocess.run(
        [setup.program("treeline-client"), command, "--server", server,
         *[str(m) for m in more]],
        text=True, capture_output=True, check=False, timeout=PATIENCE_S,
        env=environment)


def first_frame(setup):
    """The files of one held-out frame."""
    stem = next(line for line in
                (setup.recording / "test.txt").read_text().split("\n")
                if line and not line.startswith("#"))
    color = setup.recording / f"{stem}.color.jpg"
    if not color.exists():
        color = setup.recording / f"{stem}.color.png"
    return color, setup.recording / f"{stem}.depth.png"


INT, TERM, KILL, STOP, CONT = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL,
                               signal.SIGSTOP, signal.SIGCONT)
