// Laser SLAM on what the devices of a robot tell, as it comes.
#ifndef NAV_AGENT_MAPPING_ONLINE_MAPPER_H_
#define NAV_AGENT_MAPPING_ONLINE_MAPPER_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/core/slope_odometry.h"
#include "nav_agent/mapping/laser_slam.h"
#include "nav_agent/mapping/recording_mapper.h"

namespace treeline::mapping {

// Scans wait until the wheels have told where the robot was during them. Not
// thread-safe; loops are closed on a thread of its own (options.slam).
class OnlineMapper {
 public:
  // Of the options, `progress`, `stop` and `robot` are not used.
  static absl::StatusOr<std::unique_ptr<OnlineMapper>> Create(
      const core::RangeSensorInfo& laser, const core::RobotModel& robot,
      const RecordingMapOptions& options);

  // INVALID_ARGUMENT, and nothing else has changed: it was refused and
  // counted. See SlopeOdometry::Add.
  absl::Status Add(const core::BaseReading& reading);
  // The same for another number of beams than the laser's and for time that
  // goes backwards.
  absl::Status Add(core::LaserScan scan);

  // The last scan that has found its place; nullopt also while nobody knows
  // where the robot is.
  std::optional<dataset::TimedPose> MapFromBase() const;
  // Whether the robot was carried off and has not been found yet.
  bool IsLost() const { return slam_->IsLost(); }
  // How often it was carried off, and found again.
  std::vector<Carry> Carries() const { return slam_->Statistics().carries; }
  // Somebody has seen where a lost robot was: see LaserSlam::SuggestPlace.
  bool SuggestPlace(base::MonotonicTime stamp,
                    const geometry::Rigid3& map_from_base);
  // How the robot stands, as the inertial sensor says last.
  geometry::Rotation3 LevelFromBase() const {
    return samples_.empty() ? geometry::Rotation3{}
                            : samples_.back().level_from_base;
  }
  int64_t scans() const { return static_cast<int64_t>(odom_from_base_.size()); }

  // Where the robot was at each scan so far of which that is known, with all
  // corrections that have arrived; in the order of time.
  std::vector<dataset::TimedPose> Trajectory() const;

  // What was seen so far, floor by floor, with what is known now. The errors of
  // MapGrid; nothing where too few scans were taken.
  absl::StatusOr<std::vector<FloorGrid>> Floors() const;

  // Scans that still wait are used as well as can be; then SLAM is finished,
  // and everything is as in RecordingMap but for what is the log's: truth,
  // information, calibration, damaged bytes. More may be added afterwards.
  // The errors of MapGrid.
  absl::StatusOr<RecordingMap> Finish();

 private:
  // Odometry at one moment.
  struct Sample {
    base::MonotonicTime stamp;
    geometry::Rigid2 odom_from_base;
    double height_m = 0;
    geometry::Rotation3 level_from_base;
  };
  // What grids are made of.
  struct KeptScan {
    size_t place = 0;  // in the trajectory
    std::vector<float> ranges_m;
  };

  OnlineMapper(const core::RangeSensorInfo& laser,
               const core::RobotModel& robot,
               const RecordingMapOptions& options, core::SlopeOdometry odometry,
               std::unique_ptr<LaserSlam> slam);
  base::MonotonicTime EndOf(const core::LaserScan& scan) const;
  Sample At(base::MonotonicTime time) const;
  void UseWaiting(bool all);
  void Use(const core::LaserScan& scan);
  void KeepForGrid(const core::LaserScan& scan, const Sample& sample,
                   const geometry::Rigid2& first_from_last);
  void Forget();
  absl::StatusOr<std::vector<FloorGrid>> Floors(
      const std::vector<TrajectoryPose>& trajectory) const;
  std::vector<dataset::TimedPose> Timed(
      const std::vector<TrajectoryPose>& trajectory) const;
  std::vector<std::string> CarryWarnings(
      const std::vector<TrajectoryPose>& trajectory) const;
  std::vector<std::string> Warnings() const;

  const core::RangeSensorInfo laser_;
  const core::RobotModel robot_;
  const RecordingMapOptions options_;
  core::SlopeOdometry odometry_;
  std::unique_ptr<LaserSlam> slam_;
  std::deque<Sample> samples_;
  std::deque<core::LaserScan> waiting_;
  std::optional<base::MonotonicTime> last_scan_;
  std::vector<dataset::TimedPose>
      odom_from_base_;  // of each scan that was used
  TrajectoryPose last_;
  std::vector<KeptScan> kept_;
  geometry::Rigid2 odom_from_kept_;
  // What was refused, and why.
  int64_t wrong_beams_ = 0;
  int64_t scans_back_in_time_ = 0;
  int64_t scans_without_odometry_ = 0;
  int64_t refused_readings_ = 0;
  absl::Status first_refused_reading_;
};

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_ONLINE_MAPPER_H_
