#include "nav_agent/routes/route_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "common/base/checked_lines.h"

namespace treeline::routes {
namespace {

using ::testing::HasSubstr;

std::vector<Route> Two() {
  return {{.name = "night patrol",
           .waypoints = {{.position_in_map = {0.1, -2.5}, .name = "the door"},
                         {.position_in_map = {1.0 / 3, 2},
                          .level = 1,
                          .yaw_rad = -1.0 / 7,
                          .wait_s = 10}},
           .is_loop = true,
           .when_missed = MissedPolicy::kStop},
          {.name = "Küche", .waypoints = {{.position_in_map = {4, 2}}}}};
}

TEST(RouteFileTest, RoutesComeBackBitForBit) {
  const auto read = ParseRouteFile(RouteFileText(Two()));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(*read, Two());
  EXPECT_TRUE(ParseRouteFile(RouteFileText({}))->empty());
}

TEST(RouteFileTest, WhatWasCutOffIsRefused) {
  const std::string text = RouteFileText(Two());
  for (size_t size = 0; size < text.size(); ++size) {
    EXPECT_FALSE(ParseRouteFile(text.substr(0, size)).ok()) << size;
  }
}

void ExpectRefused(const std::vector<std::string>& lines,
                   const std::string& why) {
  const absl::Status status =
      ParseRouteFile(base::CheckedLinesText("treeline-routes 1", lines))
          .status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr(why));
}

TEST(RouteFileTest, LinesThatMeanNothingAreNamed) {
  ExpectRefused({"route 1 once go-on a"}, "is no 'waypoint'");
  ExpectRefused({"route 1 once go-on a", "waypoint 0 1 x - 0 "}, "line 3");
  ExpectRefused({"route 1 twice go-on a"}, "neither 'once' nor 'loop'");
  ExpectRefused({"route 1 once jump a"}, "'jump'");
  ExpectRefused({"route 101 once go-on a"}, "a number is missing");
  ExpectRefused({"route -1 once go-on a"}, "a number is missing");
  ExpectRefused({"waypoint 0 1 1 - 0 "}, "is no 'route'");
}

TEST(RouteFileTest, ProgressComesBack) {
  RouteProgress progress = {.route = std::make_shared<const Route>(Two()[0]),
                            .waypoint = 1,
                            .lap = 3,
                            .reached = 6,
                            .missed = 1};
  progress.last_missed = {{.waypoint = 1,
                           .lap = 2,
                           .cause = core::NavigationCause::kNoPath,
                           .why = "a closed\ndoor"}};
  const auto read = ParseProgressFile(ProgressFileText(progress));
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_TRUE(read->has_value());
  const RouteProgress& found = **read;
  EXPECT_EQ(*found.route, Two()[0]);
  EXPECT_EQ(found.waypoint, 1u);
  EXPECT_EQ(found.lap, 3);
  EXPECT_EQ(found.reached, 6);
  EXPECT_EQ(found.missed, 1);
  ASSERT_EQ(found.last_missed.size(), 1u);
  EXPECT_EQ(found.last_missed[0].why, "a closed door");
  EXPECT_EQ(found.last_missed[0].cause, core::NavigationCause::kNoPath);
  const auto none = ParseProgressFile(ProgressFileText(std::nullopt));
  ASSERT_TRUE(none.ok());
  EXPECT_FALSE(none->has_value());
}

TEST(RouteFileTest, ProgressOfNoWaypointIsRefused) {
  const auto parse = [](const std::vector<std::string>& lines) {
    return ParseProgressFile(
               base::CheckedLinesText("treeline-route-progress 1", lines))
        .status();
  };
  const std::vector<std::string> route = {"route 1 once go-on a",
                                          "waypoint 0 1 1 - 0 "};
  EXPECT_TRUE(parse({"progress 0 0 0 0", route[0], route[1]}).ok());
  EXPECT_FALSE(parse({"progress 1 0 0 0", route[0], route[1]}).ok());
  EXPECT_FALSE(parse({"progress 0 -1 0 0", route[0], route[1]}).ok());
  EXPECT_FALSE(
      parse({"progress 0 0 0 1", "missed 1 0 4 ", route[0], route[1]}).ok());
  EXPECT_FALSE(
      parse({"progress 0 0 0 1", "missed 0 0 99 ", route[0], route[1]}).ok());
  EXPECT_FALSE(parse({"progress 0 0 0 0", route[0], route[1], route[0]}).ok());
  EXPECT_FALSE(parse(route).ok());
}

}  // namespace
}  // namespace treeline::routes
