// A drive through an office floor that never was, with its truth.
#ifndef EVALUATION_LASER_SLAM_SYNTHETIC_OFFICE_H_
#define EVALUATION_LASER_SLAM_SYNTHETIC_OFFICE_H_

#include <cstdint>
#include <span>
#include <vector>

#include "nav_agent/recording/laser_log.h"
#include "nav_agent/recording/relations.h"

namespace treeline::laser_slam {

struct OfficeOptions {
  uint64_t seed = 1;
  int beams = 361;  // over 180 degrees ahead (2 or more)
  double laser_range_m = 20;
  double laser_noise_m = 0.015;  // standard deviation
  double speed_mps = 0.5;        // all above 0
  double turn_radps = 0.7;
  double scans_hz = 5;
};

struct OfficeDrive {
  // Odometry is the truth; see degraded_log.h.
  recording::LaserLog log;
  std::vector<geometry::Rigid2> map_from_base;  // of each scan
};

// Corridors round two blocks of rooms, alike but for doors, alcoves and
// furniture that the seed draws; once round each, with visits to rooms, and a
// part of it driven again the other way. A function of the options.
OfficeDrive DriveThroughOffice(const OfficeOptions& options);

// Where scans are relative to each other, of those that are in both `log` (by
// stamp) and the drive: to the next one a metre on, and between passes of the
// same place.
std::vector<recording::PoseRelation> TrueRelations(
    const OfficeDrive& drive, const recording::LaserLog& log);

}  // namespace treeline::laser_slam

#endif  // EVALUATION_LASER_SLAM_SYNTHETIC_OFFICE_H_
