// AMCL over a recording.
#ifndef NAV_AGENT_APP_LOCALIZE_LOCALIZATION_RUN_H_
#define NAV_AGENT_APP_LOCALIZE_LOCALIZATION_RUN_H_

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/image/image.h"
#include "nav_agent/app/localize/localize_drive.h"
#include "nav_agent/core/occupancy_grid.h"
#include "nav_agent/localization/amcl.h"

namespace treeline::localize_app {

// What is localized in: one flat map, or several levels with a grid for each to
// be drawn.
struct LocalizationMap {
  std::vector<core::OccupancyGrid> grids;
  std::shared_ptr<const localization::LaserLevelMap> levels;
};

struct LocalizationRunOptions {
  localization::AmclOptions amcl;
  // nullopt: anywhere.
  std::optional<geometry::Rigid2> initial_map_from_base;
  // On levels; nullopt: the lowest ground there.
  std::optional<double> initial_height_m;
  // Whether tilt is used, where it was measured.
  bool use_tilt = true;
  // In a flat map, end points of a robot that leans are left out where they
  // are not between these heights above the ground (m): floor, and over walls.
  double lowest_point_m = 0.1;
  double highest_point_m = 1.0;
  uint64_t seed = 0;
};

struct LocalizedScan {
  recording::RecordingTime stamp;
  localization::PlanarEstimate estimate;
  // The share of the scan's beams that end within agreement_m of an obstacle of
  // the map, from the estimate.
  double agreement = 0;
  // From the truth, if the log knows: along the ground, of the yaw, and in
  // height.
  std::optional<double> error_m;
  double error_rad = 0;
  double height_error_m = 0;
};

inline constexpr double kAgreement_m = 0.2;

// Of a number of errors, all of which are positive.
struct ErrorFigures {
  double rmse = 0;
  double p95 = 0;
  double max = 0;
};

struct LocalizationErrors {
  size_t scans = 0;
  ErrorFigures position_m;
  // The same once estimates and truth are turned and moved onto one another as
  // well as can be: for maps that are not in the frame of the truth, such as
  // those that a robot has made. nullopt if the robot did not move.
  std::optional<ErrorFigures> aligned_m;
  ErrorFigures heading_rad;
  // The share of scans whose height is within 0.5 m of the truth; levels only.
  double right_level = 0;
};

struct LocalizationResult {
  std::vector<LocalizedScan> scans;
  // Driven by odometry until the first scan from which on the heaviest cluster
  // held 90 % of the weight for good, within 0.5 m, and no other place was
  // possible; nullopt: never.
  std::optional<double> converged_after_m;
  // The same until it first did.
  std::optional<double> first_sure_after_m;
  // Mean of agreement from where it converged, or over all.
  double agreement = 0;
  // From where it converged; nullopt without truth, or if it never did.
  std::optional<LocalizationErrors> errors;
  // Processor time of an update (ms): all scans, those that were taken in.
  double median_update_ms = 0;
  double p99_update_ms = 0;
};

// CANCELLED if `stop` is requested. done is called for each scan.
absl::StatusOr<LocalizationResult> LocalizeDrive(
    const LocalizationMap& map, const RecordedDrive& drive,
    const LocalizationRunOptions& options, const std::function<void()>& done,
    const std::stop_token& stop);

// Estimates and figures.
std::string LocalizationJson(const LocalizationResult& result);

// The map of the level where the drive ended, with the way that the estimates
// took on it, blue, grey before they agreed, and the last scan in red. North
// (+y) is up.
image::ColorImage DrawLocalization(const LocalizationMap& map,
                                   const RecordedDrive& drive,
                                   const LocalizationResult& result);

}  // namespace treeline::localize_app

#endif  // NAV_AGENT_APP_LOCALIZE_LOCALIZATION_RUN_H_
