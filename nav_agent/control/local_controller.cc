#include "nav_agent/control/local_controller.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "nav_agent/control/band_keeper.h"
#include "nav_agent/control/collision_guard.h"
#include "nav_agent/control/escape.h"
#include "nav_agent/control/goal_approach.h"
#include "nav_agent/control/local_costmap.h"
#include "nav_agent/control/mover_tracks.h"
#include "nav_agent/control/rounded_turn.h"
#include "nav_agent/control/standstill.h"
#include "nav_agent/control/track_follower.h"
#include "nav_agent/control/velocity_limits.h"

namespace treeline::control {
namespace {

// Without a scan for so long the robot stops (s).
constexpr double kScanLifetime_s = 0.3;
constexpr double kDepthLifetime_s = 0.5;
// Scans of both lasers show the same moment if they are not further apart (s).
constexpr double kTogether_s = 0.1;
constexpr double kStanding_mps = 0.02;
constexpr double kStanding_radps = 0.05;
// Room that moves need, and by how much they may come nearer to what is nearer
// than that already (m).
constexpr double kRoom_m = 0.01;
constexpr double kNearer_m = 0.003;
// A robot that waits looks whether it might set off so fast (m/s, rad/s).
constexpr double kProbe_mps = 0.15;
constexpr double kProbe_radps = 0.3;
// A band that breaks so near ahead is broken (m).
constexpr double kBrokenNear_m = 0.35;
// Nobody has moved for so long: nobody is about (s). A robot that has not got
// on for a while dares more: so much less for each second.
constexpr double kQuiet_s = 8;
constexpr double kQuietLeast_s = 1.5;
constexpr double kDaring = 0.5;
// It has got on when it is so far away (m).
constexpr double kGotOn_m = 0.15;

double SecondsBetween(base::MonotonicTime from, base::MonotonicTime until) {
  return std::chrono::duration<double>(until - from).count();
}

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
        options_(options),
        costmap_(std::move(costmap)),
        movers_({}),
        guard_(robot, CollisionGuardOptions()),
        keeper_(std::move(map), KeeperOptions(options)),
        approach_({.tolerance_m = options.goal_tolerance_m,
                   .tolerance_rad = options.goal_tolerance_rad}) {
    follow_.max_forward_mps =
        std::min(options.max_forward_mps, robot.max_forward_mps);
  }

  absl::Status AddScan(const ControlPose& pose,
                       const core::LaserScan& scan) override {
    TL_RETURN_IF_ERROR(costmap_.AddScan(pose, scan));
    FollowMovers(pose, scan);
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
    movers_.Clear();
    behind_.reset();
    standstill_.Reset();
  }

  void SetPath(const std::vector<core::LevelPose>& path) override;
  ControlResult Step(const ControlPose& pose) override;
  core::VelocityCommand Guard(const ControlPose& pose,
                              const core::VelocityCommand& wanted) override;
  bool CanTurn(const ControlPose& pose) const override;
  double FreeWay_m(const ControlPose& pose, double at_most_m) const override;
  double QuietFor_s(base::MonotonicTime now) const override {
    return movers_.last_seen().has_value() && !lasers_.rear.has_value()
               ? SecondsBetween(*movers_.last_seen(), now)
               : std::numeric_limits<double>::infinity();
  }
  std::vector<Bubble> Bubbles() const override;
  CostmapView Costmap() const override;

 private:
  // A command after limits and the collision stop.
  struct Allowed {
    core::VelocityCommand command;
    bool is_limited = false;
    // What limits it, and whether that moves.
    std::optional<geometry::Vec2> point_in_map;
    bool point_moves = false;
  };

  static BandKeeperOptions KeeperOptions(
      const LocalControllerOptions& options) {
    BandKeeperOptions keeper;
    keeper.band.influence_m = std::max(0.05, options.inflation_m);
    return keeper;
  }
  LaserLook LookOf(core::LaserMount mount, const ControlPose& pose,
                   const core::LaserScan& scan) const;
  void FollowMovers(const ControlPose& pose, const core::LaserScan& scan);
  // Each laser has shown something lately.
  bool Sees(base::MonotonicTime now) const;
  std::vector<GuardPoint> GuardPoints(const ControlPose& pose) const;
  Allowed Allow(const ControlPose& pose, const core::VelocityCommand& wanted,
                std::span<const GuardPoint> points);
  // What the collision stop would say of the first step of a command.
  void Probe(const ControlPose& pose, const core::VelocityCommand& wanted,
             std::span<const GuardPoint> points, Allowed& allowed) const;
  core::VelocityCommand Wanted(const ControlPose& pose, const BandTrack& track);
  bool MayBackUp(const ControlPose& pose);
  void JudgeProgress(const ControlPose& pose, const BandTrack& track,
                     const core::VelocityCommand& wanted,
                     const Allowed& allowed, ControlResult& result);

  core::RobotModel robot_;
  core::RobotLasers lasers_;
  LocalControllerOptions options_;
  TrackFollowerOptions follow_;
  LocalCostmap costmap_;
  MoverTracks movers_;
  // The newest scan of what is behind.
  std::optional<LaserLook> behind_;
  CollisionGuard guard_;
  CommandHistory history_;
  BandKeeper keeper_;
  GoalApproach approach_;
  FollowState follow_state_;
  // Where the robot got on last, and when.
  std::optional<std::pair<geometry::Vec2, base::MonotonicTime>> got_on_;
  Escape escape_;
  Standstill standstill_;
};

void BandController::SetPath(const std::vector<core::LevelPose>& path) {
  keeper_.SetPath(path);
  approach_.Reset();
  follow_state_ = {};
  escape_.Reset();
  standstill_.Reset();
}

LaserLook BandController::LookOf(core::LaserMount mount,
                                 const ControlPose& pose,
                                 const core::LaserScan& scan) const {
  return {
      .laser = mount == core::LaserMount::kRear ? *lasers_.rear : lasers_.front,
      .map_from_laser = MapFromBase3(pose) * robot_.BaseFrom(mount),
      .scan = scan,
      .points = costmap_.scan_points(mount)};
}

void BandController::FollowMovers(const ControlPose& pose,
                                  const core::LaserScan& scan) {
  if (pose.map_is_unknown) {
    movers_.Clear();
    return;
  }
  std::vector<LaserLook> looks = {LookOf(core::LaserMount::kFront, pose, scan)};
  if (behind_.has_value() &&
      SecondsBetween(behind_->scan.stamp, scan.stamp) < kTogether_s) {
    looks.push_back(*behind_);
  }
  movers_.AddLooks(scan.stamp, looks);
}

bool BandController::Sees(base::MonotonicTime now) const {
  const auto sees = [&](core::LaserMount mount) {
    const std::optional<base::MonotonicTime> last = costmap_.last_scan(mount);
    return last.has_value() && SecondsBetween(*last, now) < kScanLifetime_s;
  };
  return sees(core::LaserMount::kFront) &&
         (!lasers_.rear.has_value() || sees(core::LaserMount::kRear));
}

std::vector<GuardPoint> BandController::GuardPoints(
    const ControlPose& pose) const {
  const geometry::Rigid2 base_from_map = pose.pose.map_from_base.Inverse();
  const double reach_m = guard_.Reach_m();
  const CollisionGuardOptions& options = guard_.options();
  std::vector<GuardPoint> points;
  // Walls seem to move to a robot that turns and does not know the map.
  const bool knows_movers = !pose.map_is_unknown;
  const auto add_seen = [&](const std::vector<SeenPoint>& seen) {
    geometry::Vec2 last = {1e9, 1e9};
    for (const SeenPoint& point : seen) {
      const geometry::Vec2 in_base = base_from_map * point.in_map;
      // Neighbouring beams that end side by side say the same.
      if (geometry::Norm(in_base) > reach_m ||
          geometry::Norm(in_base - last) < 0.012)
        continue;
      last = in_base;
      const double moving_margin_m =
          knows_movers ? options.body_margin_m : options.moving_margin_m;
      points.push_back(
          {.in_base = in_base,
           .margin_m = point.is_moving ? moving_margin_m
                       : point.is_new  ? options.new_margin_m
                                       : options.point_margin_m,
           .approach_mps = point.is_moving ? options.approach_mps : 0,
           .is_of_body = point.is_moving && knows_movers});
    }
  };
  add_seen(costmap_.scan_points(core::LaserMount::kFront));
  add_seen(costmap_.scan_points(core::LaserMount::kRear));
  if (costmap_.last_depth().has_value() &&
      SecondsBetween(*costmap_.last_depth(), pose.stamp) < kDepthLifetime_s) {
    add_seen(costmap_.depth_points());
  }
  for (const UnseenObstacle& unseen : costmap_.UnseenObstacles(
           pose.pose.map_from_base.translation, reach_m, pose.stamp)) {
    points.push_back({.in_base = base_from_map * unseen.in_map,
                      .margin_m = unseen.is_new ? options.new_margin_m
                                                : options.cell_margin_m});
  }
  if (pose.supposed.has_value()) {
    const geometry::Rigid2 base_from_supposed =
        pose.supposed->map_from_base.Inverse();
    for (const geometry::Vec2& in_map :
         costmap_.MapObstacles(*pose.supposed, reach_m)) {
      points.push_back({.in_base = base_from_supposed * in_map,
                        .margin_m = options.cell_margin_m});
    }
  }
  // Somebody who went out of sight behind the robot is still about.
  for (const Mover& mover : movers_.Movers()) {
    if (mover.unseen_s == 0) continue;
    const geometry::Vec2 in_base = base_from_map * mover.in_map;
    if (geometry::Norm(in_base) > reach_m + mover.doubt_m) continue;
    points.push_back({.in_base = in_base,
                      .margin_m = options.lost_margin_m + mover.doubt_m,
                      .approach_mps = options.approach_mps,
                      .is_of_body = true});
  }
  return points;
}

BandController::Allowed BandController::Allow(
    const ControlPose& pose, const core::VelocityCommand& wanted,
    std::span<const GuardPoint> points) {
  const CommandHistory::Start start = history_.StartAt(
      pose.stamp,
      {.forward_mps = pose.forward_mps, .yaw_rate_radps = pose.yaw_rate_radps},
      robot_);
  Allowed allowed;
  if (!IsFinitePose(pose) || !Sees(pose.stamp) ||
      !std::isfinite(wanted.forward_mps) ||
      !std::isfinite(wanted.yaw_rate_radps)) {
    allowed.is_limited = true;
    allowed.command =
        LimitedTogether(start.velocity, {}, start.interval_s, robot_);
  } else {
    const core::VelocityCommand limited =
        LimitedVelocity(start.velocity, wanted, start.interval_s, robot_);
    const GuardVerdict verdict = guard_.Check(limited, points);
    allowed.is_limited = verdict.is_limited;
    allowed.command = limited;
    if (verdict.is_limited) {
      allowed.command = LimitedTogether(start.velocity, verdict.command,
                                        start.interval_s, robot_);
      allowed.point_in_map = pose.pose.map_from_base * verdict.point_in_base;
      allowed.point_moves = verdict.point_moves;
    }
  }
  history_.Told(pose.stamp, allowed.command);
  return allowed;
}

void BandController::Probe(const ControlPose& pose,
                           const core::VelocityCommand& wanted,
                           std::span<const GuardPoint> points,
                           Allowed& allowed) const {
  const double share = std::min(
      {1.0, kProbe_mps / std::max(std::abs(wanted.forward_mps), 1e-6),
       kProbe_radps / std::max(std::abs(wanted.yaw_rate_radps), 1e-6)});
  const GuardVerdict verdict =
      guard_.Check({.forward_mps = share * wanted.forward_mps,
                    .yaw_rate_radps = share * wanted.yaw_rate_radps},
                   points);
  if (!verdict.is_limited) return;
  allowed.is_limited = true;
  allowed.point_in_map = pose.pose.map_from_base * verdict.point_in_base;
  allowed.point_moves = verdict.point_moves;
}

core::VelocityCommand BandController::Guard(
    const ControlPose& pose, const core::VelocityCommand& wanted) {
  if (!IsFinitePose(pose)) return Allow(pose, wanted, {}).command;
  costmap_.MoveTo(pose);
  costmap_.Update(pose.stamp);
  return Allow(pose, wanted, GuardPoints(pose)).command;
}

core::VelocityCommand BandController::Wanted(const ControlPose& pose,
                                             const BandTrack& track) {
  const geometry::Rigid2& goal = keeper_.progress().goal().map_from_base;
  if (approach_.IsNear(pose.pose.map_from_base, goal,
                       keeper_.progress().left_m())) {
    return approach_.Command(pose.pose.map_from_base, goal, robot_, follow_);
  }
  return FollowTrack(pose.pose.map_from_base, pose.forward_mps, track.points, 0,
                     robot_, follow_, follow_state_);
}

bool BandController::MayBackUp(const ControlPose& pose) {
  const double stood_s = SecondsBetween(got_on_->second, pose.stamp);
  return QuietFor_s(pose.stamp) >=
         std::max(kQuietLeast_s, kQuiet_s - kDaring * stood_s);
}

ControlResult BandController::Step(const ControlPose& pose) {
  ControlResult result;
  if (!IsFinitePose(pose)) {
    result.command = Allow(pose, {}, {}).command;
    result.is_stopped_by_guard = true;
    return result;
  }
  costmap_.MoveTo(pose);
  costmap_.Update(pose.stamp);
  const geometry::Vec2 here = pose.pose.map_from_base.translation;
  if (!got_on_.has_value() ||
      geometry::Norm(here - got_on_->first) > kGotOn_m) {
    got_on_ = {here, pose.stamp};
  }
  const std::vector<GuardPoint> points = GuardPoints(pose);
  if (!keeper_.progress().has_path()) {
    result.command = Allow(pose, {}, points).command;
    return result;
  }
  const BandTrack track = keeper_.Update(pose.pose, costmap_);
  result.to_go_m = keeper_.progress().left_m();
  result.state = ControlState::kDriving;
  core::VelocityCommand wanted = Wanted(pose, track);
  if (approach_.is_done()) {
    const Allowed allowed = Allow(pose, {}, points);
    result.command = allowed.command;
    const bool stands = std::abs(pose.forward_mps) < kStanding_mps &&
                        std::abs(pose.yaw_rate_radps) < kStanding_radps;
    if (stands) result.state = ControlState::kArrived;
    standstill_.Reset();
    return result;
  }
  if (standstill_.WantsEscape() && track.points.size() > 1) {
    wanted = escape_
                 .Find(pose, track.points, wanted, MayBackUp(pose), costmap_,
                       guard_, points)
                 .value_or(wanted);
  } else if (QuietFor_s(pose.stamp) < kQuiet_s && !approach_.is_turning()) {
    wanted = RoundedTurn(pose, wanted, robot_, costmap_, guard_, points);
  }
  // Who waits stands; whether it might go on is looked at all the same.
  const bool holds = standstill_.Holds();
  Allowed allowed =
      Allow(pose, holds ? core::VelocityCommand() : wanted, points);
  if (holds) Probe(pose, wanted, points, allowed);
  result.command = allowed.command;
  result.is_stopped_by_guard = allowed.is_limited;
  JudgeProgress(pose, track, wanted, allowed, result);
  return result;
}

void BandController::JudgeProgress(const ControlPose& pose,
                                   const BandTrack& track,
                                   const core::VelocityCommand& wanted,
                                   const Allowed& allowed,
                                   ControlResult& result) {
  StandstillInput input = {
      .stamp = pose.stamp,
      .at = pose.pose.map_from_base,
      .wants_to_move = wanted.forward_mps != 0 || wanted.yaw_rate_radps != 0};
  double track_m = 0;
  for (size_t i = 1; i < track.points.size(); ++i) {
    track_m +=
        geometry::Norm(track.points[i].in_map - track.points[i - 1].in_map);
  }
  if (track.broken_at.has_value() && track_m < kBrokenNear_m &&
      !approach_.is_turning()) {
    input.obstacle_in_map = *track.broken_at;
    input.is_broken = true;
    const SeenObstacle seen = costmap_.ObstacleNear(
        *track.broken_at, robot_.Circumradius_m() + 0.1, pose.stamp);
    if (seen.radius_m > 0) {
      input.obstacle_in_map = seen.center_in_map;
      input.obstacle_radius_m = seen.radius_m;
    }
    input.obstacle_age_s = seen.age_s;
  }
  if (allowed.point_in_map.has_value()) {
    input.is_guarded = true;
    if (!input.is_broken) {
      input.obstacle_in_map = *allowed.point_in_map;
      const SeenObstacle seen =
          costmap_.ObstacleNear(*allowed.point_in_map, 0.2, pose.stamp);
      if (seen.radius_m > 0) {
        input.obstacle_in_map = seen.center_in_map;
        input.obstacle_radius_m = seen.radius_m;
      }
      input.obstacle_age_s = seen.age_s;
    }
    if (allowed.point_moves) input.obstacle_age_s = 0;
  }
  result.state = standstill_.Judge(input);
  if (result.state == ControlState::kBlocked ||
      result.state == ControlState::kWaiting) {
    // Held by something that nothing sees: it is where the robot wants to go.
    const double ahead_m =
        wanted.forward_mps < 0 ? -robot_.rear_m - 0.1 : robot_.front_m + 0.1;
    result.obstacle_in_map = input.obstacle_in_map.value_or(
        pose.pose.map_from_base * geometry::Vec2{ahead_m, 0});
    result.obstacle_radius_m = std::max(0.1, input.obstacle_radius_m);
  }
}

bool BandController::CanTurn(const ControlPose& pose) const {
  constexpr int kParts = 72;
  // Where it stands too near to something already, it must not get nearer.
  const double needed_m = std::min(
      kRoom_m,
      costmap_.FootprintDistance_m(pose.pose.map_from_base, 0.1) - kNearer_m);
  for (int part = 0; part < kParts; ++part) {
    geometry::Rigid2 turned = pose.pose.map_from_base;
    turned.yaw_rad += 2 * std::acos(-1.0) * part / kParts;
    if (costmap_.FootprintDistance_m(turned, 0.1) <= needed_m) return false;
  }
  return true;
}

double BandController::FreeWay_m(const ControlPose& pose,
                                 double at_most_m) const {
  constexpr double kStep_m = 0.02;
  const double sign = at_most_m < 0 ? -1 : 1;
  double free_m = 0;
  double room_m = costmap_.FootprintDistance_m(pose.pose.map_from_base, 0.1);
  while (free_m < std::abs(at_most_m)) {
    const double next_m = std::min(std::abs(at_most_m), free_m + kStep_m);
    geometry::Rigid2 moved = pose.pose.map_from_base;
    moved.translation = moved * geometry::Vec2{sign * next_m, 0};
    const double there_m = costmap_.FootprintDistance_m(moved, 0.1);
    if (there_m <= std::min(kRoom_m, room_m - kNearer_m)) break;
    room_m = there_m;
    free_m = next_m;
  }
  return sign * free_m;
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
