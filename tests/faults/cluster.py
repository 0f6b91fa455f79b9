"""The parts of Kubernetes that a server meets, played by processes: pods with
addresses of their own, a Deployment, the DNS of a headless Service, and haproxy
with the configuration of deploy/kubernetes.
"""

import http.client
import os
import pathlib
import re
import shutil
import socket
import struct
import subprocess
import threading

from harness import KILL, TERM, FaultError, Program, Server, free_port, wait_until

ROOT = pathlib.Path(__file__).resolve().parents[2]
HAPROXY_CONFIGURATION = (ROOT / "deploy" / "kubernetes" / "components" /
                         "sharded" / "haproxy.cfg")
# How long it takes until everybody knows of a pod that is being stopped.
NEWS_S = 1.0
TYPE_A, CLASS_IN, TTL_S = 1, 1, 1


def question_of(query):
    """(identifier, name and type of the question as sent, its type)."""
    identifier, = struct.unpack_from(">H", query)
    end = 12
    while query[end]:
        end += 1 + query[end]
    kind, = struct.unpack_from(">H", query, end + 1)
    return identifier, query[12:end + 5], kind


def answer_to(query, addresses):
    """What a name server says: these IPv4 addresses, whatever the name; of
    other types there are none. ValueError: that is no question."""
    try:
        identifier, question, kind = question_of(query)
    except (IndexError, struct.error) as error:
        raise ValueError("no DNS question") from error
    found = addresses if kind == TYPE_A else []
    # An answer, with authority.
    head = struct.pack(">HHHHHH", identifier, 0x8580, 1, len(found), 0, 0)
    # 0xc00c: the name is that of the question.
    records = [struct.pack(">HHHIH", 0xc00c, TYPE_A, CLASS_IN, TTL_S, 4) +
               socket.inet_aton(address) for address in found]
    return head + question + b"".join(records)


class Zone:
    """The DNS of a headless Service: the addresses of the pods that are ready."""

    def __init__(self, setup):
        self._addresses = []
        self._lock = threading.Lock()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self.port = self._socket.getsockname()[1]
        threading.Thread(target=self._serve, daemon=True).start()
        setup.on_exit(self._socket.close)

    def add(self, address):
        with self._lock:
            self._addresses.append(address)

    def remove(self, address):
        with self._lock:
            if address in self._addresses:
                self._addresses.remove(address)

    def addresses(self):
        with self._lock:
            return list(self._addresses)

    def _serve(self):
        while True:
            try:
                query, client = self._socket.recvfrom(4096)
                self._socket.sendto(answer_to(query, self.addresses()), client)
            except ValueError:
                continue
            except OSError:
                return


class Deployment:
    """Pods as base/deployment.yaml has them: one more before one less, ready
    before they are counted on."""

    def __init__(self, setup, models, *flags):
        self.setup = setup
        self.models = models
        self.flags = flags
        self.zone = Zone(setup)
        # Of all pods: each has an address of its own.
        self.port, self.http_port = free_port(), free_port()
        self.pods = []
        self.exits = []
        self._started = 0
        # Addresses that no other Deployment of this machine has: 127.x.y.z.
        self._network = 0x7f000000 | (1 + os.getpid() % 0xfffe) << 8

    def start(self):
        self._started += 1
        host = socket.inet_ntoa(struct.pack(">I", self._network +
                                            self._started))
        pod = Server(self.setup, self.models, *self.flags, host=host,
                     port=self.port, http_port=self.http_port)
        self.zone.add(host)
        self.pods.append(pod)
        return pod

    def stop(self, pod):
        """SIGTERM; the news that its address is gone come later."""
        self.pods.remove(pod)
        pod.send(TERM)
        news = threading.Timer(NEWS_S, self.zone.remove, (pod.host,))
        news.start()
        self.exits.append(pod.wait())
        news.join()

    def scale(self, count):
        """To so many pods; those to go are stopped at the same time."""
        while len(self.pods) < count:
            self.start()
        threads = [threading.Thread(target=self.stop, args=(pod,))
                   for pod in self.pods[count:]]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    def restart(self):
        """All pods, one after the other."""
        for pod in list(self.pods):
            self.start()
            self.stop(pod)

    def lose(self, count):
        """A node goes with so many of its pods, unannounced; its addresses stay
        in the DNS, as they do until Kubernetes believes it."""
        lost, self.pods = self.pods[:count], self.pods[count:]
        for pod in lost:
            pod.send(KILL)
        return lost


def configuration(text, changes):
    """The text with (what, instead) of the changes; each is in it once."""
    for what, instead in changes:
        if text.count(what) != 1:
            raise FaultError(f"{HAPROXY_CONFIGURATION}: {what!r} is not in it "
                             "once")
        text = text.replace(what, instead)
    return text


def haproxy_program():
    """Its path; Debian has it where PATH of most users has not."""
    return shutil.which("haproxy", path=os.environ.get("PATH", "") +
                        ":/usr/sbin")


class Balancer(Program):
    """haproxy with the configuration that is shipped, but for the addresses of
    this machine."""

    def __init__(self, setup, deployment, *changes):
        program = haproxy_program()
        if program is None:
            raise FaultError("no haproxy; run scripts/install-deps --tools")
        self.port, self.health_port = free_port(), free_port()
        self.address = f"127.0.0.1:{self.port}"
        file = setup.folder("haproxy") / "haproxy.cfg"
        file.write_text(configuration(
            HAPROXY_CONFIGURATION.read_text(),
            [("parse-resolv-conf",
              f"nameserver zone 127.0.0.1:{deployment.zone.port}"),
             ("bind :50050", f"bind {self.address}"),
             ("bind :8404", f"bind 127.0.0.1:{self.health_port}"),
             ("connect port 8080", f"connect port {deployment.http_port}"),
             (':50051"', f':{deployment.port}"'), *changes]))
        super().__init__(setup, [program, "-db", "-f", file],
                         environment={**os.environ,
                                      "TREELINE_SERVERS": "treeline-pods"})
        # What it prints is nobody's; a full pipe would stop it.
        threading.Thread(target=self.process.stdout.read, daemon=True).start()
        self.await_servers(len(deployment.pods))

    def servers(self):
        """How many servers it sends calls to."""
        try:
            connection = http.client.HTTPConnection(
                "127.0.0.1", self.health_port, timeout=5)
            connection.request("GET", "/metrics")
            text = connection.getresponse().read().decode()
        except OSError:
            return 0
        return len(re.findall(
            r'^haproxy_server_status\{.*state="UP"\} 1$', text, re.M))

    def await_servers(self, count):
        wait_until(lambda: not self.running() or self.servers() == count,
                   f"haproxy to see {count} servers")
        if not self.running():
            raise FaultError("haproxy ended: " + self.log()[-2000:])


def haproxy_version():
    program = haproxy_program()
    if program is None:
        return None
    said = subprocess.run([program, "-v"], text=True, capture_output=True,
                          check=False).stdout
    return said.split("\n", 1)[0]
