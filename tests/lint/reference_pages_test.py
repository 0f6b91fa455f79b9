"""The generated pages of docs/reference say what the sources declare."""

import contextlib
import io
import pathlib
import sys
import unittest
from unittest import mock

from fixture_tree import FixtureTreeTest

sys.path.insert(0, str(pathlib.Path(__file__).parents[2]
                       / "scripts/lib/reference"))
import main  # noqa: E402
import metrics  # noqa: E402
import parameters  # noqa: E402
import protos  # noqa: E402
import settings  # noqa: E402

CONFIG_HEADER = """
struct ServerConfig {
  // Capacity; of the machine.
  // More of it.
  int queue = 64;
  std::vector<std::string> names;
};
"""
CONFIG_SOURCE = """
void Add(Table& table) {
  table.Add(&app::ServerConfig::queue,
            {.name = "queue",
             .help = "Queries, that may "  // not this
                     "wait | here",
             .min = 1,
             .max = 1 << 10,
             .live = true});
  table.Add(&ServerConfig::names, {.name = "names",
                                   .value_name = "NAME,...",
                                   .help = "Names"});
}
"""


class ReferencePagesTest(FixtureTreeTest):

    def root_path(self):
        return pathlib.Path(self.root)

    def test_a_setting_is_a_row_under_its_heading(self):
        self.write("server/app/server_config.h", CONFIG_HEADER)
        self.write("server/app/server_config.cc", CONFIG_SOURCE)
        page = settings.server_page(self.root_path())
        self.assertIn("## Capacity\n", page)
        self.assertIn("| `queue` | 64 | 1 to 1024 | yes | Queries, that may "
                      r"wait \| here |", page)
        self.assertIn("| `names` | none | NAME,... |  | Names |", page)

    def test_metrics_have_type_labels_and_help(self):
        self.write("server/app/a.cc", """
  : a_(registry.AddCounter("treeline_a_total", "Of "
                           "a.", {"rpc", "status"})) {}
  out.Family("treeline_b", "Of b.", MetricType::kGauge);
  out.Sample({{"scene", s}, {"result", "ok"}}, 1);
}
""")
        page = metrics.page(self.root_path())
        self.assertIn("| `treeline_a_total` | counter | rpc, status | Of a |",
                      page)
        self.assertIn("| `treeline_b` | gauge | scene, result | Of b |", page)

    def test_parameters_are_rows_of_their_folder(self):
        self.write("server/core/pose/parameters.h", """
inline constexpr Parameter<double> kMargin{
    .name = "margin", .value = 0.04, .unit = "m",
    .origin = ParameterOrigin::kMeasured, .why = "noise, of the laser"};
inline constexpr Parameter<int> kRounds{"rounds", 3, "",
    ParameterOrigin::kTuned, "more, "
    "does not help"};
""")
        page = parameters.page(self.root_path())
        self.assertIn("## server/core/pose\n", page)
        self.assertIn("| `margin` | 0.04 | m | measured | noise, of the laser "
                      "|", page)
        self.assertIn("| `rounds` | 3 |  | tuned | more, does not help |", page)

    def test_messages_are_tables_with_links(self):
        self.write("proto/treeline/v1/a.proto", """// Of a.
syntax = "proto3";

// Two words.
message Pair {
  // The first.
  repeated Pair first = 1;
  oneof which {
    string text = 2;
  }
}

// A choice.
enum Choice {
  CHOICE_UNSPECIFIED = 0;
}
""")
        page = protos.page(self.root_path())
        self.assertIn("### Pair\n\n*Message.* Two words.\n", page)
        self.assertIn("| `first` | repeated [Pair](#pair) | 1 | The first. |",
                      page)
        self.assertIn("| `text` | `string`, one of `which` | 2 |  |", page)
        self.assertIn("| `CHOICE_UNSPECIFIED` | 0 |  |", page)

    def test_check_fails_where_a_page_is_old(self):
        self.write("docs/a.md", "old")
        output = io.StringIO()
        with mock.patch.object(main, "PAGES", {"docs/a.md": lambda _: "new"}), \
             mock.patch("sys.argv", ["main.py", "--root", self.root]), \
             contextlib.redirect_stdout(output):
            sys.argv.append("--check")
            self.assertEqual(main.main(), 1)
            self.assertIn("docs/a.md is not up to date", output.getvalue())
            sys.argv.pop()
            self.assertEqual(main.main(), 0)
            sys.argv.append("--check")
            self.assertEqual(main.main(), 0)


if __name__ == "__main__":
    unittest.main()
