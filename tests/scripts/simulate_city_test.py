"""The simulation of a fleet does what it says."""

import contextlib
import importlib.machinery
import importlib.util
import io
import json
import unittest

from stub_programs import REPOSITORY

LOADER = importlib.machinery.SourceFileLoader(
    "simulate_city", str(REPOSITORY / "scripts" / "simulate-city"))
city = importlib.util.module_from_spec(
    importlib.util.spec_from_loader(LOADER.name, LOADER))
LOADER.exec_module(city)

SMALL = ("--bound", "1.5", "--scenes", "300", "--servers", "5", "--budget", "80", "--queries",
         "8000", "--visitors", "100", "--visit", "10")


class Parts(unittest.TestCase):

    def test_one_more_server_moves_its_own_share_alone(self):
        servers = [f"s{i}" for i in range(10)]
        before, after = city.Ring(servers[:9]), city.Ring(servers)
        moved = [(a, b) for a, b in (
            (next(before.order(f"{i}")), next(after.order(f"{i}")))
            for i in range(3000)) if a != b]
        self.assertTrue(all(b == "s9" for _, b in moved))
        # 300 of 3000 on average, with 256 points give or take a fifth.
        self.assertTrue(200 < len(moved) < 400, len(moved))

    def test_the_order_has_every_server_once(self):
        servers = {f"s{i}" for i in range(7)}
        order = list(city.Ring(servers).order("a"))
        self.assertEqual(len(order), 7)
        self.assertEqual(set(order), servers)

    def test_what_was_used_longest_ago_makes_room(self):
        memory = city.Memory(2)
        hits = [memory.ask(scene) for scene in (1, 2, 1, 3, 1, 2)]
        self.assertEqual(hits, [False, False, True, False, True, False])

    def test_a_bound_spreads_what_everybody_asks_for(self):
        servers = [f"s{i}" for i in range(4)]
        hot = city.Balancer(servers, True)
        bounded = city.Balancer(servers, True, 1.5)
        self.assertEqual(len({hot.choose("x", 8) for _ in range(100)}), 1)
        self.assertGreater(len({bounded.choose("x", 8) for _ in range(100)}), 1)


class Program(unittest.TestCase):

    def rows(self, *more):
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            self.assertEqual(city.main([*SMALL, "--json", *more]), 0)
        return json.loads(out.getvalue())["rows"]

    def test_hashing_finds_scenes_in_memory_more_often(self):
        for rows in (self.rows()[:3], self.rows()[3:]):
            in_turn, hashed, bounded = (row["hit_rate"] for row in rows)
            self.assertGreater(hashed, in_turn + 0.1)
            self.assertGreater(bounded, in_turn)
            self.assertLess(rows[2]["busiest_by_mean"],
                            rows[1]["busiest_by_mean"])

    def test_with_room_for_all_nothing_is_loaded_twice(self):
        for row in self.rows("--budget", "300", "--queries", "30000",
                             "--zipf", "0"):
            self.assertGreater(row["hit_rate"], 0.99)

    def test_the_same_seed_gives_the_same_rows(self):
        self.assertEqual(self.rows(), self.rows())
        self.assertNotEqual(self.rows(), self.rows("--seed", "2"))

    def test_refuses_what_makes_no_sense(self):
        for wrong in (["--scenes", "0"], ["--servers", "x"], ["--nothing"],
                      ["--bound", "0.5"]):
            with self.assertRaises(SystemExit) as end, \
                    contextlib.redirect_stderr(io.StringIO()):
                city.main(wrong)
            self.assertEqual(end.exception.code, 2)


if __name__ == "__main__":
    unittest.main()
