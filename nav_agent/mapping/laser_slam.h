// A map and a trajectory from a planar laser and odometry, on one floor or on
// several that ramps join.
#ifndef NAV_AGENT_MAPPING_LASER_SLAM_H_
#define NAV_AGENT_MAPPING_LASER_SLAM_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "common/geometry/rigid2.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/mapping/laser_slam_options.h"
#include "nav_agent/mapping/loop_closer.h"
#include "nav_agent/mapping/segment_finder.h"
#include "nav_agent/mapping/trajectory_pose.h"
#include "nav_agent/recording/recording_time.h"

namespace treeline::mapping {

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

// The robot was carried off, and what became of it.
struct Carry {
  // Of the first scan that was not of where the robot seemed to be; of the one
  // with which it was found, nullopt: it was not.
  recording::RecordingTime at;
  std::optional<recording::RecordingTime> found;
  SegmentWitness who = SegmentWitness::kScans;
};

struct LaserSlamStatistics {
  int64_t scans = 0;
  int64_t keyscans = 0;
  // Scans that were matched or should have been: the robot had moved.
  int64_t looked_at = 0;
  // Those whose place was taken from odometry because they did not match.
  int64_t unmatched = 0;
  // Scans that were searched for widely, because they responded poorly, and
  // those of them that were found elsewhere.
  int64_t searched_widely = 0;
  int64_t found_widely = 0;
  // How far odometry was off, as learned: times OdometryNoise (1: not more).
  double odometry_scale_m = 1;
  double odometry_scale_rad = 1;
  // One standard deviation of what odometry may have been wrong by over the
  // longest stretch in which nothing matched.
  double unmatched_sigma_m = 0;
  double unmatched_sigma_rad = 0;
  // The front end's processor time for each scan (ms): what else runs on the
  // machine does not count, nor does closing loops.
  std::vector<double> front_end_ms;
  LoopCloserStatistics loops;
  std::vector<Carry> carries;
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

  // Whether nobody knows where the robot is: see
  // LaserSlamOptions::notices_carries.
  virtual bool IsLost() const = 0;
  // Somebody has seen where a lost robot was at `stamp`, of scans since it got
  // lost. It is believed once scans have confirmed it, over a metre of the way.
  // False: it is not lost, or was not at that moment.
  virtual bool SuggestPlace(recording::RecordingTime stamp,
                            const geometry::Rigid2& map_from_base,
                            double height_m) = 0;

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
