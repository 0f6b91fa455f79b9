// What laser SLAM may be told.
#ifndef NAV_AGENT_MAPPING_LASER_SLAM_OPTIONS_H_
#define NAV_AGENT_MAPPING_LASER_SLAM_OPTIONS_H_

#include "absl/status/status.h"
#include "nav_agent/mapping/loop_closer.h"
#include "nav_agent/mapping/pose_graph.h"
#include "nav_agent/mapping/scan_matcher.h"
#include "nav_agent/mapping/scan_outline.h"

namespace treeline::mapping {

// How wrong odometry may be, one standard deviation: at rest, per metre and
// per radian; what matching searches is search_sigmas of it, but at least
// min_search, and at most what LaserSlamOptions say. Defaults suit wheels alone
// that tell their turns too.
struct OdometryNoise {
  double m = 0.02;
  double m_per_m = 0.10;
  double m_per_rad = 0.03;
  double rad = 0.01;
  double rad_per_rad = 0.15;
  double rad_per_m = 0.05;
  double min_search_m = 0;
  double min_search_rad = 0;

  // Of wheels with a gyroscope, read every few centimetres. More noise does
  // harm: between parallel walls a scan fits best a little behind of where it
  // was taken, since ahead it shows what the window has not seen.
  static OdometryNoise WithGyroscope() {
    return {.m = 0.003,
            .m_per_m = 0.02,
            .m_per_rad = 0.004,
            .rad = 0.002,
            .rad_per_rad = 0.02,
            .rad_per_m = 0.01,
            .min_search_m = 0.08,
            .min_search_rad = 0.02};
  }
};

struct LaserSlamOptions {
  ScanOutlineOptions points;
  ScanMatcherOptions matcher;
  LoopCloserOptions loops;
  PoseGraphOptions graph;
  // A scan becomes a keyscan once the robot has moved this far since the last
  // one (m, rad; above 0), and is matched at all once it has moved so far since
  // the last that was. What matching corrects is spread over those in between.
  double keyscan_m = 0.2;
  double keyscan_rad = 0.15;
  double still_m = 0.1;
  double still_rad = 0.08;
  // Scans whose planes are farther apart than this are of different floors,
  // and are not matched with each other (m, above 0).
  double max_gap_m = 0.3;
  // Scans whose planes are inclined to each other by more than this see
  // different things: a ramp ahead looks like a wall that moves while the robot
  // tilts. Until min_alike keyscans of the window are inclined alike, odometry
  // decides how far the robot came in the direction of the tilt (m per m, above
  // 0; 1 or more).
  double max_tilt = 0.03;
  int min_alike = 3;
  // Where the robot knows the ground, by having driven there, and not all of it
  // is level: beams that end this near to it, within ground_reach_m of the way,
  // have met floor or ramp and are left out; on a slope, all that end lower
  // than this above the ground that the robot stands on (m; 0: none are). Not
  // for lasers that are lower than twice of it.
  double ground_margin_m = 0.12;
  double ground_reach_m = 0.6;
  // The running window: the scans that the next one is matched against.
  int window = 15;
  OdometryNoise odometry;
  double search_sigmas = 3.0;
  double max_search_m = 1.0;
  double max_search_rad = 0.7;
  // Below this response, or with fewer points, odometry is used instead.
  double min_response = 0.35;
  int min_points = 20;
  // Loops are closed within AddScan, instead of on a thread of their own: slow
  // but the same in every run.
  bool synchronous = false;
  // How often Finish ties all keyscans to their neighbours once more.
  int polish_rounds = 1;

  absl::Status Validate() const;
};

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_LASER_SLAM_OPTIONS_H_
