// A map and a trajectory from a planar laser and odometry, on one floor or on
// several that ramps join.
#ifndef NAV_AGENT_MAPPING_LASER_SLAM_H_
#define NAV_AGENT_MAPPING_LASER_SLAM_H_

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/geometry/rigid2.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/mapping/loop_closer.h"
#include "nav_agent/mapping/pose_graph.h"
#include "nav_agent/mapping/scan_matcher.h"
#include "nav_agent/mapping/scan_outline.h"
#include "nav_agent/recording/recording_time.h"

namespace treeline::mapping {

// How wrong odometry may be, one standard deviation: at rest, per metre and
// per radian; what matching searches is search_sigmas of it, but at least
// min_search, and at most what LaserSlamOptions say. Defaults suit wheels alone
// that tell their turns too.
struct OdometryUncertainty {
  double m = 0.02;
  double m_per_m = 0.10;
  double m_per_rad = 0.03;
  double rad = 0.01;
  double rad_per_rad = 0.15;
  double rad_per_m = 0.05;
  double min_search_m = 0;
  double min_search_rad = 0;

  // Of wheels with a gyroscope, looked at every few centimetres. More doubt
  // costs: between parallel walls a scan fits best a little behind of where it
  // was taken, since ahead it shows what the window has not seen.
  static OdometryUncertainty WithGyroscope() {
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
  OdometryUncertainty odometry;
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

struct LaserSlamScan {
  // Must not decrease from scan to scan.
  recording::RecordingTime stamp;
  geometry::Rigid2 odom_from_base;
  // One for each beam; what is no return as in LaserScan. Those that are NaN
  // are passed over.
  std::span<const float> ranges_m;
  // Of the robot when the scan was taken: roll and pitch, with yaw and
  // translation 0. With the laser's mount it says where in space the beams
  // are.
  geometry::Rotation3 level_from_base{};
  // Of the base in odometry: only differences mean anything.
  double height_m = 0;
  // How the robot moved, seen from above, from the first beam to the last.
  geometry::Rigid2 first_from_last{};
};

struct TrajectoryPose {
  recording::RecordingTime stamp;
  geometry::Rigid2 map_from_base;
  // Above the first scan, and as the scan says; see MapFromBase.
  double height_m = 0;
  geometry::Rotation3 level_from_base{};
};

// In space: Rz(yaw) level_from_base, at (x, y, height).
geometry::Rigid3 MapFromBase(const TrajectoryPose& pose);

struct LaserSlamStatistics {
  int64_t scans = 0;
  int64_t keyscans = 0;
  // Scans whose place was taken from odometry because they did not match.
  int64_t unmatched = 0;
  // The front end's processor time for each scan (ms): what else runs on the
  // machine does not count, nor does closing loops.
  std::vector<double> front_end_ms;
  LoopCloserStatistics loops;
};

// The front end, on the caller's thread: each scan is matched against a running
// window, in time that does not grow with the map. The back end, on its own
// thread, closes loops; its corrections arrive between scans. Methods are for
// one thread.
class LaserSlam {
 public:
  // INVALID_ARGUMENT for options or a laser that are not sane.
  static absl::StatusOr<std::unique_ptr<LaserSlam>> Create(
      const core::RangeSensorInfo& laser,
      const geometry::Rigid3& base_from_laser, const LaserSlamOptions& options);
  virtual ~LaserSlam() = default;

  // The robot's place with all that is known now. INVALID_ARGUMENT, and
  // nothing is changed, if the scan has another number of beams than the
  // laser, if its pose is not finite or if time went backwards.
  //
  // Matching is planar, in the frame that pitch and roll level. Height follows
  // odometry along the slope, by as much as the matched way is longer or
  // shorter than odometry's: wheels slip on slopes.
  virtual absl::StatusOr<geometry::Rigid2> AddScan(
      const LaserSlamScan& scan) = 0;

  // Of the last scan, above the first (m).
  virtual double Height_m() const = 0;

  // Waits for the back end, and lets it take what time it needs for the best
  // trajectory. Scans may still be added afterwards.
  virtual void Finish() = 0;

  // One pose for each scan, with all corrections that have arrived.
  virtual std::vector<TrajectoryPose> Trajectory() const = 0;
  virtual LaserSlamStatistics Statistics() const = 0;

 protected:
  LaserSlam() = default;
};

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_LASER_SLAM_H_
