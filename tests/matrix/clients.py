"""The clients of the matrix. Each answers a query in the same words:

    {"outcome": "LOCALIZED", "pose": [qw, qx, qy, qz, x, y, z],
     "covariance": [36 numbers], "inliers": n, "confidence": p}
    {"outcome": "TOO_FEW_SAMPLES"}                  why it was not localized
    {"outcome": "ERROR", "code": "NOT_FOUND", "reason": "SCENE_NOT_FOUND"}
"""

import base64
import dataclasses
import json
import os
import pathlib
import socket
import subprocess
import tempfile
import urllib.error
import urllib.request

import treeline
from treeline import errors



def _free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


# Of the page that browser_client.js serves.
ORIGIN = f"http://127.0.0.1:{_free_port()}"
_PATIENCE_S = 120


@dataclasses.dataclass(frozen=True)
class Query:
    color: bytes
    depth: bytes | None = None
    scene: str = "room"
    version: str | None = None
    token: str | None = None
    timeout_s: float = 60


def _error(code, reason):
    code = {"CANCELED": "CANCELLED"}.get(code.upper(), code.upper())
    return {"outcome": "ERROR", "code": code, "reason": reason or ""}


class Cpp:
    """treeline-client."""

    def __init__(self, program):
        self._program = program

    def ask(self, server, query):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "color").write_bytes(query.color)
            command = [self._program, "localize", "--json", "--server",
                       server.address, "--scene", query.scene, "--color",
                       folder / "color", "--timeout-s", str(query.timeout_s)]
            if query.depth is not None:
                (folder / "depth").write_bytes(query.depth)
                command += ["--depth", folder / "depth"]
            if query.version is not None:
                command += ["--model-version", query.version]
            environment = {**os.environ}
            environment.pop("TREELINE_TOKEN", None)
            if query.token is not None:
                environment["TREELINE_TOKEN"] = query.token
            done = subprocess.run(command, capture_output=True, text=True,
                                  check=False, env=environment)
        if not done.stdout.strip():
            raise AssertionError(f"treeline-client: {done.stderr}")
        said = json.loads(done.stdout)
        if said["outcome"] == "ERROR":
            return _error(said["code"], said.get("error_reason"))
        if said["outcome"] != "LOCALIZED":
            return {"outcome": said["reason"]}
        pose = said["world_from_camera"]
        return {"outcome": "LOCALIZED",
                "pose": [pose[name] for name in
                         ("qw", "qx", "qy", "qz", "tx", "ty", "tz")],
                "covariance": said["covariance"], "inliers": said["inliers"],
                "confidence": said["confidence"]}


class Python:
    """The package treeline."""

    def ask(self, server, query):
        with treeline.Client(server.address, token=query.token,
                             max_attempts=1) as client:
            try:
                answer = client.localize(
                    query.color, query.depth, scene=query.scene,
                    model_version=query.version or "",
                    timeout_s=query.timeout_s)
            except errors.TreelineError as error:
                return _error(error.code, error.reason)
        if not answer:
            return {"outcome": answer.reason}
        return {"outcome": "LOCALIZED",
                "pose": [*answer.rotation_wxyz.tolist(),
                         *answer.position_in_world_m.tolist()],
                "covariance": answer.covariance.ravel().tolist(),
                "inliers": answer.inliers, "confidence": answer.confidence}


class TypeScript:
    """@treeline/client, by a program of node that answers line by line."""

    def __init__(self, *command):
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def stop(self):
        self._process.stdin.close()
        self._process.wait(_PATIENCE_S)
        self._process.stdout.close()

    def ask(self, server, query):
        request = {"url": f"http://{server.http}", "scene": query.scene,
                   "color": base64.b64encode(query.color).decode(),
                   "depth": None if query.depth is None else
                   base64.b64encode(query.depth).decode(),
                   "version": query.version, "token": query.token,
                   "timeout_ms": 1000 * query.timeout_s}
        self._process.stdin.write(json.dumps(request) + "\n")
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        if not line:
            raise AssertionError("the client of node ended")
        said = json.loads(line)
        if said["outcome"] == "ERROR":
            return _error(said["code"], said["reason"])
        return said


def _post(server, path, body, query, accept):
    """(HTTP status, JSON) of a POST."""
    headers = {"Content-Type": "application/json", "Accept": accept}
    if query.token is not None:
        headers["Authorization"] = f"Bearer {query.token}"
    request = urllib.request.Request(f"http://{server.http}{path}",
                                     json.dumps(body).encode(), headers)
    try:
        with urllib.request.urlopen(request, timeout=_PATIENCE_S) as answer:
            return answer.status, json.load(answer)
    except urllib.error.HTTPError as error:
        with error:
            return error.code, json.load(error)


def _error_of_json(said):
    for detail in said.get("details", []):
        if detail["type"] == "google.rpc.ErrorInfo":
            return _error(said["code"], detail["debug"]["reason"])
    return _error(said["code"], "")


class ConnectJson:
    """The Connect protocol by hand."""

    def ask(self, server, query):
        frame = {"color": {
            "encoded": base64.b64encode(query.color).decode()}}
        if query.depth is not None:
            frame["depth"] = {
                "png": base64.b64encode(query.depth).decode(),
                "unitM": 0.001,
                "registration": "DEPTH_REGISTRATION_SCENE_CALIBRATION"}
        body = {"scene": query.scene, "frame": frame,
                "options": {"timeBudgetMs": 1000 * query.timeout_s}}
        if query.version is not None:
            body["modelVersion"] = query.version
        status, said = _post(server,
                             "/treeline.v1.RelocalizationService/Localize",
                             body, query, "application/json")
        if status != 200:
            return _error_of_json(said)
        if said["outcome"] != "OUTCOME_LOCALIZED":
            return {"outcome":
                    said["reason"].removeprefix("NOT_LOCALIZED_REASON_")}
        pose = said["worldFromCamera"]
        return {"outcome": "LOCALIZED",
                "pose": [*(pose["rotation"].get(c, 0) for c in "wxyz"),
                         *(pose["translationM"].get(c, 0) for c in "xyz")],
                "covariance": said["covariance"], "inliers": said["inliers"],
                "confidence": said["confidence"]}


class GeoPose:
    """The GeoPose Protocol by hand. It names no scene, and its pose is one on
    the Earth: "geopose", as the protocol writes it."""

    def ask(self, server, query):
        def reading(sensor, kind, data, size):
            return {"timestamp": 1, "sensorId": sensor, "sequenceNumber": 0,
                    "imageFormat": kind, "size": size,
                    "imageBytes": base64.b64encode(data).decode()}

        readings = [reading("color", "JPG", query.color, [640, 480])]
        if query.depth is not None:
            readings.append(reading("depth", "DEPTH", query.depth, [640, 480]))
        body = {"id": "matrix", "timestamp": 1, "type": "geopose",
                "sensors": [{"id": "color", "type": "camera"},
                            {"id": "depth", "type": "camera"}],
                "sensorReadings": {"cameraReadings": readings}}
        status, said = _post(server, "/geopose", body, query,
                             "application/vnd.oscp+json;version=2.0")
        if status == 200:
            return {"outcome": "LOCALIZED", "geopose": said["geopose"]}
        error = _error_of_json(said)
        if status == 422 and error["reason"] != "NO_SCENE_NEAR":
            return {"outcome": error["reason"]}
        return error
