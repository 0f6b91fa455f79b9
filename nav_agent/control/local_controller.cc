#include "nav_agent/control/local_controller.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "nav_agent/control/band_follower.h"
#include "nav_agent/control/collision_guard.h"
#include "nav_agent/control/driving_parameters.h"
#include "nav_agent/control/dynamic_obstacle_tracker.h"
#include "nav_agent/control/free_room.h"
#include "nav_agent/control/guard_points.h"
#include "nav_agent/control/local_costmap.h"
#include "nav_agent/control/manoeuvre_parameters.h"
#include "nav_agent/control/obstacle_parameters.h"
#include "nav_agent/control/scan_age.h"
#include "nav_agent/control/stuck_detector.h"
#include "nav_agent/control/velocity_limits.h"
#include "nav_agent/control/velocity_regulators.h"

namespace treeline::control {
namespace {

bool IsFinitePose(const ControlPose& pose) {
  return geometry::IsFinite(MapFromBase3(pose)) &&
         std::isfinite(pose.forward_mps) && std::isfinite(pose.yaw_rate_radps);
}

class BandController final : public LocalController {
 public:
  BandController(std::shared_ptr<const traversability::NavigationMap> map,
                 const core::RobotModel& robot, const core::RobotLasers& lasers,
                 const LocalControllerOptions& options, LocalCostmap costmap)
      : robot_(robot),
        lasers_(lasers),
        costmap_(std::move(costmap)),
        dynamic_obstacles_({}),
        guard_(robot, CollisionGuardOptions()),
        keeper_(std::move(map),
                BandFollowerOptions::For(robot, options.inflation_m)),
        regulators_(robot,
                    {.approach = {.tolerance_m = options.goal_tolerance_m,
                                  .tolerance_rad = options.goal_tolerance_rad},
                     .max_forward_mps = options.max_forward_mps,
                     .switches = options.regulators}) {}

  absl::Status AddScan(const ControlPose& pose,
                       const core::LaserScan& scan) override {
    TL_RETURN_IF_ERROR(costmap_.AddScan(pose, scan));
    TrackDynamicObstacles(pose, scan);
    return absl::OkStatus();
  }
  absl::Status AddRearScan(const ControlPose& pose,
                           const core::LaserScan& scan) override {
    TL_RETURN_IF_ERROR(costmap_.AddScan(pose, scan, core::LaserMount::kRear));
    behind_ = LookOf(core::LaserMount::kRear, pose, scan);
    return absl::OkStatus();
  }
  absl::Status AddDepth(const ControlPose& pose,
                        const core::RgbdFrame& frame) override {
    return costmap_.AddDepth(pose, frame);
  }
  void ClearObstacles() override {
    costmap_.ClearObstacles();
    dynamic_obstacles_.Clear();
    behind_.reset();
    standstill_.Reset();
  }

  void SetZones(std::shared_ptr<const zones::ZoneMap> zones) override {
    costmap_.SetZones(std::move(zones));
  }

  void SetPath(const std::vector<core::LevelPose>& path) override;
  ControlResult Step(const ControlPose& pose) override;
  core::VelocityCommand Guard(const ControlPose& pose,
                              const core::VelocityCommand& wanted) override {
    return GuardAlways(nullptr, pose, wanted);
  }
  core::VelocityCommand GuardUpTo(
      const CloseApproach& approach, const ControlPose& pose,
      const core::VelocityCommand& wanted) override {
    return GuardAlways(&approach, pose, wanted);
  }
  bool CanTurn(const ControlPose& pose) const override {
    return CanTurnAt(pose.pose.map_from_base, costmap_);
  }
  double FreeWay_m(const ControlPose& pose,
                   double max_distance_m) const override {
    return FreeWayAt_m(pose.pose.map_from_base, max_distance_m, costmap_);
  }
  double QuietFor_s(base::MonotonicTime now) const override {
    return dynamic_obstacles_.last_seen().has_value() &&
                   !lasers_.rear.has_value()
               ? base::SecondsBetween(*dynamic_obstacles_.last_seen(), now)
               : std::numeric_limits<double>::infinity();
  }
  std::shared_ptr<const traversability::FreedCells> Freed() const override {
    return costmap_.freed();
  }
  std::vector<Bubble> Bubbles() const override;
  CostmapView Costmap() const override;

 private:
  TrackedScan LookOf(core::LaserMount mount, const ControlPose& pose,
                     const core::LaserScan& scan) const;
  void TrackDynamicObstacles(const ControlPose& pose,
                             const core::LaserScan& scan);
  // Each laser has shown something lately.
  bool Sees(base::MonotonicTime now) const;
  // What all commands have in common; those of a path come with more.
  RegulatorInput InputAt(const ControlPose& pose,
                         std::span<const GuardPoint> points) const;
  RegulatorInput InputAlong(const ControlPose& pose, const BandTrack& track,
                            std::span<const GuardPoint> points) const;
  // A command of somebody else, as far as it is allowed.
  RegulatedVelocity Allow(const ControlPose& pose,
                          const core::VelocityCommand& wanted,
                          std::span<const GuardPoint> points);
  // approach: null, or what it drives up to.
  core::VelocityCommand GuardAlways(const CloseApproach* approach,
                                    const ControlPose& pose,
                                    const core::VelocityCommand& wanted);
  void NoteProgress(const ControlPose& pose);
  bool MayBackUp(const ControlPose& pose) const;
  StuckDetectorInput StandstillInputOf(
      const ControlPose& pose, const BandTrack& track,
      const RegulatedVelocity& regulated) const;
  void JudgeProgress(const ControlPose& pose, const BandTrack& track,
                     const RegulatedVelocity& regulated, ControlResult& result);

  core::RobotModel robot_;
  core::RobotLasers lasers_;
  LocalCostmap costmap_;
  DynamicObstacleTracker dynamic_obstacles_;
  // The newest scan of what is behind.
  std::optional<TrackedScan> behind_;
  CollisionGuard guard_;
  LastCommands history_;
  BandFollower keeper_;
  VelocityRegulators regulators_;
  // Where the robot got on last, and when.
  std::optional<std::pair<geometry::Vec2, base::MonotonicTime>> got_on_;
  StuckDetector standstill_;
};

void BandController::SetPath(const std::vector<core::LevelPose>& path) {
  keeper_.SetPath(path);
  regulators_.Reset();
  standstill_.Reset();
}

TrackedScan BandController::LookOf(core::LaserMount mount,
                                   const ControlPose& pose,
                                   const core::LaserScan& scan) const {
  return {
      .laser = mount == core::LaserMount::kRear ? *lasers_.rear : lasers_.front,
      .map_from_laser = MapFromBase3(pose) * robot_.BaseFrom(mount),
      .scan = scan,
      .points = costmap_.scan_points(mount)};
}

void BandController::TrackDynamicObstacles(const ControlPose& pose,
                                           const core::LaserScan& scan) {
  if (pose.map_is_unknown) {
    dynamic_obstacles_.Clear();
    return;
  }
  std::vector<TrackedScan> looks = {
      LookOf(core::LaserMount::kFront, pose, scan)};
  if (behind_.has_value() &&
      base::SecondsBetween(behind_->scan.stamp, scan.stamp) < kLag_s) {
    looks.push_back(*behind_);
  }
  dynamic_obstacles_.AddLooks(scan.stamp, looks);
}

bool BandController::Sees(base::MonotonicTime now) const {
  const auto sees = [&](core::LaserMount mount,
                        const core::RangeSensorInfo& laser) {
    const std::optional<base::MonotonicTime> last = costmap_.last_scan(mount);
    return last.has_value() &&
           base::SecondsBetween(*last, now) <
               std::max<double>(kLately_s, OldestScanToDriveBy_s(laser));
  };
  return sees(core::LaserMount::kFront, lasers_.front) &&
         (!lasers_.rear.has_value() ||
          sees(core::LaserMount::kRear, *lasers_.rear));
}

RegulatorInput BandController::InputAt(
    const ControlPose& pose, std::span<const GuardPoint> points) const {
  return {
      .pose = pose,
      .costmap = costmap_,
      .guard = guard_,
      .points = points,
      .start = history_.StartAt(pose.stamp,
                                {.forward_mps = pose.forward_mps,
                                 .yaw_rate_radps = pose.yaw_rate_radps},
                                robot_),
      .sees = IsFinitePose(pose) && Sees(pose.stamp),
      .max_mps = costmap_.MaxSpeed_mps(pose.pose.map_from_base.translation)};
}

RegulatorInput BandController::InputAlong(
    const ControlPose& pose, const BandTrack& track,
    std::span<const GuardPoint> points) const {
  RegulatorInput input = InputAt(pose, points);
  input.track = track.points;
  input.goal =
      GoalAhead{.map_from_goal = keeper_.progress().goal().map_from_base,
                .left_m = keeper_.progress().left_m()};
  input.should_escape = standstill_.WantsEscape();
  input.should_wait = standstill_.Holds();
  input.people_are_about = QuietFor_s(pose.stamp) < kQuiet_s;
  input.may_back_up = MayBackUp(pose);
  return input;
}

RegulatedVelocity BandController::Allow(const ControlPose& pose,
                                        const core::VelocityCommand& wanted,
                                        std::span<const GuardPoint> points) {
  const RegulatedVelocity allowed =
      regulators_.Allow(InputAt(pose, points), wanted);
  history_.Told(pose.stamp, allowed.velocity);
  return allowed;
}

core::VelocityCommand BandController::GuardAlways(
    const CloseApproach* approach, const ControlPose& pose,
    const core::VelocityCommand& wanted) {
  if (!IsFinitePose(pose)) return Allow(pose, wanted, {}).velocity;
  costmap_.MoveTo(pose);
  costmap_.Update(pose.stamp);
  const std::vector<GuardPoint> points = GuardPointsOf(
      pose, costmap_, dynamic_obstacles_.DynamicObstacles(), guard_, approach);
  return Allow(pose, wanted, points).velocity;
}

void BandController::NoteProgress(const ControlPose& pose) {
  const geometry::Vec2 here = pose.pose.map_from_base.translation;
  if (!got_on_.has_value() ||
      geometry::Norm(here - got_on_->first) > kGotOn_m) {
    got_on_ = {here, pose.stamp};
  }
}

bool BandController::MayBackUp(const ControlPose& pose) const {
  const double stood_s = base::SecondsBetween(got_on_->second, pose.stamp);
  return QuietFor_s(pose.stamp) >=
         std::max(kQuietMin_s.value, kQuiet_s - kImpatience * stood_s);
}

ControlResult BandController::Step(const ControlPose& pose) {
  ControlResult result;
  if (!IsFinitePose(pose)) {
    result.command = Allow(pose, {}, {}).velocity;
    result.is_stopped_by_guard = true;
    return result;
  }
  costmap_.MoveTo(pose);
  costmap_.Update(pose.stamp);
  NoteProgress(pose);
  const std::vector<GuardPoint> points = GuardPointsOf(
      pose, costmap_, dynamic_obstacles_.DynamicObstacles(), guard_);
  if (!keeper_.progress().has_path()) {
    result.command = Allow(pose, {}, points).velocity;
    return result;
  }
  const BandTrack track = keeper_.Update(pose.pose, costmap_);
  const RegulatedVelocity regulated =
      regulators_.Drive(InputAlong(pose, track, points));
  history_.Told(pose.stamp, regulated.velocity);
  result.command = regulated.velocity;
  result.to_go_m = keeper_.progress().left_m();
  if (regulated.is_at_goal) {
    const bool stands = std::abs(pose.forward_mps) < kStandingSpeed_mps &&
                        std::abs(pose.yaw_rate_radps) < kStandingTurn_radps;
    result.state = stands ? ControlState::kArrived : ControlState::kDriving;
    standstill_.Reset();
    return result;
  }
  result.is_stopped_by_guard = regulated.is_limited;
  JudgeProgress(pose, track, regulated, result);
  return result;
}

// What hinders the robot: where its band breaks just ahead, else what the
// guard keeps it from.
StuckDetectorInput BandController::StandstillInputOf(
    const ControlPose& pose, const BandTrack& track,
    const RegulatedVelocity& regulated) const {
  StuckDetectorInput input = {
      .stamp = pose.stamp,
      .at = pose.pose.map_from_base,
      .wants_to_move = regulated.wanted.forward_mps != 0 ||
                       regulated.wanted.yaw_rate_radps != 0};
  const auto look_at = [&](geometry::Vec2 in_map, double reach_m) {
    input.obstacle_in_map = in_map;
    const ObservedObstacle seen =
        costmap_.ObstacleNear(in_map, reach_m, pose.stamp);
    if (seen.radius_m > 0) {
      input.obstacle_in_map = seen.center_in_map;
      input.obstacle_radius_m = seen.radius_m;
    }
    input.obstacle_age_s = seen.age_s;
  };
  double track_m = 0;
  for (size_t i = 1; i < track.points.size(); ++i) {
    track_m +=
        geometry::Norm(track.points[i].in_map - track.points[i - 1].in_map);
  }
  // The front and a cell more.
  if (track.broken_at.has_value() && track_m < robot_.front_m + kCell_m &&
      !regulated.is_turning_at_goal) {
    input.is_broken = true;
    look_at(*track.broken_at, robot_.Circumradius_m() + kTwoCells_m);
  }
  if (regulated.point_in_map.has_value()) {
    input.is_guarded = true;
    if (!input.is_broken) look_at(*regulated.point_in_map, kFourCells_m);
    if (regulated.point_moves) input.obstacle_age_s = 0;
  }
  return input;
}

void BandController::JudgeProgress(const ControlPose& pose,
                                   const BandTrack& track,
                                   const RegulatedVelocity& regulated,
                                   ControlResult& result) {
  const StuckDetectorInput input = StandstillInputOf(pose, track, regulated);
  result.state = standstill_.Judge(input);
  if (result.state == ControlState::kBlocked ||
      result.state == ControlState::kWaiting) {
    // Held by something that nothing sees: it is where the robot wants to go.
    const double ahead_m = regulated.wanted.forward_mps < 0
                               ? -robot_.rear_m - kTwoCells_m
                               : robot_.front_m + kTwoCells_m;
    result.obstacle_in_map = input.obstacle_in_map.value_or(
        pose.pose.map_from_base * geometry::Vec2{ahead_m, 0});
    result.obstacle_radius_m = std::max(kTwoCells_m, input.obstacle_radius_m);
  }
}

std::vector<Bubble> BandController::Bubbles() const {
  std::vector<Bubble> bubbles;
  for (const BandBubble& bubble : keeper_.bubbles()) {
    bubbles.push_back({.center_in_map = bubble.map_from_base.translation,
                       .heading_rad = bubble.map_from_base.yaw_rad,
                       .radius_m = std::max(0.0, bubble.radius_m)});
  }
  return bubbles;
}

CostmapView BandController::Costmap() const {
  const CostmapWindow& window = costmap_.window();
  CostmapView view = {.origin_in_map = window.origin_in_map(),
                      .resolution_m = window.resolution_m(),
                      .width = window.width(),
                      .height = window.height(),
                      .cells = {},
                      .distance_m = costmap_.distances_m()};
  view.cells.reserve(costmap_.cells().size());
  for (const LocalCell cell : costmap_.cells()) {
    view.cells.push_back(static_cast<uint8_t>(cell));
  }
  return view;
}

}  // namespace

absl::Status LocalControllerOptions::Validate() const {
  if (!(inflation_m >= 0 && inflation_m <= 2)) {
    return absl::InvalidArgumentError(
        absl::StrCat("inflation_m must be in [0, 2], not ", inflation_m));
  }
  if (!(goal_tolerance_m >= 0.02 && goal_tolerance_m <= 1 &&
        goal_tolerance_rad >= 0.02 && goal_tolerance_rad <= 3.2)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the goal's tolerances must be in [0.02, 1] m and [0.02, 3.2] rad, "
        "not ",
        goal_tolerance_m, " and ", goal_tolerance_rad));
  }
  if (!(max_forward_mps > 0 && max_forward_mps <= 5)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "max_forward_mps must be in (0, 5], not ", max_forward_mps));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<LocalController>> LocalController::Make(
    std::shared_ptr<const traversability::NavigationMap> map,
    const core::RobotModel& robot, const core::RobotLasers& lasers,
    const LocalControllerOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  LocalCostmapOptions costmap_options;
  costmap_options.length_m = options.costmap_length_m;
  costmap_options.width_m = options.costmap_width_m;
  costmap_options.resolution_m = options.costmap_resolution_m;
  TL_ASSIGN_OR_RETURN(LocalCostmap costmap,
                      LocalCostmap::Make(map, robot, lasers, costmap_options));
  return std::make_unique<BandController>(std::move(map), robot, lasers,
                                          options, std::move(costmap));
}

}  // namespace treeline::control
