// AMCL over a recording.
#ifndef NAV_AGENT_APP_LOCALIZATION_RUN_H_
#define NAV_AGENT_APP_LOCALIZATION_RUN_H_

#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/image/image.h"
#include "nav_agent/core/occupancy_grid.h"
#include "nav_agent/localization/amcl.h"
#include "nav_agent/recording/laser_log.h"

namespace treeline {

struct LocalizationRunOptions {
  AmclOptions amcl;
  // nullopt: anywhere.
  std::optional<Rigid2> initial_map_from_base;
  uint64_t seed = 0;
};

struct LocalizedScan {
  RecordingTime stamp;
  PlanarEstimate estimate;
  // The share of the scan's beams that end within agreement_m of an obstacle of
  // the map, from the estimate.
  double agreement = 0;
};

inline constexpr double kAgreement_m = 0.2;

struct LocalizationResult {
  std::vector<LocalizedScan> scans;
  // Driven by odometry until the first scan from which on the heaviest cluster
  // held 90 % of the weight for good, within 0.5 m; nullopt: never.
  std::optional<double> converged_after_m;
  // Mean of agreement from there on, or over all.
  double agreement = 0;
  // Processor time of an update (ms): all scans, those that were taken in.
  double median_update_ms = 0;
  double p99_update_ms = 0;
};

// CANCELLED if `stop` is requested. done is called for each scan.
absl::StatusOr<LocalizationResult> LocalizeLog(
    const OccupancyGrid& map, const LaserLog& log,
    const LocalizationRunOptions& options, const std::function<void()>& done,
    const std::stop_token& stop);

// Estimates and figures.
std::string LocalizationJson(const LocalizationResult& result);

// The map with the way that the estimates took, blue, grey before they agreed,
// and the last scan in red. North (+y) is up.
ColorImage DrawLocalization(const OccupancyGrid& map, const LaserLog& log,
                            const LocalizationResult& result);

}  // namespace treeline

#endif  // NAV_AGENT_APP_LOCALIZATION_RUN_H_
