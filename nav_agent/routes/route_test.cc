#include "nav_agent/routes/route.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace treeline::routes {
namespace {

using ::testing::HasSubstr;

Route Patrol() {
  return {.name = "patrol",
          .waypoints = {{.position_in_map = {1, 2}, .name = "door"},
                        {.position_in_map = {4, 2},
                         .level = 1,
                         .yaw_rad = 1.5,
                         .wait_s = 10}},
          .is_loop = true};
}

void ExpectRefused(const Route& route, const std::string& why) {
  const absl::Status checked = CheckRoute(route, 2);
  EXPECT_EQ(checked.code(), absl::StatusCode::kInvalidArgument) << why;
  EXPECT_THAT(std::string(checked.message()), HasSubstr(why));
}

TEST(RouteTest, WhatMeansSomethingPasses) {
  EXPECT_TRUE(CheckRoute(Patrol(), 2).ok());
  Route adhoc = Patrol();
  adhoc.name.clear();
  EXPECT_TRUE(CheckRoute(adhoc, 2).ok());
  EXPECT_EQ(WaypointText(adhoc, 0), "waypoint 1 of 2 'door'");
  EXPECT_EQ(WaypointText(adhoc, 1), "waypoint 2 of 2");
}

TEST(RouteTest, WhatMeansNothingIsRefusedWithItsNameAndWhy) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  Route route = Patrol();
  route.waypoints[0].position_in_map.x = kNaN;
  ExpectRefused(route, "route 'patrol': waypoint 1 of 2 'door': is at (nan");
  route = Patrol();
  route.waypoints[1].position_in_map.y = 1e9;
  ExpectRefused(route, "on a map");
  route = Patrol();
  route.waypoints[1].yaw_rad = kNaN;
  ExpectRefused(route, "is no heading");
  route = Patrol();
  route.waypoints[1].level = 2;
  ExpectRefused(route, "the map has 0..1");
  route = Patrol();
  route.waypoints[1].wait_s = -1;
  ExpectRefused(route, "waits for -1 s");
  route.waypoints[1].wait_s = kNaN;
  ExpectRefused(route, "waits for nan s");
  route = Patrol();
  route.waypoints[0].name = "a\nb";
  ExpectRefused(route, "control characters");
  route = Patrol();
  route.name = " patrol";
  ExpectRefused(route, "a space at an end");
  route = Patrol();
  route.waypoints.clear();
  ExpectRefused(route, "has 0 waypoints");
  route.waypoints.resize(kMaxWaypoints + 1);
  ExpectRefused(route, "has 101 waypoints");
}

TEST(RouteTest, ALoopThatSpinsOnTheSpotIsRefused) {
  Route route = Patrol();
  route.waypoints = {{.position_in_map = {1, 1}},
                     {.position_in_map = {1.2, 1}}};
  ExpectRefused(route, "leads nowhere");
  route.waypoints[1].wait_s = 5;
  EXPECT_TRUE(CheckRoute(route, 1).ok());
  route.waypoints = {{.position_in_map = {1, 1}}};
  ExpectRefused(route, "leads nowhere");
  route.is_loop = false;
  EXPECT_TRUE(CheckRoute(route, 1).ok());
}

TEST(RouteTest, KeptRoutesHaveNamesOfTheirOwn) {
  EXPECT_TRUE(CheckRoutes({}, 1).ok());
  std::vector<Route> routes = {Patrol(), Patrol()};
  EXPECT_THAT(std::string(CheckRoutes(routes, 2).message()),
              HasSubstr("two routes are called 'patrol'"));
  routes[1].name.clear();
  EXPECT_THAT(std::string(CheckRoutes(routes, 2).message()),
              HasSubstr("0 bytes"));
  routes.assign(kMaxRoutes + 1, Patrol());
  EXPECT_THAT(std::string(CheckRoutes(routes, 2).message()),
              HasSubstr("1001 routes"));
}

}  // namespace
}  // namespace treeline::routes
