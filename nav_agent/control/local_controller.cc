#include "nav_agent/control/local_controller.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "nav_agent/control/collision_guard.h"
#include "nav_agent/control/goal_approach.h"
#include "nav_agent/control/local_costmap.h"
#include "nav_agent/control/path_progress.h"
#include "nav_agent/control/track_follower.h"
#include "nav_agent/control/velocity_limits.h"

namespace treeline {
namespace {

// Without a scan for so long the robot stops (s).
constexpr double kScanLifetime_s = 0.3;
constexpr double kDepthLifetime_s = 0.5;
// The band's end keeps away from the window's edge: beyond, nothing is known.
constexpr double kInset_m = 0.4;
constexpr double kHorizon_m = 3.0;
constexpr double kTrackStep_m = 0.05;
// Room below which a place counts as taken (m).
constexpr double kTouch_m = 0.0;

double SecondsBetween(MonotonicTime from, MonotonicTime until) {
  return std::chrono::duration<double>(until - from).count();
}

bool IsFinitePose(const ControlPose& pose) {
  return IsFinite(MapFromBase3(pose)) && std::isfinite(pose.forward_mps) &&
         std::isfinite(pose.yaw_rate_radps);
}

class BandController final : public LocalController {
 public:
  BandController(const RobotModel& robot, const LocalControllerOptions& options,
                 LocalCostmap costmap)
      : robot_(robot),
        options_(options),
        costmap_(std::move(costmap)),
        guard_(robot, CollisionGuardOptions()),
        approach_({.tolerance_m = options.goal_tolerance_m,
                   .tolerance_rad = options.goal_tolerance_rad}) {
    follow_.max_forward_mps =
        std::min(options.max_forward_mps, robot.max_forward_mps);
  }

  absl::Status AddScan(const ControlPose& pose,
                       const LaserScan& scan) override {
    return costmap_.AddScan(pose, scan);
  }
  absl::Status AddDepth(const ControlPose& pose,
                        const RgbdFrame& frame) override {
    return costmap_.AddDepth(pose, frame);
  }
  void ClearObstacles() override { costmap_.ClearObstacles(); }

  void SetPath(const std::vector<LevelPose>& path) override;
  ControlResult Step(const ControlPose& pose) override;
  VelocityCommand Guard(const ControlPose& pose,
                        const VelocityCommand& wanted) override;
  bool CanTurn(const ControlPose& pose) const override;
  double FreeWay_m(const ControlPose& pose, double at_most_m) const override;
  std::vector<Bubble> Bubbles() const override;
  CostmapView Costmap() const override;

 private:
  struct Track {
    std::vector<TrackPoint> points;
    bool ends_at_goal = false;
    // Where it is broken.
    std::optional<Vec2> broken_at;
  };

  std::vector<GuardPoint> GuardPoints(const ControlPose& pose) const;
  VelocityCommand Allowed(const ControlPose& pose,
                          const VelocityCommand& wanted, bool* is_limited);
  Track TrackAlongPath(const ControlPose& pose) const;
  VelocityCommand Wanted(const ControlPose& pose, const Track& track);

  RobotModel robot_;
  LocalControllerOptions options_;
  TrackFollowerOptions follow_;
  LocalCostmap costmap_;
  CollisionGuard guard_;
  CommandHistory history_;
  PathProgress progress_;
  GoalApproach approach_;
  FollowState follow_state_;
  std::vector<Bubble> bubbles_;
};

void BandController::SetPath(const std::vector<LevelPose>& path) {
  progress_.SetPath(path);
  approach_.Reset();
  follow_state_ = {};
  bubbles_.clear();
}

std::vector<GuardPoint> BandController::GuardPoints(
    const ControlPose& pose) const {
  const Rigid2 base_from_map = pose.pose.map_from_base.Inverse();
  const double reach_m = guard_.Reach_m();
  const CollisionGuardOptions& options = guard_.options();
  std::vector<GuardPoint> points;
  const auto add_seen = [&](const std::vector<SeenPoint>& seen) {
    Vec2 last = {1e9, 1e9};
    for (const SeenPoint& point : seen) {
      const Vec2 in_base = base_from_map * point.in_map;
      if (Norm(in_base) > reach_m || Norm(in_base - last) < 0.012) continue;
      last = in_base;
      points.push_back(
          {.in_base = in_base,
           .margin_m = point.is_moving ? options.moving_margin_m
                                       : options.point_margin_m,
           .approach_mps = point.is_moving ? options.approach_mps : 0});
    }
  };
  add_seen(costmap_.scan_points());
  if (costmap_.last_depth().has_value() &&
      SecondsBetween(*costmap_.last_depth(), pose.stamp) < kDepthLifetime_s) {
    add_seen(costmap_.depth_points());
  }
  for (const Vec2& center : costmap_.UnseenObstacles(
           pose.pose.map_from_base.translation, reach_m, pose.stamp)) {
    points.push_back(
        {.in_base = base_from_map * center, .margin_m = options.cell_margin_m});
  }
  return points;
}

VelocityCommand BandController::Allowed(const ControlPose& pose,
                                        const VelocityCommand& wanted,
                                        bool* is_limited) {
  *is_limited = false;
  const CommandHistory::Start start = history_.StartAt(
      pose.stamp,
      {.forward_mps = pose.forward_mps, .yaw_rate_radps = pose.yaw_rate_radps},
      robot_);
  VelocityCommand command;
  const bool sees =
      costmap_.last_scan().has_value() &&
      SecondsBetween(*costmap_.last_scan(), pose.stamp) < kScanLifetime_s;
  if (!IsFinitePose(pose) || !sees || !std::isfinite(wanted.forward_mps) ||
      !std::isfinite(wanted.yaw_rate_radps)) {
    *is_limited = true;
    command = LimitedVelocity(start.velocity, {}, start.interval_s, robot_);
  } else {
    const VelocityCommand limited =
        LimitedVelocity(start.velocity, wanted, start.interval_s, robot_);
    const GuardVerdict verdict = guard_.Check(limited, GuardPoints(pose));
    *is_limited = verdict.is_limited;
    command = verdict.is_limited
                  ? LimitedVelocity(start.velocity, verdict.command,
                                    start.interval_s, robot_)
                  : limited;
  }
  history_.Told(pose.stamp, command);
  return command;
}

VelocityCommand BandController::Guard(const ControlPose& pose,
                                      const VelocityCommand& wanted) {
  if (IsFinitePose(pose)) {
    costmap_.MoveTo(pose.pose);
    costmap_.Update(pose.stamp);
  }
  bool is_limited = false;
  return Allowed(pose, wanted, &is_limited);
}

BandController::Track BandController::TrackAlongPath(
    const ControlPose& pose) const {
  Track track;
  track.points.push_back({.in_map = pose.pose.map_from_base.translation});
  const double from_m = progress_.along_m();
  const double length_m = progress_.length_m();
  for (double ahead_m = 0.1;; ahead_m += kTrackStep_m) {
    const bool is_end = from_m + ahead_m >= length_m;
    const LevelPose at =
        is_end ? progress_.goal() : progress_.At(from_m + ahead_m);
    if (!costmap_.Contains(at.map_from_base.translation, kInset_m) ||
        ahead_m > kHorizon_m) {
      return track;
    }
    const double clearance_m =
        costmap_.FootprintDistance_m(at.map_from_base, options_.inflation_m);
    if (clearance_m < kTouch_m) {
      track.broken_at = at.map_from_base.translation;
      return track;
    }
    track.points.push_back(
        {.in_map = at.map_from_base.translation, .clearance_m = clearance_m});
    if (is_end) break;
  }
  track.ends_at_goal = true;
  return track;
}

VelocityCommand BandController::Wanted(const ControlPose& pose,
                                       const Track& track) {
  if (approach_.IsNear(pose.pose.map_from_base, progress_.goal().map_from_base,
                       progress_.left_m())) {
    return approach_.Command(pose.pose.map_from_base,
                             progress_.goal().map_from_base, robot_, follow_);
  }
  return FollowTrack(pose.pose.map_from_base, pose.forward_mps, track.points, 0,
                     robot_, follow_, follow_state_);
}

ControlResult BandController::Step(const ControlPose& pose) {
  ControlResult result;
  if (!IsFinitePose(pose)) {
    result.command = Allowed(pose, {}, &result.is_stopped_by_guard);
    return result;
  }
  costmap_.MoveTo(pose.pose);
  costmap_.Update(pose.stamp);
  if (!progress_.has_path()) {
    result.command = Allowed(pose, {}, &result.is_stopped_by_guard);
    return result;
  }
  progress_.Follow(pose.pose);
  result.to_go_m = progress_.left_m();
  const Track track = TrackAlongPath(pose);
  bubbles_.clear();
  for (const TrackPoint& point : track.points) {
    bubbles_.push_back(
        {.center_in_map = point.in_map, .radius_m = point.clearance_m});
  }
  result.state = ControlState::kDriving;
  result.command =
      Allowed(pose, Wanted(pose, track), &result.is_stopped_by_guard);
  if (approach_.is_done()) {
    const bool stands = std::abs(pose.forward_mps) < 0.02 &&
                        std::abs(pose.yaw_rate_radps) < 0.05;
    if (stands) result.state = ControlState::kArrived;
    return result;
  }
  if (track.broken_at.has_value() &&
      Norm(*track.broken_at - pose.pose.map_from_base.translation) < 0.6 &&
      std::abs(pose.forward_mps) < 0.03) {
    result.state = ControlState::kBlocked;
    result.obstacle_in_map = *track.broken_at;
    result.obstacle_radius_m = 0.3;
  }
  return result;
}

bool BandController::CanTurn(const ControlPose& pose) const {
  constexpr int kParts = 72;
  for (int part = 0; part < kParts; ++part) {
    Rigid2 turned = pose.pose.map_from_base;
    turned.yaw_rad += 2 * std::acos(-1.0) * part / kParts;
    if (costmap_.FootprintDistance_m(turned, 0.1) <= 0.01) return false;
  }
  return true;
}

double BandController::FreeWay_m(const ControlPose& pose,
                                 double at_most_m) const {
  constexpr double kStep_m = 0.02;
  const double sign = at_most_m < 0 ? -1 : 1;
  double free_m = 0;
  while (free_m < std::abs(at_most_m)) {
    const double next_m = std::min(std::abs(at_most_m), free_m + kStep_m);
    Rigid2 moved = pose.pose.map_from_base;
    moved.translation = moved * Vec2{sign * next_m, 0};
    if (costmap_.FootprintDistance_m(moved, 0.1) <= 0.01) break;
    free_m = next_m;
  }
  return sign * free_m;
}

std::vector<Bubble> BandController::Bubbles() const { return bubbles_; }

CostmapView BandController::Costmap() const {
  CostmapView view = {.origin_in_map = costmap_.origin_in_map(),
                      .resolution_m = costmap_.resolution_m(),
                      .width = costmap_.width(),
                      .height = costmap_.height(),
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
    std::shared_ptr<const NavigationMap> map, const RobotModel& robot,
    const RangeSensorInfo& laser, const LocalControllerOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  LocalCostmapOptions costmap_options;
  costmap_options.length_m = options.costmap_length_m;
  costmap_options.width_m = options.costmap_width_m;
  costmap_options.resolution_m = options.costmap_resolution_m;
  TL_ASSIGN_OR_RETURN(
      LocalCostmap costmap,
      LocalCostmap::Make(std::move(map), robot, laser, costmap_options));
  return std::make_unique<BandController>(robot, options, std::move(costmap));
}

}  // namespace treeline
