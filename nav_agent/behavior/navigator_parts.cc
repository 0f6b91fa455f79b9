#include "nav_agent/behavior/navigator_parts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "nav_agent/behavior/event_log.h"
#include "nav_agent/behavior/goal_executor.h"
#include "nav_agent/behavior/held_search.h"
#include "nav_agent/behavior/lasers_plane.h"
#include "nav_agent/behavior/navigator_poses.h"
#include "nav_agent/behavior/obstacle_discs.h"
#include "nav_agent/behavior/operator_control.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/place_text.h"
#include "nav_agent/behavior/room_to_move.h"
#include "nav_agent/behavior/safe_stop.h"
#include "nav_agent/behavior/scan_ends.h"
#include "nav_agent/behavior/sensor_monitor.h"

namespace treeline::behavior {
namespace {

class NavigatorOfParts final : public Navigator {
 public:
  NavigatorOfParts(NavigatorParts parts, const core::RobotModel& robot,
                   const NavigatorDevices& devices,
                   const NavigatorOptions& options, const base::Clock& clock);

  void Step() override;
  absl::StatusOr<uint64_t> SetGoal(const NavigationGoal& goal) override;
  absl::Status CancelGoal(uint64_t id) override;
  void Pause() override;
  void Resume() override;
  void Stop(const std::string& why) override;
  void Release() override;
  absl::Status Drive(const core::VelocityCommand& wanted) override;
  absl::Status Steer(const SteeringCommand& steering) override;
  absl::Status SetZones(std::shared_ptr<const zones::ZoneMap> zones) override;
  void SetKnownThings(
      const std::shared_ptr<const localization::KnownThings>& things) override {
    parts_.tracker->SetKnownThings(things);
  }
  absl::Status SetPose(
      const core::LevelPose& pose,
      const localization::PoseCovariance2& covariance) override;
  void FindYourself() override;
  void Halt() override;

  NavigatorMode mode() const override { return mode_; }
  std::optional<GoalStatus> goal() const override { return runner_.status(); }
  NavigatorSnapshot Snapshot() const override;
  std::vector<NavigatorEvent> TakeEvents() override { return events_.Take(); }

 private:
  void FeedTracker();
  void FeedController();
  void FeedCamera();
  void LookThroughBlockages(const control::ControlPose& pose,
                            const core::LaserScan& scan,
                            core::LaserMount mount);
  void ChooseFrame();
  std::vector<StopReason> FindProblems() const;
  std::optional<control::ControlPose> PoseNow() const;
  std::optional<control::ControlPose> PoseAt(base::MonotonicTime stamp) const;
  core::VelocityCommand Decide(const std::optional<SteeringCommand>& steering);
  core::VelocityCommand StepSteering(const control::ControlPose& pose,
                                     const SteeringCommand& steering);
  core::VelocityCommand StepLost(const control::ControlPose& pose);
  bool WouldMoveByItself() const;
  void SetMode(NavigatorMode mode, core::NavigationCause cause,
               std::string text);
  void Command(const core::VelocityCommand& command, bool stops_at_once);

  const NavigatorParts parts_;
  const core::RobotModel robot_;
  const NavigatorDevices devices_;
  const NavigatorOptions options_;
  const base::Clock& clock_;

  EventLog events_;
  SensorMonitor sensors_;
  TiltMonitor tilt_;
  DeadlineMonitor deadline_;
  SafeStop safe_stop_;
  LatchedStop stop_;
  ManualDrive manual_;
  // For the next step; and whether the last one was steered.
  std::optional<SteeringCommand> steering_;
  bool is_steered_ = false;
  GoalExecutor runner_;
  std::shared_ptr<const zones::ZoneMap> zones_;

  base::MonotonicTime now_;
  int64_t steps_ = 0;
  NavigatorMode mode_ = NavigatorMode::kIdle;
  core::NavigationCause cause_ = core::NavigationCause::kNone;
  std::string cause_text_;
  core::VelocityCommand command_;
  bool is_paused_ = false;
  bool is_halted_ = false;
  // Positions are those of the wheels: where it is on the map is not known.
  bool is_unplaced_ = true;
  bool has_looked_for_itself_ = false;
  HeldSearch held_;
  std::optional<base::MonotonicTime> last_frame_;
  std::optional<core::LaserScan> last_scan_;
  int64_t front_scans_ = 0;
  int64_t rear_scans_ = 0;
  int64_t refused_ = 0;  // by tracker or controller
};

NavigatorOfParts::NavigatorOfParts(NavigatorParts parts,
                                   const core::RobotModel& robot,
                                   const NavigatorDevices& devices,
                                   const NavigatorOptions& options,
                                   const base::Clock& clock)
    : parts_(std::move(parts)),
      robot_(robot),
      devices_(devices),
      options_(options),
      clock_(clock),
      sensors_(devices, {.laser_timeout_s = options.laser_timeout_s,
                         .odometry_timeout_s = options.odometry_timeout_s}),
      tilt_(robot, options.limits),
      deadline_(options.control_hz, options.limits, events_),
      safe_stop_(options.limits, events_),
      stop_(events_),
      manual_(events_, options.manual_lease_s),
      runner_(parts_.map, *parts_.planner, *parts_.controller, options,
              events_) {}

// ---- one step ----

void NavigatorOfParts::Step() {
  now_ = clock_.Now();
  events_.SetTime(now_);
  ++steps_;
  parts_.planner->BeginStep();
  deadline_.Step(now_);
  const std::optional<SteeringCommand> steering =
      std::exchange(steering_, std::nullopt);
  is_steered_ = is_steered_ && steering.has_value();
  sensors_.Poll(now_, command_);
  FeedTracker();
  ChooseFrame();
  FeedController();
  FeedCamera();
  if (runner_.blockages().Fade(now_) > 0) runner_.NoteWayIsFree();

  const bool stood = safe_stop_.is_active();
  safe_stop_.Update(FindProblems(), now_);
  if (stop_.is_held()) {
    SetMode(NavigatorMode::kStopped, core::NavigationCause::kStopped,
            stop_.stop()->why);
    Command({}, true);
    return;
  }
  if (safe_stop_.is_active()) {
    if (!stood) runner_.Suspend();
    manual_.End();
    SetMode(NavigatorMode::kSafeStop, safe_stop_.reason().cause,
            safe_stop_.reason().text);
    Command({}, true);
    return;
  }
  Command(Decide(steering), false);
}

void NavigatorOfParts::FeedTracker() {
  // In the order of their stamps.
  const std::vector<core::BaseReading>& readings = sensors_.readings();
  const std::vector<core::LaserScan>& scans = sensors_.scans();
  size_t next = 0;
  const auto add_scans = [&](base::MonotonicTime until) {
    for (; next < scans.size() && scans[next].stamp <= until; ++next) {
      if (!parts_.tracker->AddScan(scans[next]).ok()) ++refused_;
    }
  };
  for (const core::BaseReading& reading : readings) {
    add_scans(reading.stamp);
    tilt_.Add(reading);
    if (!parts_.tracker->AddReading(reading).ok()) ++refused_;
  }
  add_scans(base::MonotonicTime::max());
}

void NavigatorOfParts::ChooseFrame() {
  const bool is_unplaced =
      parts_.lost->IsActive() || !parts_.tracker->Pose().has_value();
  if (is_unplaced == is_unplaced_) return;
  // What was seen is in the other frame.
  is_unplaced_ = is_unplaced;
  parts_.controller->ClearObstacles();
  runner_.Suspend();
  if (is_unplaced) runner_.blockages().Clear();
}

std::optional<control::ControlPose> NavigatorOfParts::PoseNow() const {
  const std::optional<localization::TrackedPose> place = parts_.tracker->Pose();
  if (!is_unplaced_) return ControlPoseOf(place);
  std::optional<control::ControlPose> pose =
      ControlPoseOf(parts_.tracker->Motion());
  const RelocalizationState lost = parts_.lost->state();
  if (!pose.has_value() || !place.has_value()) return pose;
  if (lost != RelocalizationState::kSearching || IsOnlyPlace(*place) ||
      held_.MaySuppose(now_)) {
    pose->supposed = SupposedPlaces(*place, lost);
  }
  return pose;
}

std::optional<control::ControlPose> NavigatorOfParts::PoseAt(
    base::MonotonicTime stamp) const {
  return is_unplaced_ ? ControlPoseOf(parts_.tracker->MotionAt(stamp))
                      : ControlPoseOf(parts_.tracker->PoseAt(stamp));
}

void NavigatorOfParts::FeedController() {
  for (const core::LaserScan& scan : sensors_.scans()) {
    const std::optional<control::ControlPose> pose = PoseAt(scan.stamp);
    if (!pose.has_value()) continue;
    if (!parts_.controller->AddScan(*pose, scan).ok()) ++refused_;
    if (++front_scans_ % kSeeThroughEvery == 0) {
      LookThroughBlockages(*pose, scan, core::LaserMount::kFront);
    }
  }
  if (!sensors_.scans().empty()) last_scan_ = sensors_.scans().back();
  for (const core::LaserScan& scan : sensors_.rear_scans()) {
    const std::optional<control::ControlPose> pose = PoseAt(scan.stamp);
    if (!pose.has_value()) continue;
    if (!parts_.controller->AddRearScan(*pose, scan).ok()) ++refused_;
    if (++rear_scans_ % kSeeThroughEvery == 0) {
      LookThroughBlockages(*pose, scan, core::LaserMount::kRear);
    }
  }
}

void NavigatorOfParts::LookThroughBlockages(const control::ControlPose& pose,
                                            const core::LaserScan& scan,
                                            core::LaserMount mount) {
  if (is_unplaced_ || runner_.blockages().empty()) return;
  const core::RangeSensor& laser =
      mount == core::LaserMount::kRear ? *devices_.rear_laser : devices_.laser;
  const geometry::Rigid3& base_from_laser = robot_.BaseFrom(mount);
  const geometry::Vec3 at = base_from_laser.translation;
  const control::CostmapView costmap = parts_.controller->Costmap();
  const int forgotten = runner_.blockages().SeeThrough(
      pose.pose.place.level,
      pose.pose.map_from_base * geometry::Vec2{at.x, at.y},
      ScanEndsInMap(scan, laser.Info(), base_from_laser,
                    pose.pose.map_from_base, kSeeThroughBeamStep, true),
      [&](const planning::Blockage& blockage) {
        return !IsInLasersPlane(*parts_.map, pose, base_from_laser, blockage) ||
               IsSeenNear(costmap, blockage.center,
                          blockage.radius_m + kBlockageDepth_m);
      });
  if (forgotten == 0) return;
  events_.Add("blocked", "the obstacle in the way is gone");
  runner_.NoteWayIsFree();
}

void NavigatorOfParts::FeedCamera() {
  if (devices_.camera == nullptr) return;
  double rate_hz = options_.depth_hz;
  if (parts_.lost->WantsPictures(now_)) {
    rate_hz = std::max(rate_hz, kLostPictureRate_hz.value);
  }
  if (rate_hz <= 0 ||
      (last_frame_.has_value() &&
       base::SecondsBetween(*last_frame_, now_) < 1 / rate_hz)) {
    return;
  }
  last_frame_ = now_;
  const std::optional<core::RgbdFrame> frame = sensors_.TakeFrame(now_);
  if (!frame.has_value()) return;
  parts_.lost->AddFrame(*frame);
  const std::optional<control::ControlPose> pose = PoseAt(frame->stamp);
  if (options_.depth_hz <= 0 || !pose.has_value()) return;
  if (!parts_.controller->AddDepth(*pose, *frame).ok()) ++refused_;
}

std::vector<StopReason> NavigatorOfParts::FindProblems() const {
  std::vector<StopReason> problems;
  if (std::optional<StopReason> tilted = tilt_.Problem()) {
    problems.push_back(*std::move(tilted));
  }
  for (StopReason& lost : sensors_.Problems()) {
    problems.push_back(std::move(lost));
  }
  if (std::optional<StopReason> late = deadline_.Problem()) {
    problems.push_back(*std::move(late));
  }
  if (std::optional<StopReason> stale = EstimateProblem(PoseNow(), now_)) {
    problems.push_back(*std::move(stale));
  }
  return problems;
}

core::VelocityCommand NavigatorOfParts::Decide(
    const std::optional<SteeringCommand>& steering) {
  const std::optional<control::ControlPose> pose = PoseNow();
  if (is_halted_ || !pose.has_value()) {
    SetMode(NavigatorMode::kIdle, core::NavigationCause::kNone,
            is_halted_ ? "halted" : "waiting for sensors");
    return {};
  }
  if (const auto wanted = manual_.Wanted(now_)) {
    SetMode(NavigatorMode::kManual, core::NavigationCause::kNone,
            "driven by hand");
    return parts_.controller->Guard(*pose, *wanted);
  }
  if (is_paused_) {
    SetMode(NavigatorMode::kPaused, core::NavigationCause::kNone, "paused");
    return parts_.controller->Guard(*pose, {});
  }
  const core::VelocityCommand search = StepLost(*pose);
  if (parts_.lost->IsActive()) return search;
  if (is_unplaced_) {
    // The search has just ended, or nobody has told it anything yet.
    if (!parts_.tracker->Pose().has_value()) {
      SetMode(NavigatorMode::kNeedHelp, core::NavigationCause::kNeedHelp,
              "no start pose was given");
    }
    return parts_.controller->Guard(*pose, {});
  }
  if (steering.has_value()) return StepSteering(*pose, *steering);
  const core::VelocityCommand command = runner_.Step(*pose, now_);
  const core::NavigationCause trouble = runner_.trouble();
  SetMode(ModeOf(runner_.phase()), trouble,
          trouble == core::NavigationCause::kNone
              ? ""
              : core::NavigationCauseAdvice(trouble));
  return command;
}

core::VelocityCommand NavigatorOfParts::StepSteering(
    const control::ControlPose& pose, const SteeringCommand& steering) {
  if (!std::exchange(is_steered_, true)) runner_.Suspend();
  SetMode(NavigatorMode::kDriving, core::NavigationCause::kNone, steering.what);
  return parts_.controller->GuardUpTo(
      {.map_from_docked = steering.docked.map_from_base,
       .is_backward = steering.is_backward},
      pose, steering.wanted);
}

core::VelocityCommand NavigatorOfParts::StepLost(
    const control::ControlPose& pose) {
  if (options_.finds_itself_at_start && !has_looked_for_itself_ &&
      !parts_.tracker->Pose().has_value()) {
    has_looked_for_itself_ = true;
    parts_.lost->Begin(RelocalizationCause::kStart, now_);
  }
  RelocalizationInput input = {
      .now = now_,
      .drives_straight = runner_.DrivesStraight(),
      .is_in_trouble = runner_.trouble() != core::NavigationCause::kNone};
  const bool was_active = parts_.lost->IsActive();
  if (was_active) NoteRoom(*parts_.controller, pose, input);
  const RelocalizationBehavior::Output output = parts_.lost->Step(input);
  for (RelocalizationNote& note : parts_.lost->TakeNotes()) {
    events_.Add(std::move(note.kind), std::move(note.text));
  }
  if (!parts_.lost->IsActive()) return {};
  if (!was_active) runner_.Suspend();
  switch (output.state) {
    case RelocalizationState::kStopping:
      SetMode(NavigatorMode::kLost, core::NavigationCause::kEstimateLost,
              localization::LostReasonName(parts_.tracker->verdict().reason));
      break;
    case RelocalizationState::kNeedHelp:
      SetMode(NavigatorMode::kNeedHelp, core::NavigationCause::kNeedHelp,
              "it is lost; neither the server nor a search found its pose");
      break;
    default:
      SetMode(NavigatorMode::kRelocalizing,
              core::NavigationCause::kEstimateLost,
              RelocalizationStateName(output.state));
  }
  // The frame changes in the next step; until then it only slows down.
  const core::VelocityCommand allowed = parts_.controller->Guard(
      pose, is_unplaced_ ? output.wanted : core::VelocityCommand{});
  held_.Step(output.wanted, allowed, now_);
  return allowed;
}

void NavigatorOfParts::SetMode(NavigatorMode mode, core::NavigationCause cause,
                               std::string text) {
  mode_ = mode;
  cause_ = cause;
  cause_text_ = std::move(text);
}

void NavigatorOfParts::Command(const core::VelocityCommand& command,
                               bool stops_at_once) {
  command_ = command;
  if (!std::isfinite(command.forward_mps) ||
      !std::isfinite(command.yaw_rate_radps)) {
    command_ = {};
    events_.Add("stop", "a velocity that is not finite (internal)");
  }
  if (stops_at_once) devices_.base.Stop();
  sensors_.NoteBaseAnswer(devices_.base.SetVelocity(command_));
}

// ---- what it is told ----

absl::StatusOr<uint64_t> NavigatorOfParts::SetGoal(const NavigationGoal& goal) {
  events_.SetTime(clock_.Now());
  TL_RETURN_IF_ERROR(stop_.Refuse("the goal"));
  if (goal.poses.empty()) {
    return absl::InvalidArgumentError(
        "a goal without poses; it needs one at least");
  }
  for (const core::LevelPose& pose : goal.poses) {
    TL_RETURN_IF_ERROR(CheckOnLevels(pose, "a goal", parts_.map->levels()));
    TL_RETURN_IF_ERROR(CheckNotKeptOut(pose, "the goal", zones_.get()));
  }
  return runner_.Start(goal);
}

absl::Status NavigatorOfParts::CancelGoal(uint64_t id) {
  events_.SetTime(clock_.Now());
  if (!runner_.is_active() || (id != 0 && runner_.status()->id != id)) {
    return absl::NotFoundError(
        id == 0 ? std::string("there is no goal to cancel")
                : absl::StrCat("goal ", id, " is not the current one"));
  }
  runner_.End({.state = GoalState::kCancelled,
               .cause = core::NavigationCause::kCancelled,
               .why = "somebody cancelled it"});
  return absl::OkStatus();
}

void NavigatorOfParts::Pause() {
  events_.SetTime(clock_.Now());
  if (std::exchange(is_paused_, true)) return;
  runner_.Suspend();
  events_.Add("pause", "stands until it is told to go on");
}

void NavigatorOfParts::Resume() {
  events_.SetTime(clock_.Now());
  if (!std::exchange(is_paused_, false)) return;
  events_.Add("resume", "goes on");
}

void NavigatorOfParts::Stop(const std::string& why) {
  now_ = clock_.Now();
  events_.SetTime(now_);
  if (!stop_.Hold(why, now_)) return;
  manual_.End();
  runner_.End({.state = GoalState::kCancelled,
               .cause = core::NavigationCause::kStopped,
               .why = "the robot was stopped: " + why});
}

// A goal has ended with the stop.
bool NavigatorOfParts::WouldMoveByItself() const {
  return parts_.lost->IsActive() ||
         (options_.finds_itself_at_start && !has_looked_for_itself_ &&
          !parts_.tracker->Pose().has_value());
}

void NavigatorOfParts::Release() {
  now_ = clock_.Now();
  events_.SetTime(now_);
  if (stop_.Release(now_) && WouldMoveByItself()) Pause();
}

absl::Status NavigatorOfParts::Drive(const core::VelocityCommand& wanted) {
  now_ = clock_.Now();
  events_.SetTime(now_);
  TL_RETURN_IF_ERROR(stop_.Refuse("driving by hand"));
  TL_RETURN_IF_ERROR(safe_stop_.Refuse("driving by hand"));
  TL_RETURN_IF_ERROR(manual_.Drive(wanted, now_));
  if (runner_.is_active() || WouldMoveByItself()) Pause();
  return absl::OkStatus();
}

absl::Status NavigatorOfParts::Steer(const SteeringCommand& steering) {
  TL_RETURN_IF_ERROR(stop_.Refuse("the dock"));
  TL_RETURN_IF_ERROR(
      CheckSteering(steering, parts_.map->levels(), zones_.get()));
  steering_ = steering;
  return absl::OkStatus();
}

absl::Status NavigatorOfParts::SetZones(
    std::shared_ptr<const zones::ZoneMap> zones) {
  events_.SetTime(clock_.Now());
  const auto has_none = [this] { return zones_ == nullptr || zones_->empty(); };
  const bool had_none = has_none();
  zones_ = std::move(zones);
  if (had_none && has_none()) return absl::OkStatus();
  runner_.SetZones(zones_);
  events_.Add("zones", runner_.is_active() ? "zones have changed: plans anew"
                                           : "zones have changed");
  return absl::OkStatus();
}

absl::Status NavigatorOfParts::SetPose(
    const core::LevelPose& pose,
    const localization::PoseCovariance2& covariance) {
  now_ = clock_.Now();
  events_.SetTime(now_);
  TL_RETURN_IF_ERROR(CheckOnLevels(pose, "a pose", parts_.map->levels()));
  core::LevelPose placed = pose;
  const std::optional<core::LevelPlace> ground =
      parts_.map->GroundOf(pose.map_from_base.translation, pose.place.level);
  if (ground.has_value()) placed.place = *ground;
  TL_RETURN_IF_ERROR(parts_.tracker->SetPose(placed, covariance, now_));
  parts_.lost->NotePoseWasSet(now_);
  has_looked_for_itself_ = true;
  runner_.Suspend();
  runner_.blockages().Clear();
  parts_.controller->ClearObstacles();
  events_.Add("pose", absl::StrCat("told that it is at ", PlaceText(placed)));
  return absl::OkStatus();
}

void NavigatorOfParts::FindYourself() {
  now_ = clock_.Now();
  events_.SetTime(now_);
  has_looked_for_itself_ = true;
  parts_.lost->Begin(RelocalizationCause::kPerson, now_);
  runner_.Suspend();
}

void NavigatorOfParts::Halt() {
  events_.SetTime(clock_.Now());
  is_halted_ = true;
  runner_.End({.state = GoalState::kCancelled,
               .cause = core::NavigationCause::kCancelled,
               .why = "the robot was halted"});
  Command({}, true);
  SetMode(NavigatorMode::kIdle, core::NavigationCause::kNone, "halted");
  events_.Add("stop", "halted");
}

NavigatorSnapshot NavigatorOfParts::Snapshot() const {
  NavigatorSnapshot shot;
  shot.stamp = now_;
  shot.mode = mode_;
  shot.cause = cause_;
  shot.cause_text = cause_text_;
  shot.stop = stop_.stop();
  shot.pose = parts_.tracker->Pose();
  shot.verdict = parts_.tracker->verdict();
  shot.goal = runner_.status();
  shot.command = command_;
  shot.path = runner_.route().path;
  shot.tree_edges = runner_.route().tree_edges;
  shot.bubbles = parts_.controller->Bubbles();
  shot.blockages = runner_.blockages().All();
  if (last_scan_.has_value()) {
    const auto ends_in = [this](const geometry::Rigid2& frame_from_base) {
      return ScanEndsInMap(*last_scan_, devices_.laser.Info(),
                           robot_.base_from_laser, frame_from_base, 1, false);
    };
    shot.scan_in_base = ends_in({});
    const auto pose = parts_.tracker->PoseAt(last_scan_->stamp);
    if (pose.has_value()) shot.scan_in_map = ends_in(pose->pose.map_from_base);
  }
  shot.particles = parts_.tracker->Particles(kShownParticles);
  shot.costmap = parts_.controller->Costmap();
  shot.fix = parts_.lost->answer();
  shot.fix_verdict = parts_.lost->answer_verdict();
  shot.search = parts_.lost->state();
  shot.query_frame = parts_.lost->QueryFrame();
  shot.laser = sensors_.laser();
  shot.rear_laser = sensors_.rear_laser();
  shot.odometry = sensors_.odometry();
  shot.camera = sensors_.camera();
  shot.plans = parts_.planner->Tally();
  shot.steps = steps_;
  shot.missed_deadlines = deadline_.missed();
  shot.longest_step_gap_s = deadline_.longest_gap_s();
  return shot;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Navigator>> AssembleNavigator(
    NavigatorParts parts, const core::RobotModel& robot,
    const NavigatorDevices& devices, const NavigatorOptions& options,
    const base::Clock& clock) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_RETURN_IF_ERROR(robot.Validate());
  return std::make_unique<NavigatorOfParts>(std::move(parts), robot, devices,
                                            options, clock);
}

}  // namespace treeline::behavior
