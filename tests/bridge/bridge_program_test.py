"""treeline-agent bridge beside a treeline-server and a robot over DDS."""

import argparse
import os
import queue
import re
import subprocess
import sys
import tempfile
import threading
import time
import unittest

PROGRAMS = None
# On a busy machine, that is much.
LONGEST_S = 60


class Program:
    """A process whose lines, of both streams, are waited for."""

    def __init__(self, *arguments):
        self.process = subprocess.Popen(
            arguments, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True)
        self.lines = queue.Queue()
        self.said = []
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()

    def read(self):
        for line in self.process.stdout:
            self.lines.put(line)

    def wait_for(self, pattern):
        until = time.monotonic() + LONGEST_S
        while time.monotonic() < until:
            try:
                line = self.lines.get(timeout=0.1)
            except queue.Empty:
                continue
            self.said.append(line)
            found = re.search(pattern, line)
            if found:
                return found
        raise AssertionError(f"no {pattern} in\n{''.join(self.said)}")

    def end(self, kills=False):
        if self.process.poll() is None:
            (self.process.kill if kills else self.process.terminate)()
        code = self.process.wait(LONGEST_S)
        self.reader.join()
        self.process.stdout.close()
        while not self.lines.empty():
            self.said.append(self.lines.get())
        return code


class BridgeProgramTest(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def start(self, *arguments):
        program = Program(*arguments)
        self.addCleanup(program.end, True)
        return program

    def serve(self, address):
        return self.start(PROGRAMS.server, "--models", self.folder, "--listen",
                          address, "--admin-listen", "", "--http-listen", "")

    def test_a_server_without_the_scene_dies_and_comes_back(self):
        # As the tests in C++ choose theirs: testing_domain.h.
        domain = str(1 + os.getpid() % 100)
        server = self.serve("127.0.0.1:0")
        address = server.wait_for(r"listening on (\S+)").group(1)
        bridge = self.start(
            PROGRAMS.agent, "bridge", "--server", address, "--scene", "house",
            "--domain-id", domain, "--interface", "lo", "--image",
            "camera/image_raw/compressed")
        player = self.start(PROGRAMS.player, domain, "300", "-1", "181",
                            "2000")
        bridge.wait_for("server: NOT_FOUND.*house")
        server.end(kills=True)
        bridge.wait_for("server: UNAVAILABLE")
        self.serve(address)
        bridge.wait_for("server: NOT_FOUND.*house")
        self.assertEqual(bridge.end(), 0, "".join(bridge.said))
        player.end()
        # Who was told no place follows none.
        self.assertNotIn("place off", "".join(player.said))
        self.assertIn("places=0", "".join(bridge.said))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    for name in ("agent", "server", "player"):
        parser.add_argument("--" + name, required=True)
    PROGRAMS, rest = parser.parse_known_args()
    unittest.main(argv=sys.argv[:1] + rest)
