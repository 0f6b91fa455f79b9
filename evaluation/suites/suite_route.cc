#include "evaluation/suites/suite_route.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"

namespace treeline::suites {
namespace {

constexpr int kTries = 3000;
constexpr double kOtherHeight_m = 0.25;
// The robot's radius, a cart's, and 10 cm.
constexpr double kClearOfOthers_m = 1.1;

// Whether somebody stands there as the drive begins.
bool IsTaken(const worlds::World& world,
             const simulator::RobotPlacement& place) {
  return std::ranges::any_of(
      world.InstancesAt(0), [&](const worlds::BodyInstance& instance) {
        const worlds::Float3& at = instance.world_from_body.origin;
        return std::abs(at.z - place.height_m) < 1 &&
               std::hypot(at.x - place.position.x, at.y - place.position.y) <
                   kClearOfOthers_m;
      });
}

}  // namespace

absl::StatusOr<Route> DrawRoute(const SuitePlace& place, uint64_t seed,
                                double min_way_m, base::Random& random) {
  const bool climbs = place.HasSeveralHeights() && seed % 3 == 0;
  for (int i = 0; i < kTries; ++i) {
    Route route = {.start = place.AnyPlace(random),
                   .goal = place.AnyPlace(random)};
    // Of a platform the map may have no more than the way to it.
    if (climbs && i < kTries / 2 &&
        std::abs(route.start.height_m - route.goal.height_m) < kOtherHeight_m) {
      continue;
    }
    if (IsTaken(place.world(), route.start)) continue;
    const auto way_m = place.PathLength_m(route.start, route.goal);
    if (!way_m.has_value() || *way_m < min_way_m) continue;
    route.way_m = *way_m;
    return route;
  }
  return absl::FailedPreconditionError(
      absl::StrCat("world ", place.world().name, " has no two places ",
                   min_way_m, " m apart that a robot can get to"));
}

}  // namespace treeline::suites
