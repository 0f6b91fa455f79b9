#!/usr/bin/env python3
"""Rules, dashboard and autoscaler ask for metrics that the server has.

    names_test.py TREE PROGRAMS SCENE
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import yaml

TREE = pathlib.Path(sys.argv[1])
PROGRAMS, SCENE = sys.argv[2:4]
sys.path.insert(0, str(TREE / "tests" / "faults"))
from harness import Server, Setup, client, first_frame  # noqa: E402

OBSERVABILITY = TREE / "deploy" / "observability"
ADAPTER_RULES = (TREE / "deploy" / "kubernetes" / "components" / "autoscaling" /
                 "adapter-rules.yaml")
NAME = re.compile(r"\b(?:treeline|process)_\w+")
SELECTOR = re.compile(r"\b((?:treeline|process)_\w+)\{([^}]*)\}")
LABEL = re.compile(r"(\w+)\s*(?:=~|!=|!~|=)\s*\"")
# What Prometheus adds when it scrapes.
SCRAPED = {"job", "instance", "namespace", "pod"}
OF_HISTOGRAMS = ("_bucket", "_sum", "_count")


class Exposed:
    """Families and labels of a text of /metrics."""

    def __init__(self, text):
        self.families = dict(re.findall(r"^# TYPE (\w+) (\w+)$", text, re.M))
        self.labels = {}
        for name, labels in re.findall(r"^(\w+)\{(.*)\} ", text, re.M):
            self.labels.setdefault(self.family(name), set()).update(
                re.findall(r"(\w+)=\"", labels))

    def family(self, name):
        """Of a sample; None: there is none."""
        if name in self.families:
            return name
        for end in OF_HISTOGRAMS:
            family = name.removesuffix(end)
            if family != name and self.families.get(family) == "histogram":
                return family
        return None

    def objections_to(self, expression):
        """Names and labels of a query that are not there."""
        # Placeholders of the adapter are no labels.
        expression = expression.replace("<<.LabelMatchers>>", "")
        found = [name for name in NAME.findall(expression)
                 if self.family(name) is None]
        for name, selector in SELECTOR.findall(expression):
            # Of a family without samples nobody knows the labels.
            known = self.labels.get(self.family(name))
            for label in LABEL.findall(selector):
                if known is not None and label not in known | SCRAPED:
                    found.append(f"{name}{{{label}}}")
        return found


def expressions_of_rules():
    rules = yaml.safe_load((OBSERVABILITY / "rules.yml").read_text())
    return {rule["alert"]: rule["expr"] for group in rules["groups"]
            for rule in group["rules"]}


def expressions_of_dashboard():
    dashboard = json.loads((OBSERVABILITY / "dashboard.json").read_text())
    return {f'{panel["title"]} {target["refId"]}': target["expr"]
            for panel in dashboard["panels"] for target in panel["targets"]}


def expressions_of_adapter():
    rules = yaml.safe_load(ADAPTER_RULES.read_text())["rules"]
    return {f'{rule["name"]["as"]} {key}': rule[key]
            for rule in rules for key in ("seriesQuery", "metricsQuery")}


class Names(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        work = tempfile.TemporaryDirectory()
        cls.addClassCleanup(work.cleanup)
        setup = Setup(PROGRAMS, SCENE, work.name, True)
        cls.addClassCleanup(setup.__exit__)
        server = Server(setup, setup.models())
        color, depth = first_frame(setup)
        for scene in ("room", "nowhere"):
            client(setup, "localize", server.address, "--scene", scene,
                   "--color", color, "--depth", depth)
        cls.exposed = Exposed(server.get("/metrics")[1])

    def check(self, expressions, least):
        self.assertGreaterEqual(len(expressions), least)
        for name, expression in expressions.items():
            with self.subTest(name):
                self.assertEqual(self.exposed.objections_to(expression), [])

    def test_of_the_rules_are_there(self):
        self.check(expressions_of_rules(), 10)

    def test_of_the_dashboard_are_there(self):
        self.check(expressions_of_dashboard(), 15)

    def test_of_the_autoscaler_are_there(self):
        self.check(expressions_of_adapter(), 4)

    def test_that_are_not_there_are_found(self):
        for expression, wrong in (
                ("sum(treeline_queue_length)", ["treeline_queue_length"]),
                ("rate(treeline_shed[5m])", ["treeline_shed"]),
                ('treeline_requests_total{code="OK"}',
                 ["treeline_requests_total{code}"]),
                ("treeline_queue_depth_bucket", ["treeline_queue_depth_bucket"]),
                ('treeline_request_seconds_bucket{rpc="Localize"}', [])):
            self.assertEqual(self.exposed.objections_to(expression), wrong)


class Files(unittest.TestCase):

    def test_the_dashboards_panels_have_numbers_and_places_of_their_own(self):
        panels = json.loads((OBSERVABILITY / "dashboard.json").read_text())[
            "panels"]
        self.assertEqual(len({p["id"] for p in panels}), len(panels))
        places = {(p["gridPos"]["x"], p["gridPos"]["y"]) for p in panels}
        self.assertEqual(len(places), len(panels))

    def test_pages_that_rules_name_are_there(self):
        text = (OBSERVABILITY / "rules.yml").read_text()
        pages = re.findall(r"docs/[\w/.-]+\.md", text)
        self.assertGreater(len(pages), 3)
        for page in pages:
            self.assertTrue((TREE / page).is_file(), page)

    @unittest.skipUnless(shutil.which("promtool"),
                         "no promtool; run scripts/install-deps --tools")
    def test_prometheus_takes_the_rules_and_they_fire_when_they_should(self):
        for command in (["check", "rules", "rules.yml"],
                        ["test", "rules", "rules_test.yml"]):
            done = subprocess.run(["promtool", *command], cwd=OBSERVABILITY,
                                  text=True, capture_output=True, check=False)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
