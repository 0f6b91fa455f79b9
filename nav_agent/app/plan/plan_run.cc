#include "nav_agent/app/plan/plan_run.h"

#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "common/base/check_heading.h"
#include "common/base/status_macros.h"
#include "nav_agent/map_bundle/drivable_map.h"
#include "nlohmann/json.hpp"
#include "simulation/runs/localize_world.h"
#include "simulation/worlds/world.h"

namespace treeline::plan_app {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kResolution_m = 0.05;

// Three numbers, and a level that may be left out.
struct Numbers {
  double values[3] = {0, 0, 0};
  int level = 0;
};

// What was given, for a message: not all of it if it is long, and nothing that
// a terminal obeys.
std::string Shown(const std::string& text) {
  constexpr size_t kMax = 60;
  return absl::CHexEscape(text.substr(0, kMax)) +
         (text.size() > kMax ? "..." : "");
}

absl::StatusOr<Numbers> ParseNumbers(const std::string& text,
                                     const std::string& option,
                                     const std::string& form) {
  const std::vector<std::string> parts = absl::StrSplit(text, ',');
  Numbers numbers;
  bool is_good = parts.size() == 3 || parts.size() == 4;
  for (size_t i = 0; is_good && i < 3; ++i) {
    is_good = absl::SimpleAtod(parts[i], &numbers.values[i]) &&
              std::isfinite(numbers.values[i]);
  }
  if (is_good && parts.size() == 4) {
    is_good = absl::SimpleAtoi(parts[3], &numbers.level) && numbers.level >= 0;
  }
  if (is_good) return numbers;
  return absl::InvalidArgumentError(absl::StrCat(
      option, " is '", Shown(text), "'; it must be ", form, " or ", form,
      ",LEVEL with finite numbers in m and rad and levels from 0, for instance "
      "1.5,2,0"));
}

absl::StatusOr<std::shared_ptr<const traversability::NavigationMap>> Finished(
    traversability::TraversableMap levels, bool allow_unknown,
    const std::string& name) {
  absl::StatusOr<traversability::NavigationMap> map =
      traversability::NavigationMap::Make(
          std::move(levels),
          {.reach_m = 3.0, .max_rise_m = 0.3, .allow_unknown = allow_unknown});
  if (!map.ok()) {
    return absl::Status(map.status().code(),
                        absl::StrCat(name, ": ", map.status().message()));
  }
  return std::make_shared<const traversability::NavigationMap>(*std::move(map));
}

Json PoseJson(const core::LevelPose& pose) {
  return {{"x", pose.map_from_base.translation.x},
          {"y", pose.map_from_base.translation.y},
          {"yaw", pose.map_from_base.yaw_rad},
          {"level", pose.place.level},
          {"height_m", pose.place.height_m}};
}

}  // namespace

absl::StatusOr<core::LevelPose> ParsePlanPose(const std::string& text,
                                              const std::string& option) {
  TL_ASSIGN_OR_RETURN(const Numbers numbers,
                      ParseNumbers(text, option, "X,Y,YAW"));
  TL_RETURN_IF_ERROR(base::CheckHeading(option, numbers.values[2]));
  return core::LevelPose{
      .map_from_base = {.translation = {numbers.values[0], numbers.values[1]},
                        .yaw_rad =
                            geometry::NormalizedAngle_rad(numbers.values[2])},
      .place = {.level = numbers.level, .height_m = 0}};
}

absl::StatusOr<planning::Blockage> ParseBlockage(const std::string& text) {
  TL_ASSIGN_OR_RETURN(const Numbers numbers,
                      ParseNumbers(text, "--block", "X,Y,RADIUS"));
  if (!(numbers.values[2] >= 0)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--block is '", Shown(text), "'; its radius must not be below 0"));
  }
  return planning::Blockage{.center = {numbers.values[0], numbers.values[1]},
                            .radius_m = numbers.values[2],
                            .level = numbers.level};
}

absl::StatusOr<std::shared_ptr<const traversability::NavigationMap>>
LoadNavigationMap(const std::string& path, bool allow_unknown) {
  TL_ASSIGN_OR_RETURN(map_bundle::DrivableMap map,
                      map_bundle::LoadDrivableMap(path));
  if (!map.warning.empty()) {
    std::fprintf(stderr, "note: %s: %s\n", path.c_str(), map.warning.c_str());
  }
  return Finished(std::move(map.levels), allow_unknown, path);
}

absl::StatusOr<std::shared_ptr<const traversability::NavigationMap>>
NavigationMapOfWorld(const std::string& name, bool allow_unknown) {
  TL_ASSIGN_OR_RETURN(
      const worlds::World world,
      worlds::MakeWorld(name,
                        {.with_people = false, .threads = 1, .paint = false}));
  TL_ASSIGN_OR_RETURN(const octree::VoxelMap voxels,
                      runs::VoxelsOfWorld(world, kResolution_m));
  TL_ASSIGN_OR_RETURN(traversability::TraversableMap levels,
                      traversability::ExtractTraversableMap(voxels));
  return Finished(std::move(levels), allow_unknown, name);
}

std::string PlanJson(const PlanReport& report) {
  const planning::PlanResult& result = report.result;
  Json json;
  json["map"] = report.map_name;
  json["planner"] = report.planner;
  json["start"] = PoseJson(report.request.start);
  json["goal"] = PoseJson(report.request.goal);
  json["found"] = result.failure == core::NavigationCause::kNone;
  json["cause"] = core::NavigationCauseName(result.failure);
  json["why"] = result.why;
  json["length_m"] = result.length_m;
  json["first_path_s"] = result.first_path_s;
  json["total_s"] = result.total_s;
  json["iterations"] = result.iterations;
  json["moved_start_m"] = result.moved_start_m;
  json["moved_goal_m"] = result.moved_goal_m;
  json["tree_edges"] = result.tree_edges.size() / 2;
  json["path"] = Json::array();
  for (const core::LevelPose& pose : result.path) {
    json["path"].push_back(PoseJson(pose));
  }
  return json.dump(1) + "\n";
}

std::string PlanSummary(const PlanReport& report) {
  const planning::PlanResult& result = report.result;
  if (result.failure != core::NavigationCause::kNone) {
    return absl::StrFormat(
        "No path (%s): %s. %s\n", core::NavigationCauseName(result.failure),
        result.why, core::NavigationCauseAdvice(result.failure));
  }
  std::string text = absl::StrFormat(
      "Path of %.2f m, %d poses; first path after %.1f ms, this one after "
      "%.1f ms and %d iterations\n",
      result.length_m, static_cast<int>(result.path.size()),
      1e3 * result.first_path_s, 1e3 * result.total_s, result.iterations);
  if (result.moved_start_m > 0) {
    absl::StrAppendFormat(&text, "The start had no room: moved by %.2f m\n",
                          result.moved_start_m);
  }
  if (result.moved_goal_m > 0) {
    absl::StrAppendFormat(&text, "The goal had no room: moved by %.2f m\n",
                          result.moved_goal_m);
  }
  return text;
}

}  // namespace treeline::plan_app
