"""Certificates that expire and change, and clients that misbehave."""

import os
import socket
import struct
import subprocess
import threading
import time
import zlib

from harness import (Bench, FaultError, Server, bench, client, explain_losses,
                     fault, first_frame, lost, wait_until)


class Authority:
    """Makes certificates with the openssl program."""

    def __init__(self, folder):
        self.folder = folder
        self.ca = folder / "ca.pem"
        self._count = 0
        self._run("req", "-x509", "-newkey", "ec", "-pkeyopt",
                  "ec_paramgen_curve:prime256v1", "-nodes", "-subj",
                  "/CN=Fault suite", "-days", "2", "-keyout", "ca.key", "-out",
                  "ca.pem")
        (folder / "ca.cnf").write_text(
            "[ca]\ndefault_ca=d\n[d]\ndir=.\ndatabase=index.txt\n"
            "new_certs_dir=.\nserial=serial\ndefault_md=sha256\npolicy=p\n"
            "copy_extensions=none\nunique_subject=no\n[p]\n"
            "commonName=supplied\n[server]\n"
            "subjectAltName=DNS:localhost,IP:127.0.0.1\n")
        (folder / "index.txt").write_text("")
        (folder / "serial").write_text("1000\n")

    def _run(self, *arguments):
        done = subprocess.run(["openssl", *arguments], cwd=self.folder,
                              text=True, capture_output=True, check=False)
        if done.returncode != 0:
            raise FaultError(f"openssl {arguments[0]}: {done.stderr[-500:]}")

    def issue(self, name, begin_s, end_s):
        """(certificate, key) for 127.0.0.1, valid from now + begin_s to now +
        end_s; both as text."""
        self._count += 1
        key, request = f"{self._count}.key", f"{self._count}.csr"
        out = f"{self._count}.pem"
        self._run("req", "-new", "-newkey", "ec", "-pkeyopt",
                  "ec_paramgen_curve:prime256v1", "-nodes", "-subj",
                  f"/CN={name}", "-keyout", key, "-out", request)

        def utc(seconds):
            return time.strftime("%Y%m%d%H%M%SZ",
                                 time.gmtime(time.time() + seconds))
        self._run("ca", "-batch", "-config", "ca.cnf", "-cert", "ca.pem",
                  "-keyfile", "ca.key", "-in", request, "-out", out, "-notext",
                  "-extensions", "server", "-startdate", utc(begin_s),
                  "-enddate", utc(end_s))
        return ((self.folder / out).read_text(),
                (self.folder / key).read_text())


class Credentials:
    """cert.pem and key.pem, which change together: a link is swapped."""

    def __init__(self, folder):
        self.folder = folder
        self.link = folder / "current"
        self._count = 0

    def put(self, pair):
        self._count += 1
        place = self.folder / f"pair-{self._count}"
        place.mkdir()
        for name, text in zip(("cert.pem", "key.pem"), pair):
            (place / name).write_text(text)
        new = self.folder / "new"
        os.symlink(place.name, new)
        new.rename(self.link)

    def flags(self):
        return ("--tls-cert", self.link / "cert.pem", "--tls-key",
                self.link / "key.pem")


class Newcomers:
    """New connections, one after the other, until stopped."""

    def __init__(self, setup, server, *flags):
        self.results = []  # (time, whether it was answered, what was said)
        self._stop = threading.Event()

        def run():
            while not self._stop.is_set():
                answer = client(setup, "scenes", server.address, *flags,
                                "--timeout-s", "3")
                self.results.append((time.time(), answer.returncode == 0,
                                     answer.stderr.strip()[:200]))
                self._stop.wait(0.1)
        self._thread = threading.Thread(target=run)
        self._thread.start()

    def stop(self):
        self._stop.set()
        self._thread.join()
        return self.results


def day(hours=24):
    return hours * 3600


@fault("certificate-rotation", "the certificate is replaced under load: no "
                               "failure, neither of old nor of new connections")
def rotation(setup, row):
    setup.need("--tls-cert", "--tls-key")
    authority = Authority(setup.folder("ca"))
    credentials = Credentials(setup.folder("tls"))
    credentials.put(authority.issue("first", -60, day()))
    server = Server(setup, setup.models(), *credentials.flags())
    trust = ("--tls-ca", authority.ca)
    load = Bench(setup, [server], *trust, "--concurrency", "2", "--duration",
                 setup.seconds(12, 7))
    newcomers = Newcomers(setup, server, *trust)
    time.sleep(2)
    before = subject(server)
    swapped = time.monotonic()
    credentials.put(authority.issue("second", -60, day()))
    wait_until(lambda: "second" in subject(server), "the new certificate", 30)
    served_s = time.monotonic() - swapped
    run = load.result()["runs"][0]
    results = newcomers.stop()
    row.figure("calls", run["calls"])
    row.figure("new connections", len(results))
    row.require("first certificate at first", "first" in before, "==", True)
    row.require("seconds until the new one is served", round(served_s, 2),
                "<=", 5)
    row.require("failed calls", lost(run), "==", 0)
    row.require("failed new connections", sum(not r[1] for r in results), "==",
                0)
    explain_losses(row, run)


def subject(server):
    """Subject of the certificate that a new connection is shown."""
    done = subprocess.run(
        ["openssl", "s_client", "-connect", server.address, "-alpn", "h2"],
        input=b"", capture_output=True, check=False, timeout=20)
    text = done.stdout.decode(errors="replace")
    return next((line for line in text.splitlines()
                 if line.startswith("subject=")), "")


@fault("certificate-expired", "an expired certificate is refused; within 5 s "
                              "of its renewal nothing fails")
def expired(setup, row):
    setup.need("--tls-cert", "--tls-key")
    authority = Authority(setup.folder("ca"))
    credentials = Credentials(setup.folder("tls"))
    credentials.put(authority.issue("old", -day(), -60))
    server = Server(setup, setup.models(), *credentials.flags())
    newcomers = Newcomers(setup, server, "--tls-ca", authority.ca)
    time.sleep(2)
    renewed = time.time()
    credentials.put(authority.issue("renewed", -60, day()))
    time.sleep(5 + setup.seconds(4, 2))
    results = newcomers.stop()
    early = [r for r in results if r[0] < renewed]
    late = [r for r in results if r[0] >= renewed + 5]
    recovered = [r[0] - renewed for r in results if r[1]]
    row.require("answers with an expired certificate",
                sum(r[1] for r in early), "==", 0)
    row.require("tries with an expired certificate", len(early), ">", 0)
    row.require("tries from 5 s after the renewal", len(late), ">", 0)
    row.require("failures from 5 s after the renewal",
                sum(not r[1] for r in late), "==", 0)
    row.figure("seconds to the first answer",
               round(min(recovered), 2) if recovered else None)


def crawl(port, first_bytes, count):
    """Connections that send a beginning and then a byte now and then."""
    connections = []
    for _ in range(count):
        try:
            connection = socket.create_connection(("127.0.0.1", port), 5)
            connection.sendall(first_bytes)
            connection.setblocking(False)
            connections.append(connection)
        except OSError:
            break
    return connections


def drip(connections, seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        for connection in connections:
            try:
                connection.send(b"a")
            except OSError:
                pass
        time.sleep(0.5)


@fault("slow-loris", "hundreds of connections that never finish a request: "
                     "others are answered as before")
def slow_loris(setup, row):
    setup.need("--http-listen")
    server = Server(setup, setup.models())
    # Three parts: before, meanwhile, after.
    hold_s = setup.seconds(10, 4)
    rate = 0.3 * bench(setup, [server], "--concurrency", "4", "--no-reference",
                       "--duration", "2")["runs"][0]["answers_per_s"]
    files = server.open_files()
    load = Bench(setup, [server], "--rate", rate, "--interval-s", hold_s,
                 "--duration", 3 * hold_s)
    time.sleep(1 + hold_s)
    count = setup.seconds(300, 100)
    crawlers = crawl(server.port, b"PRI * HTTP/2.0\r\n", count)
    crawlers += crawl(server.http_port,
                      b"POST /treeline.v1.SceneService/ListScenes HTTP/1.1\r\n"
                      b"Host: x\r\nX: ", count)
    health = []

    def watch():
        for _ in range(int(hold_s)):
            start = time.monotonic()
            try:
                health.append((server.get("/healthz", 5)[0],
                               time.monotonic() - start))
            except OSError as error:
                health.append((str(error), time.monotonic() - start))
            time.sleep(0.5)
    watcher = threading.Thread(target=watch)
    watcher.start()
    drip(crawlers, hold_s)
    watcher.join()
    for connection in crawlers:
        connection.close()
    run = load.result()["runs"][0]
    p99 = [part["p99_ms"] for part in run["intervals"]]
    usual = max(p99[0], p99[2])
    row.figure("slow connections", len(crawlers))
    row.figure("p99 before and after (ms)", [p99[0], p99[2]])
    row.require("failed calls", lost(run), "==", 0)
    row.require("p99 meanwhile (ms)", p99[1], "<=",
                round(max(2 * usual, usual + 20), 3))
    row.require("health checks that failed",
                sum(h[0] != 200 for h in health), "==", 0)
    row.require("slowest health check (s)",
                round(max(h[1] for h in health), 3), "<=", 1)
    time.sleep(1)
    wait_until(lambda: server.open_files() <= files + 16,
               "the connections to be closed", 30, 0.2)
    row.figure("open files before and after",
               f"{files}, {server.open_files()}")
    explain_losses(row, run)


def png_bomb(width, height):
    """A PNG that claims so many pixels, all of one colour."""
    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data +
                struct.pack(">I", zlib.crc32(kind + data)))
    pack = zlib.compressobj(9)
    rows = b"".join(pack.compress(bytes(1 + 3 * width))
                    for _ in range(height)) + pack.flush()
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) +
            chunk(b"IDAT", rows) + chunk(b"IEND", b""))


@fault("oversize-clients", "messages, bodies and images that are too large "
                           "are refused early, and cost little memory")
def oversize(setup, row):
    setup.need("--http-listen")
    server = Server(setup, setup.models(), "--max-message-mib", "8")
    folder = setup.folder("oversize")
    color, depth = first_frame(setup)
    bench(setup, [server], "--duration", "1", "--concurrency", "4")
    before = server.status_kib("VmHWM")
    load = Bench(setup, [server], "--concurrency", "2", "--duration",
                 setup.seconds(8, 5))
    time.sleep(1.5)
    large = folder / "large.jpg"
    large.write_bytes(color.read_bytes() + bytes(24 << 20))
    bomb = folder / "bomb.png"
    bomb.write_bytes(png_bomb(8192, 8192))
    answers = {}
    for name, path in (("message of 24 MiB", large), ("67 megapixels", bomb)):
        answer = client(setup, "localize", server.address, "--scene", "room",
                        "--color", path, "--depth", depth,
                        "--max-message-mib", "64")
        answers[name] = answer.stderr.strip()[:160]
        row.require(f"{name}: exit code", answer.returncode, "==", 1)
    status, said = http_body(server.http_port, 256 << 20)
    row.figure("answers", answers)
    row.figure("body of 256 MiB", said)
    row.require("message refused as RESOURCE_EXHAUSTED",
                "RESOURCE_EXHAUSTED" in answers["message of 24 MiB"], "==",
                True)
    row.require("image refused as INVALID_ARGUMENT",
                "INVALID_ARGUMENT" in answers["67 megapixels"], "==", True)
    row.require("body refused", status in (413, 431, 400, 0), "==", True)
    run = load.result()["runs"][0]
    grown_mib = (server.status_kib("VmHWM") - before) / 1024
    row.require("failed calls of others", lost(run), "==", 0)
    row.require("MiB more at the peak", round(grown_mib, 1), "<=", 128)
    row.require("server running", server.running(), "==", True)
    explain_losses(row, run)


def http_body(port, size):
    """Status of a POST whose body is too long; 0: the connection was closed."""
    with socket.create_connection(("127.0.0.1", port), 10) as connection:
        connection.sendall(
            b"POST /treeline.v1.RelocalizationService/Localize HTTP/1.1\r\n"
            b"Host: x\r\nContent-Type: application/proto\r\n"
            b"Content-Length: %d\r\n\r\n" % size)
        sent = 0
        try:
            while sent < size:
                sent += connection.send(bytes(1 << 16))
        except OSError:
            pass
        try:
            first = connection.recv(4096).split(b"\r\n")[0].decode()
        except OSError:
            first = ""
    return (int(first.split()[1]) if first.startswith("HTTP/1.1 ") else 0,
            f"{first or 'connection closed'} after {sent >> 20} MiB")
