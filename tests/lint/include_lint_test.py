"""The include lint finds what it is there to find."""

import unittest

import include_lint
import rules
from fixture_tree import FixtureTreeTest

TABLE = rules.load()


class IncludeLintTest(FixtureTreeTest):

    def findings(self):
        return include_lint.findings_in(self.root, TABLE)[0]

    def assert_one_finding(self, *parts):
        findings = self.findings()
        self.assertEqual(len(findings), 1, findings)
        for part in parts:
            self.assertIn(part, findings[0])

    def including(self, path, line):
        self.write(path, f"// What this is.\n{line}\n")

    def test_accepts_what_the_table_allows(self):
        self.write("common/base/clock.h")
        self.write("common/geometry/rigid3.h")
        self.including("common/camera/camera.cc",
                       '#include "common/geometry/rigid3.h"')
        self.including("server/core/pose/kabsch.cc",
                       '#include "common/base/clock.h"')
        self.assertEqual(self.findings(), [])

    def test_finds_an_include_against_the_arrows(self):
        self.write("common/camera/camera.h")
        self.including("common/geometry/rigid3.cc",
                       '#include "common/camera/camera.h"')
        self.assert_one_finding("common/geometry/rigid3.cc:2",
                                "common/geometry may not know common/camera")

    def test_finds_the_client_knowing_the_server(self):
        self.write("server/core/localizer/localizer.h")
        self.including("client/cli/main.cc",
                       '#include "server/core/localizer/localizer.h"')
        self.assert_one_finding("client/cli may not know server/core/localizer")

    def test_finds_training_in_what_serves(self):
        self.write("server/core/training/trainer.h")
        self.including("server/service/localize.cc",
                       '#include "server/core/training/trainer.h"')
        self.assert_one_finding(
            "server/service may not know server/core/training")

    def test_finds_tools_knowing_the_service(self):
        self.write("server/service/localize.h")
        self.including("server/tools/app/train_command.cc",
                       '#include "server/service/localize.h"')
        self.assert_one_finding("server/tools/app may not know server/service")

    def test_finds_drivers_knowing_the_simulation(self):
        self.write("simulation/simulator/world.h")
        self.including("nav_agent/drivers/hokuyo.cc",
                       '#include "simulation/simulator/world.h"')
        self.assert_one_finding("nav_agent/drivers may not know "
                                "simulation/simulator")

    def test_finds_protobuf_in_the_core(self):
        self.including("server/core/pose/kabsch.cc",
                       '#include "treeline/v1/geometry.pb.h"')
        self.assert_one_finding("only common/wire", "may include it")

    def test_finds_grpc_outside_the_edge(self):
        self.including("server/repository/repository.cc",
                       "#include <grpcpp/grpcpp.h>")
        self.assert_one_finding("grpcpp/grpcpp.h", "may include it")

    def test_accepts_protobuf_and_grpc_at_the_edge(self):
        self.including("common/wire/geometry.h",
                       '#include "treeline/v1/geometry.pb.h"')
        self.including("server/service/localize.h",
                       "#include <grpcpp/grpcpp.h>")
        self.assertEqual(self.findings(), [])

    def test_finds_heavy_headers_in_headers_only(self):
        for header in ("Eigen/Core", "opencv2/core.hpp"):
            self.including("server/core/pose/kabsch.h",
                           f"#include <{header}>")
            self.including("server/core/pose/kabsch.cc",
                           f'#include "{header}"')
            self.assert_one_finding("kabsch.h:2", "not in a header")

    def test_finds_grpc_in_a_header_that_the_app_shows(self):
        self.including("server/app/server.h", "#include <grpcpp/server.h>")
        self.assert_one_finding("not in a header")

    def test_finds_a_header_that_is_not_there(self):
        self.including("common/base/file.cc", '#include "common/base/fil.h"')
        self.assert_one_finding("there is no such file")

    def test_finds_a_header_spelled_from_its_own_folder(self):
        self.write("common/base/file.h")
        self.including("common/base/file.cc", '#include "file.h"')
        self.assert_one_finding("from the root of the repository")

    def test_finds_our_headers_in_angle_brackets(self):
        self.write("common/base/file.h")
        self.including("common/base/file.cc", "#include <common/base/file.h>")
        self.assert_one_finding('stand in ""')

    def test_finds_a_folder_without_a_line(self):
        self.write("common/unheard/of.cc")
        self.assert_one_finding("common/unheard/of.cc", "no line")

    def test_sees_spaces_about_the_hash(self):
        self.write("common/camera/camera.h")
        self.including("common/base/file.cc",
                       '  #  include   "common/camera/camera.h"')
        self.assert_one_finding("common/base may not know common/camera")

    def test_a_test_file_has_no_licence_of_its_own(self):
        self.write("server/core/training/trainer.h")
        self.including("server/core/pose/kabsch_test.cc",
                       '#include "server/core/training/trainer.h"')
        self.assert_one_finding("may not know server/core/training")

    def test_tests_may_know_everything(self):
        self.write("server/core/training/trainer.h")
        self.write("client/relocalizer/relocalizer.h")
        self.write("tests/e2e/serve_test.cc",
                   '#include "client/relocalizer/relocalizer.h"\n'
                   '#include "server/core/training/trainer.h"\n')
        self.assertEqual(self.findings(), [])


class RulesTest(unittest.TestCase):

    def test_what_is_allowed_is_passed_on(self):
        table = rules.Rules("a:\nb: a\nc: b\n")
        self.assertTrue(table.may_know("c", "a"))
        self.assertFalse(table.may_know("a", "c"))

    def test_the_longest_folder_counts(self):
        table = rules.Rules("server:\nserver/core/pose:\n")
        self.assertEqual(table.folder_of("server/core/pose/a.cc"),
                         "server/core/pose")
        self.assertEqual(table.folder_of("server/core/poses/a.cc"), "server")
        self.assertIsNone(table.folder_of("client/a.cc"))

    def test_refuses_a_circle(self):
        with self.assertRaisesRegex(rules.RulesError, "a circle"):
            rules.Rules("a: b\nb: c\nc: a\n")

    def test_refuses_a_name_without_a_line(self):
        with self.assertRaisesRegex(rules.RulesError, "no line of its own"):
            rules.Rules("a: b\n")

    def test_refuses_a_line_that_is_no_rule(self):
        with self.assertRaisesRegex(rules.RulesError, "line 2"):
            rules.Rules("a:\na may know b\n")


if __name__ == "__main__":
    unittest.main()
