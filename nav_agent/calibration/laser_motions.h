// How a laser moved, by its own scans.
#ifndef NAV_AGENT_CALIBRATION_LASER_MOTIONS_H_
#define NAV_AGENT_CALIBRATION_LASER_MOTIONS_H_

#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/calibration/drive.h"
#include "nav_agent/calibration/wheel_path.h"
#include "nav_agent/mapping/scan_matcher.h"

namespace treeline::calibration {

// Between two scans.
struct LaserMotion {
  // When their first beams were measured, by the laser's clock (s).
  double begin_s = 0;
  double end_s = 0;
  // Where the laser was at the end, seen from where it was at the beginning.
  geometry::Rigid2 begin_from_end;
  mapping::Covariance3 covariance{};
  // How the match from the end to the beginning differs from that from the
  // beginning to the end.
  geometry::Rigid2 disagreement;
};

struct LaserMotions {
  std::vector<LaserMotion> motions;
  // Stretches of the drive that were looked at, and those of them whose scans
  // did not match, or not alike there and back.
  int stretches = 0;
  int unmatched = 0;
  int disagreed = 0;
};

// The drive in stretches of about half a metre or 20 degrees, one after the
// other; standing still is left out. Each is measured by matching its last scan
// with its first and the first with the last: what a match is biased by where
// one scan sees what the other does not, is of opposite sign in the two. Wheels
// say where to search, but do not count.
//
// FAILED_PRECONDITION with what to do: too few stretches, or too few match.
// CANCELLED.
absl::StatusOr<LaserMotions> MeasureLaserMotions(
    const Drive& drive, const WheelPath& path,
    const std::stop_token& stop = {});

}  // namespace treeline::calibration

#endif  // NAV_AGENT_CALIBRATION_LASER_MOTIONS_H_
