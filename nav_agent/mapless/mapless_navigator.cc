#include "nav_agent/mapless/mapless_navigator.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/status_macros.h"
#include "nav_agent/behavior/event_log.h"
#include "nav_agent/behavior/operator_control.h"
#include "nav_agent/behavior/safe_stop.h"
#include "nav_agent/behavior/sensor_monitor.h"
#include "nav_agent/mapless/goal_drive.h"
#include "nav_agent/mapless/scan_beams.h"

namespace treeline::mapless {
namespace {

using behavior::NavigatorMode;

constexpr size_t kShownBeamStep = 2;

class MaplessNavigator final : public behavior::Navigator {
 public:
  MaplessNavigator(const core::RobotModel& robot,
                   const behavior::NavigatorDevices& devices,
                   const MaplessOptions& options, const base::Clock& clock)
      : robot_(robot),
        devices_(devices),
        clock_(clock),
        max_range_m_(options.max_range_m),
        known_(options.known),
        sensors_(devices, {.laser_timeout_s = options.laser_timeout_s,
                           .odometry_timeout_s = options.odometry_timeout_s}),
        tilt_(robot, limits_),
        deadline_(options.control_hz, limits_, events_),
        safe_stop_(limits_, events_),
        stop_(events_),
        manual_(events_, options.manual_lease_s),
        drive_(robot, options, events_) {
    MarkKnown();
  }

  void Step() override;
  absl::StatusOr<uint64_t> SetGoal(
      const behavior::NavigationGoal& goal) override;
  absl::Status CancelGoal(uint64_t id) override;
  void Pause() override { is_paused_ = true; }
  void Resume() override { is_paused_ = false; }
  void Stop(const std::string& why) override;
  void Release() override;
  absl::Status Drive(const core::VelocityCommand& wanted) override;
  absl::Status Steer(const behavior::SteeringCommand& /*steering*/) override {
    return absl::FailedPreconditionError(
        "it drives without a map, and so to no dock");
  }
  absl::Status SetZones(std::shared_ptr<const zones::ZoneMap> zones) override;
  absl::Status SetPose(
      const core::LevelPose& pose,
      const localization::PoseCovariance2& covariance) override;
  void FindYourself() override {
    events_.Add("help", "without a map there is nothing to find its place on");
  }
  void Halt() override { is_halted_ = true; }

  NavigatorMode mode() const override { return mode_; }
  std::optional<behavior::GoalStatus> goal() const override {
    return drive_.status();
  }
  behavior::NavigatorSnapshot Snapshot() const override;
  std::vector<behavior::NavigatorEvent> TakeEvents() override {
    return events_.Take();
  }

 private:
  void MarkKnown();
  void FeedScans();
  core::VelocityCommand Decide();
  void Command(const core::VelocityCommand& command, bool stops_at_once);
  std::vector<behavior::StopReason> FindProblems() const;

  const core::RobotModel robot_;
  const behavior::NavigatorDevices devices_;
  const base::Clock& clock_;
  const double max_range_m_;
  const std::vector<core::OccupancyGrid> known_;
  const behavior::NavigatorLimits limits_;

  behavior::EventLog events_;
  behavior::SensorMonitor sensors_;
  behavior::TiltMonitor tilt_;
  behavior::DeadlineMonitor deadline_;
  behavior::SafeStop safe_stop_;
  behavior::LatchedStop stop_;
  behavior::ManualDrive manual_;
  DeadReckoning reckoning_;
  EvidenceGrid map_;
  MoverTracker movers_;
  GoalDrive drive_;

  base::MonotonicTime now_;
  int64_t steps_ = 0;
  NavigatorMode mode_ = NavigatorMode::kIdle;
  core::NavigationCause cause_ = core::NavigationCause::kNone;
  std::string cause_text_;
  core::VelocityCommand command_;
  bool is_paused_ = false;
  bool is_halted_ = false;
  // Of the newest scan, for those who watch.
  std::vector<GridBeam> shown_beams_;
};

void MaplessNavigator::MarkKnown() {
  for (const core::OccupancyGrid& grid : known_) {
    for (int y = 0; y < grid.height; ++y) {
      for (int x = 0; x < grid.width; ++x) {
        if (grid.At({x, y}) == core::Occupancy::kOccupied) {
          map_.Mark(grid.CenterInMap({x, y}));
        }
      }
    }
  }
}

void MaplessNavigator::Step() {
  now_ = clock_.Now();
  events_.SetTime(now_);
  ++steps_;
  deadline_.Step(now_);
  sensors_.Poll(now_, command_);
  for (const core::BaseReading& reading : sensors_.readings()) {
    reckoning_.Add(reading);
    tilt_.Add(reading);
  }
  FeedScans();
  safe_stop_.Update(FindProblems(), now_);
  if (stop_.is_held()) {
    mode_ = NavigatorMode::kStopped;
    cause_ = core::NavigationCause::kStopped;
    cause_text_ = stop_.stop()->why;
    Command({}, true);
    return;
  }
  if (safe_stop_.is_active()) {
    manual_.End();
    mode_ = NavigatorMode::kSafeStop;
    cause_ = safe_stop_.reason().cause;
    cause_text_ = safe_stop_.reason().text;
    Command({}, true);
    return;
  }
  Command(Decide(), false);
}

void MaplessNavigator::FeedScans() {
  const auto feed = [this](const std::vector<core::LaserScan>& scans,
                           const core::RangeSensor& laser,
                           core::LaserMount mount) {
    for (const core::LaserScan& scan : scans) {
      std::vector<GridBeam> beams = BeamsOf(
          scan, laser.Info(), robot_.BaseFrom(mount), reckoning_, max_range_m_);
      movers_.Add(scan.stamp, beams, map_);
      map_.AddScan(beams);
      if (!beams.empty()) shown_beams_ = std::move(beams);
    }
  };
  if (devices_.rear_laser != nullptr) {
    feed(sensors_.rear_scans(), *devices_.rear_laser, core::LaserMount::kRear);
  }
  feed(sensors_.scans(), devices_.laser, core::LaserMount::kFront);
}

std::vector<behavior::StopReason> MaplessNavigator::FindProblems() const {
  std::vector<behavior::StopReason> problems = sensors_.Problems();
  if (std::optional<behavior::StopReason> tilted = tilt_.Problem()) {
    problems.insert(problems.begin(), *std::move(tilted));
  }
  if (std::optional<behavior::StopReason> late = deadline_.Problem()) {
    problems.push_back(*std::move(late));
  }
  return problems;
}

core::VelocityCommand MaplessNavigator::Decide() {
  cause_ = core::NavigationCause::kNone;
  cause_text_.clear();
  const std::optional<ReckonedPose> pose = reckoning_.Newest();
  if (is_halted_ || !pose.has_value() || !sensors_.has_begun()) {
    mode_ = NavigatorMode::kIdle;
    cause_text_ = is_halted_ ? "halted" : "waiting for sensors";
    return {};
  }
  if (const auto wanted = manual_.Wanted(now_)) {
    mode_ = NavigatorMode::kManual;
    cause_text_ = "driven by hand";
    return drive_.Allow(*pose, command_, *wanted, map_, movers_, now_);
  }
  if (is_paused_) {
    mode_ = NavigatorMode::kPaused;
    return {};
  }
  const core::VelocityCommand command =
      drive_.Step(*pose, command_, map_, movers_, now_);
  mode_ = !drive_.is_active()           ? NavigatorMode::kIdle
          : drive_.is_backing_off()     ? NavigatorMode::kRecovering
          : drive_.way().path().empty() ? NavigatorMode::kPlanning
                                        : NavigatorMode::kDriving;
  return command;
}

void MaplessNavigator::Command(const core::VelocityCommand& command,
                               bool stops_at_once) {
  command_ = command;
  if (stops_at_once) devices_.base.Stop();
  sensors_.NoteBaseAnswer(devices_.base.SetVelocity(command));
}

absl::StatusOr<uint64_t> MaplessNavigator::SetGoal(
    const behavior::NavigationGoal& goal) {
  TL_RETURN_IF_ERROR(stop_.Refuse("the goal"));
  if (goal.poses.empty()) {
    return absl::InvalidArgumentError("a goal needs at least one pose");
  }
  for (const core::LevelPose& pose : goal.poses) {
    const geometry::Rigid2& at = pose.map_from_base;
    if (!std::isfinite(at.translation.x) || !std::isfinite(at.translation.y) ||
        !std::isfinite(at.yaw_rad)) {
      return absl::InvalidArgumentError("a goal's pose is not finite");
    }
  }
  return drive_.Begin(goal, now_);
}

absl::Status MaplessNavigator::CancelGoal(uint64_t id) {
  const std::optional<behavior::GoalStatus> status = drive_.status();
  if (!drive_.is_active() || (id != 0 && id != status->id)) {
    return absl::NotFoundError(absl::StrCat("goal ", id, " is not active"));
  }
  drive_.End(behavior::GoalState::kCancelled, core::NavigationCause::kCancelled,
             "cancelled");
  return absl::OkStatus();
}

void MaplessNavigator::Stop(const std::string& why) {
  now_ = clock_.Now();
  events_.SetTime(now_);
  if (!stop_.Hold(why, now_)) return;
  manual_.End();
  if (!drive_.is_active()) return;
  drive_.End(behavior::GoalState::kCancelled, core::NavigationCause::kStopped,
             "the robot was stopped: " + why);
}

void MaplessNavigator::Release() {
  now_ = clock_.Now();
  events_.SetTime(now_);
  stop_.Release(now_);
}

absl::Status MaplessNavigator::Drive(const core::VelocityCommand& wanted) {
  now_ = clock_.Now();
  events_.SetTime(now_);
  TL_RETURN_IF_ERROR(stop_.Refuse("driving by hand"));
  TL_RETURN_IF_ERROR(safe_stop_.Refuse("driving by hand"));
  TL_RETURN_IF_ERROR(manual_.Drive(wanted, now_));
  if (drive_.is_active()) is_paused_ = true;
  return absl::OkStatus();
}

absl::Status MaplessNavigator::SetZones(
    std::shared_ptr<const zones::ZoneMap> zones) {
  if (zones == nullptr || zones->empty()) return absl::OkStatus();
  return absl::FailedPreconditionError(
      "zones are refused: a robot that drives by sight counts its wheels' "
      "turns "
      "alone, and would be out of a zone when it takes itself to be in it");
}

absl::Status MaplessNavigator::SetPose(
    const core::LevelPose& pose,
    const localization::PoseCovariance2& /*covariance*/) {
  const geometry::Rigid2& at = pose.map_from_base;
  if (!std::isfinite(at.translation.x) || !std::isfinite(at.translation.y) ||
      !std::isfinite(at.yaw_rad)) {
    return absl::InvalidArgumentError("the pose is not finite");
  }
  reckoning_.SetPose(at);
  // What was seen lies elsewhere now.
  map_.Clear();
  movers_.Clear();
  MarkKnown();
  drive_.ForgetWay();
  events_.Add("pose", absl::StrFormat("told to be at (%.2f, %.2f)",
                                      at.translation.x, at.translation.y));
  return absl::OkStatus();
}

behavior::NavigatorSnapshot MaplessNavigator::Snapshot() const {
  behavior::NavigatorSnapshot snapshot;
  snapshot.stamp = now_;
  snapshot.mode = mode_;
  snapshot.cause = cause_;
  snapshot.cause_text = cause_text_;
  snapshot.stop = stop_.stop();
  if (const std::optional<ReckonedPose> pose = reckoning_.Newest()) {
    snapshot.pose = localization::TrackedPose{
        .stamp = pose->stamp,
        .pose = {.map_from_base = pose->map_from_base, .place = {}},
        .covariance = {},
        .level_from_base = {},
        .forward_mps = pose->forward_mps,
        .yaw_rate_radps = pose->yaw_rate_radps,
        .share = 1};
  }
  snapshot.goal = drive_.status();
  snapshot.command = command_;
  for (const geometry::Vec2 point : drive_.way().path()) {
    snapshot.path.push_back({.map_from_base = {point, 0}, .place = {}});
  }
  for (size_t i = 0; i < shown_beams_.size(); i += kShownBeamStep) {
    snapshot.scan_in_map.push_back(shown_beams_[i].to);
  }
  snapshot.costmap.origin_in_map = map_.origin();
  snapshot.costmap.resolution_m = map_.cell_m();
  snapshot.costmap.width = map_.width();
  snapshot.costmap.height = map_.height();
  snapshot.costmap.cells = map_.ObstaclesIn(0, 0, map_.width(), map_.height());
  // What was seen, of CostmapView's kinds.
  for (uint8_t& cell : snapshot.costmap.cells) cell = cell != 0 ? 2 : 0;
  snapshot.laser = sensors_.laser();
  snapshot.rear_laser = sensors_.rear_laser();
  snapshot.odometry = sensors_.odometry();
  snapshot.steps = steps_;
  snapshot.missed_deadlines = deadline_.missed();
  snapshot.longest_step_gap_s = deadline_.longest_gap_s();
  return snapshot;
}

}  // namespace

absl::Status MaplessOptions::Validate() const {
  const auto check = [](const char* name, double value, double low,
                        double high) -> absl::Status {
    if (value >= low && value <= high) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrCat(
        "mapless: ", name, " is ", value, "; ", low, " to ", high));
  };
  TL_RETURN_IF_ERROR(check("max_forward_mps", max_forward_mps, 0, 5));
  TL_RETURN_IF_ERROR(check("goal_tolerance_m", goal_tolerance_m, 0.01, 2));
  TL_RETURN_IF_ERROR(
      check("goal_tolerance_rad", goal_tolerance_rad, 0.01, 3.2));
  TL_RETURN_IF_ERROR(check("control_hz", control_hz, 10, 200));
  TL_RETURN_IF_ERROR(check("laser_timeout_s", laser_timeout_s, 0.05, 5));
  TL_RETURN_IF_ERROR(check("odometry_timeout_s", odometry_timeout_s, 0.05, 5));
  TL_RETURN_IF_ERROR(check("max_range_m", max_range_m, 1, 100));
  TL_RETURN_IF_ERROR(check("manual_lease_s", manual_lease_s, 1e-3, 1000));
  return check("patience_s", patience_s, 1, 600);
}

absl::StatusOr<std::unique_ptr<behavior::Navigator>> MakeMaplessNavigator(
    const core::RobotModel& robot, const behavior::NavigatorDevices& devices,
    const MaplessOptions& options, const base::Clock& clock) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_RETURN_IF_ERROR(robot.Validate());
  return std::make_unique<MaplessNavigator>(robot, devices, options, clock);
}

}  // namespace treeline::mapless
