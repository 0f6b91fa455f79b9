#include "nav_agent/app/run/clear_start.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::run_app {
namespace {

constexpr geometry::Vec2 kStart = {2, 3};

worlds::Body Walker(std::vector<worlds::Float3> places) {
  worlds::Body body;
  body.name = "walker";
  body.radius_m = 0.25F;
  worlds::Motion motion;
  for (const worlds::Float3& place : places) {
    motion.keys.push_back(
        {.time_s = 2.0 * static_cast<double>(motion.keys.size()),
         .world_from_body = {.origin = place}});
  }
  motion.period_s = 2.0 * static_cast<double>(places.size());
  body.motion = motion;
  return body;
}

double Nearest_m(const worlds::Motion& motion) {
  double nearest_m = 1e9;
  for (double time_s = 0; time_s < 3 * motion.period_s; time_s += 0.01) {
    const worlds::Float3 at = motion.At(time_s).origin;
    nearest_m =
        std::min(nearest_m, std::hypot(static_cast<double>(at.x) - kStart.x,
                                       static_cast<double>(at.y) - kStart.y));
  }
  return nearest_m;
}

TEST(KeepOffStart, WhoWalksThroughOrTurnsThereGoesAround) {
  worlds::World world;
  world.bodies = {Walker({{6, 3, 0}, {2.3F, 3, 0}}),
                  Walker({{2, 0, 0}, {2, 6, 0}}),
                  Walker({{2, 3, 0}, {5, 5, 0}})};
  KeepOffStart(kStart, 0.8, world);
  for (const worlds::Body& body : world.bodies) {
    // Between two places of the way it cuts the circle a little.
    EXPECT_GT(Nearest_m(*body.motion), 0.98 * 1.05) << body.name;
    EXPECT_GT(body.motion->period_s, 0);
  }
  // Who comes straight on stops before it.
  EXPECT_NEAR(Nearest_m(*world.bodies[0].motion), 1.05, 0.01);
  EXPECT_NEAR(static_cast<double>(world.bodies[0].motion->At(0).origin.x), 6,
              1e-6);
}

TEST(KeepOffStart, WhoStaysAwayAndWhatStandsIsLeftAlone) {
  worlds::World world;
  world.bodies = {Walker({{6, 3, 0}, {6, 9, 0}}),
                  // A door's leaf turns about its hinge.
                  Walker({{2.1F, 3, 0}, {2.1F, 3, 0}})};
  world.bodies.emplace_back();
  KeepOffStart(kStart, 0.8, world);
  EXPECT_EQ(world.bodies[0].motion->keys.size(), 2u);
  EXPECT_EQ(world.bodies[1].motion->keys.size(), 2u);
  EXPECT_FALSE(world.bodies[2].motion.has_value());
}

}  // namespace
}  // namespace treeline::run_app
