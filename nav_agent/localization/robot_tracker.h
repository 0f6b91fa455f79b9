// Where the robot is, from moment to moment: wheels and scans in, a pose on a
// level and lost detection out.
#ifndef NAV_AGENT_LOCALIZATION_ROBOT_TRACKER_H_
#define NAV_AGENT_LOCALIZATION_ROBOT_TRACKER_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/core/level_pose.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/localization/amcl.h"
#include "nav_agent/localization/known_things.h"
#include "nav_agent/localization/lost_detector.h"
#include "nav_agent/localization/parameters.h"
#include "nav_agent/localization/scan_fit.h"
#include "nav_agent/octomap/voxel_map.h"
#include "nav_agent/traversability/traversability.h"

namespace treeline::localization {

struct RobotTrackerOptions {
  AmclOptions amcl;
  LostDetectorOptions lost;
  // Scans that follow a used one sooner are left out (s).
  double scan_interval_s = kScanInterval_s;
  // The same while AMCL looks everywhere, with many more particles (s).
  double searching_interval_s = kSearchingInterval_s;

  absl::Status Validate() const;
};

struct TrackedPose {
  base::MonotonicTime stamp;
  core::LevelPose pose;
  PoseCovariance2 covariance{};
  geometry::Rotation3 level_from_base;
  double forward_mps = 0;
  double yaw_rate_radps = 0;
  // The share of AMCL's weight that agrees, and whether it searches everywhere.
  double share = 0;
  bool is_searching = false;
  // As PlanarEstimate's: whether other places of the map explain what was seen,
  // and this one's share among them. It is not to be relied on then.
  bool in_doubt = false;
  double place_share = 1;
  std::vector<PossiblePlace> other_places = {};
};

// What the wheels and the inertial sensor alone say.
struct TrackedMotion {
  base::MonotonicTime stamp;
  // Drifts, but does not jump.
  geometry::Rigid2 odom_from_base;
  // Pitch and roll (SlopeOdometry::LevelFromBase).
  geometry::Rotation3 level_from_base;
  double forward_mps = 0;
  double yaw_rate_radps = 0;
};

// A place that particles gather at.
struct PlaceCandidate {
  core::LevelPose pose;
  PoseCovariance2 covariance{};
  // Of the weight.
  double share = 0;
};

// Deterministic; not thread-safe.
class RobotTracker {
 public:
  static absl::StatusOr<std::unique_ptr<RobotTracker>> Create(
      const octree::VoxelMap& voxels,
      const traversability::TraversableMap& levels,
      const core::RobotModel& robot, const core::RangeSensorInfo& laser,
      const RobotTrackerOptions& options, uint64_t seed);
  virtual ~RobotTracker() = default;

  // In the order of their stamps, as far as devices give them so. What is
  // older than what was told last (SetPose) is dropped, and counted.
  virtual absl::Status AddReading(const core::BaseReading& reading) = 0;
  virtual absl::Status AddScan(const core::LaserScan& scan) = 0;

  virtual absl::Status SetPose(const core::LevelPose& pose,
                               const PoseCovariance2& covariance,
                               base::MonotonicTime now) = 0;
  // What the verdict does not hold against the place; null: nothing.
  virtual void SetKnownThings(
      const std::shared_ptr<const KnownThings>& /*things*/) {}
  // AMCL looks for the robot everywhere.
  virtual void StartGlobalLocalization(base::MonotonicTime now) = 0;

  // AMCL's newest estimate, carried on with the wheels to the newest reading;
  // nullopt before anything was told.
  virtual std::optional<TrackedPose> Pose() const = 0;
  // At another moment of the last two seconds.
  virtual std::optional<TrackedPose> PoseAt(
      base::MonotonicTime stamp) const = 0;
  // What the wheels say, told or not: newest, and at another moment of the last
  // two seconds; nullopt before the first reading.
  virtual std::optional<TrackedMotion> Motion() const = 0;
  virtual std::optional<TrackedMotion> MotionAt(
      base::MonotonicTime stamp) const = 0;

  virtual const LostVerdict& verdict() const = 0;
  // How well the newest scan fits the map if the robot stands there; for gating
  // fixes. nullopt without a scan.
  virtual std::optional<ScanFit> FitAt(const core::LevelPose& pose) const = 0;
  // Looks over the whole map for places where the newest scan fits, further
  // than 0.7 m or 0.6 rad from `than`: rooms that are alike; nullopt: for all
  // of them. Begun with the scan there is, it goes on a slice (about 2 ms) at a
  // time; true when it is done. Then BestPlaces has at most a dozen, the best
  // first, none within 0.7 m and 0.6 rad of another.
  virtual void BeginOtherPlaces(const std::optional<core::LevelPose>& than) = 0;
  virtual bool StepOtherPlaces() = 0;
  struct OtherPlace {
    core::LevelPose pose;
    ScanFit fit;
  };
  virtual std::vector<OtherPlace> BestPlaces() const = 0;
  // What a laser would measure from a place of the map, in so many directions,
  // evenly spread, counterclockwise from ahead (m): at most
  // kViewRange_m; NaN where the map does not know. Empty: not on a level.
  virtual std::vector<float> ExpectedRanges_m(const core::LevelPose& pose,
                                              int directions) const = 0;
  // The newest scan that was taken in, if there is one.
  virtual std::optional<base::MonotonicTime> ScanStamp() const = 0;
  // Where its beams end, in the frame of the base when that is level (m); those
  // at about the laser's height.
  virtual std::vector<geometry::Vec2> ScanInBase() const = 0;
  virtual std::vector<Particle> Particles(size_t at_most) const = 0;
  // The heaviest first.
  virtual std::vector<PlaceCandidate> Candidates(size_t at_most) const = 0;
  // Scans and readings that came too late, or were broken.
  virtual int64_t dropped() const = 0;
};

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_ROBOT_TRACKER_H_
