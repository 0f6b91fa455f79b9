"""treeline-server itself, with a scene that it has learned."""

import json
import pathlib
import re
import shutil
import subprocess

# Somewhere on the Earth.
ANCHOR = {"latitude_deg": 48.137, "longitude_deg": 11.575, "height_m": 520,
          "enu_from_world": {"w": 0.8, "x": 0, "y": 0, "z": 0.6}}


def put_scene(models, model):
    """A repository with the model as version 1 of scene `room`, on Earth."""
    version = pathlib.Path(models) / "room" / "1"
    version.mkdir(parents=True)
    shutil.copyfile(model, version / "model.treeline")
    (version.parent / "scene.json").write_text(
        json.dumps({"display_name": "Room", "geo_anchor": ANCHOR}))


class RealServer:
    """On ports of its own, until stop()."""

    def __init__(self, program, models, *more):
        self._process = subprocess.Popen(
            [program, "--models", models, "--listen", "127.0.0.1:0",
             "--admin-listen", "", "--http-listen", "127.0.0.1:0",
             "--drain-s", "0", *more],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        # With TLS, words follow the addresses.
        self.address = self._line(r"listening on (\S+)")
        self.http = self._line(r"http on (\S+)")

    def _line(self, pattern):
        for line in self._process.stdout:
            if match := re.match(pattern, line):
                return match[1]
        raise RuntimeError("treeline-server ended")

    def kill(self):
        self._process.kill()
        self._process.wait()

    def stop(self):
        self._process.terminate()
        self._process.wait()
        self._process.stdout.close()
