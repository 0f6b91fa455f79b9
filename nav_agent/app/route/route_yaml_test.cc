#include "nav_agent/app/route/route_yaml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace treeline::route_app {
namespace {

using ::testing::HasSubstr;

TEST(RouteYamlTest, WhatIsWrittenIsRead) {
  const std::vector<routes::Route> routes = {
      {.name = "the \"night\" patrol: Küche",
       .waypoints = {{.position_in_map = {-1.25, 0},
                      .yaw_rad = 0,
                      .wait_s = 10,
                      .name = "1"},
                     {.level = 2}},
       .is_loop = true,
       .when_missed = routes::MissedPolicy::kStop},
      {.name = "b", .waypoints = {{.position_in_map = {0, 3}}}}};
  const auto read = ParseRoutes(RoutesText(routes), "a.yaml");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(*read, routes);
}

TEST(RouteYamlTest, MistakesAreNamedWithTheirLine) {
  const auto why = [](const char* text) {
    return std::string(ParseRoutes(text, "a.yaml").status().message());
  };
  EXPECT_THAT(why("routes:\n  - name: a\n    lop: true\n"),
              HasSubstr("a.yaml:3: unknown key 'lop'; did you mean 'loop'?"));
  EXPECT_THAT(why("routes:\n  - name: a\n"), HasSubstr("needs waypoints"));
  EXPECT_THAT(why("routes:\n  - name: a\n    waypoints: [{x: 1}]\n"),
              HasSubstr("'y'"));
  EXPECT_THAT(why("routes:\n  - name: a\n    waypoints: [{x: 1, y: .nan}]\n"),
              HasSubstr("a.yaml:3"));
  EXPECT_THAT(
      why("routes:\n  - name: a\n    waypoints: [{x: 1, y: 1, wait: -1}]\n"),
      HasSubstr("a.yaml:3"));
  EXPECT_THAT(why("routes:\n  - name: a\n    when_missed: jump\n"
                  "    waypoints: [{x: 1, y: 1}]\n"),
              HasSubstr("go-on"));
  EXPECT_THAT(why("routes: []\n"), HasSubstr("no routes"));
  EXPECT_THAT(why("- 1\n"), HasSubstr("a.yaml:1"));
}

}  // namespace
}  // namespace treeline::route_app
