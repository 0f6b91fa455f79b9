// Where a robot of a suite drives from and to.
#ifndef EVALUATION_SUITES_SUITE_ROUTE_H_
#define EVALUATION_SUITES_SUITE_ROUTE_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "common/base/random.h"
#include "evaluation/suites/suite_place.h"

namespace treeline::suites {

struct Route {
  simulator::RobotPlacement start;
  simulator::RobotPlacement goal;
  // The shortest way of a round robot (m).
  double way_m = 0;
};

// Random stream of a seed's route.
inline constexpr uint64_t kRouteStream = 200;

// What `random` draws: start and goal anywhere on ground that can be reached,
// at least min_way_m apart, and nobody stands at the start. Every third seed's
// are at different heights where a world has some. FAILED_PRECONDITION: the
// world is too small.
absl::StatusOr<Route> DrawRoute(const SuitePlace& place, uint64_t seed,
                                double min_way_m, base::Random& random);

}  // namespace treeline::suites

#endif  // EVALUATION_SUITES_SUITE_ROUTE_H_
