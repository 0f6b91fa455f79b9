"""Models in an object store that takes signed addresses alone, and what the
server's log says of them.
"""

import datetime
import hashlib
import http.server
import importlib.machinery
import importlib.util
import json
import os
import pathlib
import ssl
import subprocess
import threading
import urllib.parse

from clients import Authority, day
from harness import (FaultError, Program, Server, client, fault, first_frame,
                     wait_until)

SIGN_INDEX = (pathlib.Path(__file__).resolve().parents[2] / "deploy" /
              "sign-index")
KEY = ("AKIATREELINEEXAMPLE", "a/secret+that=nobody/may/see", "")
REGION = "eu-test-1"


def load_sign_index():
    loader = importlib.machinery.SourceFileLoader("sign_index", str(SIGN_INDEX))
    module = importlib.util.module_from_spec(
        importlib.util.spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return module


class Store:
    """A bucket over HTTPS: GET, with ranges, of whoever has a signature that is
    not too old. `clock` moves its time, in seconds."""

    def __init__(self, setup, authority, folder):
        self.clock = 0
        self.counts = {}
        store, signing = self, load_sign_index()

        class Handler(http.server.BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def log_message(self, *_):
                pass

            def do_GET(self):
                path, _, _ = self.path.partition("?")
                file = folder / path.lstrip("/").partition("/")[2]
                status = store.judge(signing, self.headers["Host"], self.path)
                if status == 200 and not file.is_file():
                    status = 404
                data = file.read_bytes() if status == 200 else b"<Error/>"
                begin = self.headers.get("Range")
                if status == 200 and begin:
                    offset = int(begin.removeprefix("bytes=").rstrip("-"))
                    self.send_response(206)
                    self.send_header("Content-Range", f"bytes {offset}-"
                                     f"{len(data) - 1}/{len(data)}")
                    data = data[offset:]
                else:
                    self.send_response(status)
                store.counts[status] = store.counts.get(status, 0) + 1
                self.send_header("Content-Length", str(len(data)))
                self.end_headers()
                self.wfile.write(data)

        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        pair = setup.folder("store-tls")
        for name, text in zip(("cert", "key"),
                              authority.issue("store", -60, day())):
            (pair / name).write_text(text)
        context.load_cert_chain(pair / "cert", pair / "key")
        server.socket = context.wrap_socket(server.socket, server_side=True)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        setup.on_exit(server.shutdown)
        self.endpoint = f"https://127.0.0.1:{server.server_address[1]}/bucket"

    def judge(self, signing, host, target):
        """200, or 403 for what the key did not sign or what is too old."""
        parts = urllib.parse.urlsplit(target)
        query = dict(urllib.parse.parse_qsl(parts.query))
        try:
            begin = datetime.datetime.strptime(
                query["X-Amz-Date"], "%Y%m%dT%H%M%SZ").replace(
                    tzinfo=datetime.timezone.utc)
            valid_s = int(query["X-Amz-Expires"])
            wanted = signing.presigned(f"https://{host}{parts.path}", KEY,
                                       REGION, begin, valid_s)
        except (KeyError, ValueError):
            return 403
        now = datetime.datetime.now(datetime.timezone.utc) + \
            datetime.timedelta(seconds=self.clock)
        fits = wanted == f"https://{host}{target}"
        return 200 if fits and (now - begin).total_seconds() < valid_s else 403


def publish(setup, folder, endpoint, scenes):
    """Puts models and a signed index into the bucket; the signed address of the
    index."""
    data = setup.model.read_bytes()
    models = []
    for scene in scenes:
        place = folder / scene / "1"
        place.mkdir(parents=True, exist_ok=True)
        (place / "model.treeline").write_bytes(data)
        models.append({"scene": scene, "version": "1", "bytes": len(data),
                       "sha256": hashlib.sha256(data).hexdigest(),
                       "url": f"{scene}/1/model.treeline"})
    plain = setup.folder("index") / "index.json"
    plain.write_text(json.dumps({"models": models}))
    done = subprocess.run(
        [str(SIGN_INDEX), "--endpoint", endpoint, "--region", REGION,
         "--valid-s", "3600", str(plain)], text=True, capture_output=True,
        check=False, env={**os.environ, "AWS_ACCESS_KEY_ID": KEY[0],
                          "AWS_SECRET_ACCESS_KEY": KEY[1]})
    if done.returncode != 0:
        raise FaultError(f"sign-index: {done.stderr}")
    (folder / "signed.json").write_text(done.stdout)
    return done.stderr.strip().splitlines()[-1]


@fault("signed-models", "models from an object store over HTTPS by presigned "
                        "addresses: fetched, refused when they expire, never "
                        "in the log")
def signed_models(setup, row):
    setup.need("--cache", "--models-ca")
    authority = Authority(setup.folder("ca"))
    bucket = setup.folder("bucket")
    store = Store(setup, authority, bucket)
    address = publish(setup, bucket, store.endpoint, ["room"])
    # As the Secret's variable, and with all that is logged.
    environment = {**os.environ, "TREELINE_SERVER_MODELS": address}
    server = Server(setup, None, "--cache", setup.folder("cache"), "--models-ca",
                    authority.ca, "--poll-s", "1", "--log-level", "debug",
                    environment=environment)
    color, depth = first_frame(setup)
    ask = ("--scene", "room", "--color", color, "--depth", depth)
    fresh = client(setup, "localize", server.address, *ask)
    fetched = store.counts.get(200, 0) + store.counts.get(206, 0)
    row.figure("fetches of the store", fetched)
    # Hours later: the index cannot be read any more, what is loaded serves on.
    store.clock = 7200
    wait_until(lambda: store.counts.get(403, 0) > 0, "a refused index", 60)
    later = client(setup, "localize", server.address, *ask)
    # A server that starts now has nothing to serve, and says why.
    newcomer = Program(setup, [
        setup.program("treeline-server"), "--cache", setup.folder("cache"),
        "--models-ca", authority.ca, "--listen", "127.0.0.1:0", "--http-listen",
        "", "--admin-listen", "", "--log-level", "debug"],
        environment=environment)
    wait_until(lambda: "403" in newcomer.log(), "the newcomer's complaint", 60)
    newcomer.kill()
    printed = subprocess.run(
        [setup.program("treeline-server"), "--print-config"], text=True,
        capture_output=True, check=False, env=environment)
    said = (server.log() + newcomer.log() + fresh.stderr + later.stderr +
            printed.stdout + printed.stderr)
    query = urllib.parse.urlsplit(address).query
    secrets = [query, "X-Amz-", KEY[0], KEY[1],
               urllib.parse.parse_qs(query)["X-Amz-Signature"][0]]
    row.require("exit code of localize", fresh.returncode, "==", 0)
    row.require("models fetched", fetched, ">=", 2)
    row.require("exit code of localize when the addresses have expired",
                later.returncode, "==", 0)
    row.require("the log says that the store refuses",
                "403" in server.log() or "SOURCE_REFUSED" in server.log(), "==",
                True)
    row.require("secrets in logs and errors",
                sum(secret in said for secret in secrets), "==", 0)
    row.figure("bytes of log looked through", len(said))
