// The maps and models that suites drive with: perfect ones, and those of
// simulated mapping drives, kept from one run of a suite to the next.
#ifndef EVALUATION_SUITES_SUITE_MAPS_H_
#define EVALUATION_SUITES_SUITE_MAPS_H_

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "evaluation/suites/suite_place.h"

namespace treeline::suites {

struct SuiteMapOptions {
  std::string world;
  // Of a mapping drive, rather than as the world is.
  bool is_driven = false;
  // In the world that is driven in; a mapping drive meets nobody, and nothing
  // that was moved.
  bool with_people = false;
  worlds::Rearrangement rearranged{};
  building::Lighting lighting = building::Lighting::kDay;
  // In which the mapping drive sees the world, and so what models learn.
  building::Lighting map_lighting = building::Lighting::kDay;
  // Of the circle that holds the robot (m): places have room for it. A mapping
  // drive is the default robot's all the same.
  double robot_radius_m = kDefaultRobotRadius_m;
  // Whether surfaces have their pictures: for cameras.
  bool paint = false;
  // Driven maps are kept in CACHE/SCENE/bundle.
  std::string cache{};
  bool quiet = false;
};

// Of the mapping drive: along the tour, with a look around every
// kSurveyEvery_m, and this many frames in a second.
inline constexpr double kSurveyEvery_m = 2.0;
inline constexpr double kSurveyCamera_hz = 3;
inline constexpr uint64_t kSurveySeed = 900001;

// "seed:17" as a folder.
std::string SuiteWorldName(const std::string& world);
// The scene of a driven map, which is a world in the light that the drive saw
// it in: "seed-17" by day, "seed-17-in-evening".
std::string SuiteSceneName(const SuiteMapOptions& options);
std::string SuiteBundleFolder(const SuiteMapOptions& options);

// Drives and maps if there is no map in the cache yet.
absl::StatusOr<std::shared_ptr<const SuitePlace>> PlaceForSuite(
    const SuiteMapOptions& options, const std::stop_token& stop);

// The repository of models (CACHE/models) with a model of the world's scene,
// trained by the program `treeline` beside this one if it has none yet.
absl::StatusOr<std::string> ModelsForSuite(const SuiteMapOptions& options,
                                           const std::stop_token& stop);

}  // namespace treeline::suites

#endif  // EVALUATION_SUITES_SUITE_MAPS_H_
