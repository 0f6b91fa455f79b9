#include "nav_agent/app/route/route_yaml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace treeline::route_app {
namespace {

using ::testing::HasSubstr;

TEST(RouteYamlTest, WhatIsWrittenIsRead) {
  v1::Route route;
  route.set_name("the \"night\" patrol: Küche");
  route.set_loop(true);
  route.set_when_missed(v1::MISSED_POLICY_STOP);
  v1::Waypoint& first = *route.add_waypoints();
  first.set_x_m(-1.25);
  first.set_yaw_rad(0);
  first.set_wait_s(10);
  first.set_name("1");
  route.add_waypoints()->set_level(2);
  v1::Route other;
  other.set_name("b");
  other.set_when_missed(v1::MISSED_POLICY_GO_ON);
  other.add_waypoints()->set_y_m(3);
  const auto read = ParseRoutes(RoutesText({route, other}), "a.yaml");
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->size(), 2U);
  EXPECT_EQ((*read)[0].ShortDebugString(), route.ShortDebugString());
  EXPECT_EQ((*read)[1].ShortDebugString(), other.ShortDebugString());
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
