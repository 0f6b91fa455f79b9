// What laser SLAM may be told.
#ifndef NAV_AGENT_MAPPING_LASER_SLAM_OPTIONS_H_
#define NAV_AGENT_MAPPING_LASER_SLAM_OPTIONS_H_

#include "absl/status/status.h"
#include "nav_agent/mapping/carry_watch.h"
#include "nav_agent/mapping/loop_closer.h"
#include "nav_agent/mapping/odometry_doubt.h"
#include "nav_agent/mapping/pose_graph.h"
#include "nav_agent/mapping/scan_matcher.h"
#include "nav_agent/mapping/scan_outline.h"
#include "nav_agent/mapping/segment_finder.h"

namespace treeline::mapping {

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
  double still_m = 0.05;
  double still_rad = 0.04;
  // Scans are kept, to be laid upon keyscans in the end, that the robot has
  // moved this far since the last of them (m, rad; above 0).
  double between_m = 0.02;
  double between_rad = 0.01;
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
  // A scan that responds by this much less than scans usually do, or by less
  // than min_response, is searched for anew within max_search and as far from
  // odometry; what is found counts if it responds better by better_response.
  // If it still responds poorly, turns of lost_search_rad are searched.
  double poor_response = 0.15;
  double better_response = 0.1;
  double lost_search_rad = 1.6;
  // Below this response, or with fewer points, odometry is used instead.
  double min_response = 0.35;
  int min_points = 20;
  // Whether a robot is noticed that is carried off, or loses its way while the
  // laser is silent: what it sees from then on hangs on nothing until scans
  // have found it in the map, and is left out if they never do. For odometry
  // that is right within what is searched, as with a gyroscope.
  bool notices_carries = false;
  CarryWatchOptions carries;
  SegmentFinderOptions segments;
  // Loops are closed within AddScan, instead of on a thread of their own: slow
  // but the same in every run.
  bool synchronous = false;
  // How often Finish ties all keyscans to their neighbours once more.
  int polish_rounds = 1;

  absl::Status Validate() const;
};

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_LASER_SLAM_OPTIONS_H_
