// Laser logs made worse: what poor robots would have recorded.
#ifndef EVALUATION_LASER_SLAM_DEGRADED_LOG_H_
#define EVALUATION_LASER_SLAM_DEGRADED_LOG_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "nav_agent/recording/laser_log.h"

namespace treeline::laser_slam {

// What happens to a log. The defaults change nothing.
struct Degradation {
  std::string name = "as recorded";
  // Errors of odometry from one scan to the next, Gaussian: of the way for
  // each metre, of the turn for each radian and for each metre (standard
  // deviations).
  double m_per_m = 0;
  double rad_per_rad = 0;
  double rad_per_m = 0;
  // Turns are told this many times as large: a wrong wheel track (above 0).
  double turn_scale = 1;
  // A way straight ahead is told with a turn of so much for each metre: wheels
  // of two sizes (rad per m).
  double turn_per_m_rad = 0;
  // Every so many metres, on average, the wheels slip: the turn of the next
  // scan is off by a Gaussian of slip_rad, and its way by one of slip_m. 0:
  // never.
  double slip_every_m = 0;
  double slip_m = 0;
  double slip_rad = 0;
  // Of scans and of beams, every so many are kept (1 or more).
  int every_scan = 1;
  int every_beam = 1;
  // After every gap_every scans that are kept, gap_scans are lost. 0: never.
  int gap_every = 0;
  int gap_scans = 0;
  uint64_t seed = 1;

  absl::Status Validate() const;
};

// INVALID_ARGUMENT for a degradation that is not sane, or leaves fewer than two
// scans or beams. Readings of odometry without a scan are left out. A draw
// depends on the seed and the number of the scan alone.
absl::StatusOr<recording::LaserLog> Degraded(const recording::LaserLog& log,
                                             const Degradation& degradation);

// What the robustness table goes through.
std::vector<Degradation> StandardDegradations();

}  // namespace treeline::laser_slam

#endif  // EVALUATION_LASER_SLAM_DEGRADED_LOG_H_
