// What suites of missions and of kidnaps are both asked for.
#ifndef EVALUATION_SUITES_SUITE_OPTIONS_H_
#define EVALUATION_SUITES_SUITE_OPTIONS_H_

#include <string>
#include <vector>

#include "evaluation/suites/suite_maps.h"
#include "simulation/worlds/world.h"

namespace treeline::suites {

struct SuiteOptions {
  std::vector<std::string> worlds;
  // For ParseSeedList.
  std::string seeds;
  bool people = false;
  worlds::Rearrangement rearranged{};
  // "perfect" or "driven".
  std::string maps;
  std::string cache = "out/suite";
  // rmp100, jackal, turtlebot3, or a file (docs/reference/robots.md).
  std::string robot = "rmp100";
  bool no_rear_laser = false;
  int threads = 0;
  // Share of good runs (0 to 1) below which the suite fails.
  double require = 0;
  std::string json = {};
  std::string folder;
  // "none", "failed" or "all".
  std::string pictures = "failed";
  bool quiet = false;

  bool WantsPicture(bool is_good) const {
    return pictures == "all" || (pictures == "failed" && !is_good);
  }
  SuiteMapOptions MapOptions(const std::string& world) const {
    return {.world = world,
            .is_driven = maps == "driven",
            .with_people = people,
            .rearranged = rearranged,
            .cache = cache,
            .quiet = quiet};
  }
};

}  // namespace treeline::suites

#endif  // EVALUATION_SUITES_SUITE_OPTIONS_H_
