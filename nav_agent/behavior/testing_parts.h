// Parts of a navigator that do what a test tells them.
#ifndef NAV_AGENT_BEHAVIOR_TESTING_PARTS_H_
#define NAV_AGENT_BEHAVIOR_TESTING_PARTS_H_

#include <cmath>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nav_agent/behavior/navigator_parts.h"

namespace treeline::behavior {

// Two levels of 10 x 10 m, all free, one above the other.
inline std::shared_ptr<const traversability::NavigationMap> OpenMap() {
  traversability::TraversableMap map;
  for (const float height_m : {0.0f, 3.0f}) {
    traversability::TraversableLevel level;
    level.grid =
        core::OccupancyGrid::Filled(100, 100, 0.1, {}, core::Occupancy::kFree);
    level.height_m.assign(10000, height_m);
    level.slope_rad.assign(10000, 0);
    level.clearance_m.assign(10000, 3);
    map.levels.push_back(std::move(level));
  }
  return std::make_shared<const traversability::NavigationMap>(
      *traversability::NavigationMap::Make(std::move(map)));
}

inline core::LevelPose PoseAtPoint(double x_m, double y_m, double yaw_rad = 0,
                                   int level = 0) {
  return {.map_from_base = {{x_m, y_m}, yaw_rad},
          .place = {.level = level, .height_m = 3.0 * level}};
}

// Answers what a test put into it, in order; then straight ways.
class FakePlannerWorker final : public PlannerWorker {
 public:
  void Start(const planning::PlanRequest& request,
             const planning::PlanBudget& budget) override {
    requests.push_back(request);
    budgets.push_back(budget);
    is_busy_ = true;
  }
  std::optional<absl::StatusOr<planning::PlanResult>> Take() override {
    if (!is_busy_ || holds) return std::nullopt;
    is_busy_ = false;
    if (!answers.empty()) {
      absl::StatusOr<planning::PlanResult> answer = std::move(answers.front());
      answers.pop_front();
      return answer;
    }
    return Straight(requests.back().start, requests.back().goal);
  }
  bool IsBusy() const override { return is_busy_; }
  PlanTally Tally() const override { return {}; }
  void Cancel() override { is_busy_ = false; }

  static planning::PlanResult Straight(const core::LevelPose& from,
                                       const core::LevelPose& to) {
    planning::PlanResult result;
    result.path = {from, to};
    result.length_m = geometry::Norm(to.map_from_base.translation -
                                     from.map_from_base.translation);
    return result;
  }
  static planning::PlanResult Failure(core::NavigationCause cause,
                                      std::string why) {
    planning::PlanResult result;
    result.failure = cause;
    result.why = std::move(why);
    return result;
  }

  std::vector<planning::PlanRequest> requests;
  std::vector<planning::PlanBudget> budgets;
  std::deque<absl::StatusOr<planning::PlanResult>> answers;
  // Nothing comes while this is set.
  bool holds = false;

 private:
  bool is_busy_ = false;
};

class FakeController final : public control::LocalController {
 public:
  absl::Status AddScan(const control::ControlPose& pose,
                       const core::LaserScan& /*scan*/) override {
    ++scans;
    last_scan_pose = pose;
    return absl::OkStatus();
  }
  absl::Status AddRearScan(const control::ControlPose& /*pose*/,
                           const core::LaserScan& /*scan*/) override {
    ++rear_scans;
    return absl::OkStatus();
  }
  absl::Status AddDepth(const control::ControlPose& /*pose*/,
                        const core::RgbdFrame& /*frame*/) override {
    ++frames;
    return absl::OkStatus();
  }
  void ClearObstacles() override { ++clears; }
  void SetZones(std::shared_ptr<const zones::ZoneMap> told) override {
    zones = std::move(told);
  }
  void SetPath(const std::vector<core::LevelPose>& set) override { path = set; }
  control::ControlResult Step(const control::ControlPose& /*pose*/) override {
    ++steps;
    return result;
  }
  core::VelocityCommand Guard(const control::ControlPose& pose,
                              const core::VelocityCommand& wanted) override {
    last_guarded = pose;
    return guard_stops ? core::VelocityCommand{} : wanted;
  }
  core::VelocityCommand GuardUpTo(
      const control::CloseApproach& approach, const control::ControlPose& pose,
      const core::VelocityCommand& wanted) override {
    last_approach = approach;
    return Guard(pose, wanted);
  }
  bool CanTurn(const control::ControlPose& /*pose*/) const override {
    return can_turn;
  }
  double QuietFor_s(base::MonotonicTime /*now*/) const override {
    return quiet_s;
  }
  double FreeWay_m(const control::ControlPose& /*pose*/,
                   double max_distance_m) const override {
    return std::abs(max_distance_m) > free_m
               ? std::copysign(free_m, max_distance_m)
               : max_distance_m;
  }
  std::shared_ptr<const traversability::FreedCells> Freed() const override {
    return freed;
  }
  std::vector<control::Bubble> Bubbles() const override { return {}; }
  control::CostmapView Costmap() const override { return {}; }

  std::vector<core::LevelPose> path;
  std::shared_ptr<const zones::ZoneMap> zones;
  std::shared_ptr<const traversability::FreedCells> freed;
  control::ControlResult result = {
      .state = control::ControlState::kDriving,
      .command = {.forward_mps = 0.5, .yaw_rate_radps = 0},
      .obstacle_in_map = {},
      .obstacle_radius_m = 0,
      .is_stopped_by_guard = false,
      .to_go_m = 5};
  std::optional<control::CloseApproach> last_approach;
  int scans = 0;
  int rear_scans = 0;
  int frames = 0;
  int clears = 0;
  int steps = 0;
  bool can_turn = true;
  bool guard_stops = false;
  double quiet_s = 100;
  double free_m = 10;
  std::optional<control::ControlPose> last_scan_pose;
  std::optional<control::ControlPose> last_guarded;
};

// Is where the test says, all the time.
class FakeTracker final : public localization::RobotTracker {
 public:
  absl::Status AddReading(const core::BaseReading& reading) override {
    ++readings;
    stamp = reading.stamp;
    forward_mps = reading.forward_mps;
    return absl::OkStatus();
  }
  absl::Status AddScan(const core::LaserScan& /*scan*/) override {
    ++scans;
    return absl::OkStatus();
  }
  absl::Status SetPose(const core::LevelPose& told,
                       const localization::PoseCovariance2& /*covariance*/,
                       base::MonotonicTime /*now*/) override {
    pose = told;
    return absl::OkStatus();
  }
  void StartGlobalLocalization(base::MonotonicTime /*now*/) override {}
  std::optional<localization::TrackedPose> Pose() const override {
    if (!pose.has_value() || readings == 0) return std::nullopt;
    localization::TrackedPose tracked;
    tracked.stamp = stamp;
    tracked.pose = *pose;
    tracked.forward_mps = forward_mps;
    tracked.in_doubt = place_share < 1;
    tracked.place_share = place_share;
    tracked.other_places = others;
    return tracked;
  }
  std::optional<localization::TrackedPose> PoseAt(
      base::MonotonicTime /*stamp*/) const override {
    return Pose();
  }
  std::optional<localization::TrackedMotion> Motion() const override {
    if (readings == 0) return std::nullopt;
    localization::TrackedMotion motion;
    motion.stamp = stamp;
    motion.forward_mps = forward_mps;
    return motion;
  }
  std::optional<localization::TrackedMotion> MotionAt(
      base::MonotonicTime /*stamp*/) const override {
    return Motion();
  }
  const localization::LostVerdict& verdict() const override { return lost; }
  std::optional<localization::ScanFit> FitAt(
      const core::LevelPose& /*pose*/) const override {
    return std::nullopt;
  }
  void BeginOtherPlaces(
      const std::optional<core::LevelPose>& /*than*/) override {}
  bool StepOtherPlaces() override { return true; }
  std::vector<OtherPlace> BestPlaces() const override { return {}; }
  std::vector<float> ExpectedRanges_m(const core::LevelPose& /*pose*/,
                                      int /*directions*/) const override {
    return {};
  }
  std::optional<base::MonotonicTime> ScanStamp() const override {
    return std::nullopt;
  }
  std::vector<geometry::Vec2> ScanInBase() const override { return {}; }
  std::vector<localization::Particle> Particles(
      size_t /*at_most*/) const override {
    return {};
  }
  std::vector<localization::PlaceCandidate> Candidates(
      size_t /*at_most*/) const override {
    return {};
  }
  int64_t dropped() const override { return 0; }

  std::optional<core::LevelPose> pose;
  // Less than 1: in doubt.
  double place_share = 1;
  std::vector<localization::PossiblePlace> others;
  localization::LostVerdict lost;
  base::MonotonicTime stamp;
  double forward_mps = 0;
  int readings = 0;
  int scans = 0;
};

class FakeLost final : public RelocalizationBehavior {
 public:
  bool WantsPictures(base::MonotonicTime /*now*/) const override {
    return wants_pictures;
  }
  void AddFrame(const core::RgbdFrame& /*frame*/) override { ++frames; }
  void Begin(RelocalizationCause cause, base::MonotonicTime /*now*/) override {
    begun.push_back(cause);
    now_state = RelocalizationState::kStopping;
  }
  void NotePoseWasSet(base::MonotonicTime /*now*/) override {
    ++told;
    now_state = RelocalizationState::kIdle;
  }
  Output Step(const RelocalizationInput& input) override {
    ++steps;
    last_input = input;
    return {.state = now_state, .wanted = wanted};
  }
  RelocalizationState state() const override { return now_state; }
  std::vector<RelocalizationNote> TakeNotes() override {
    return std::exchange(notes, {});
  }
  const std::optional<core::RelocalizationAnswer>& answer() const override {
    return fix;
  }
  const std::string& answer_verdict() const override { return verdict; }
  std::shared_ptr<const core::RgbdFrame> QueryFrame() const override {
    return nullptr;
  }

  bool wants_pictures = false;
  RelocalizationState now_state = RelocalizationState::kIdle;
  core::VelocityCommand wanted;
  std::vector<RelocalizationCause> begun;
  std::vector<RelocalizationNote> notes;
  std::optional<core::RelocalizationAnswer> fix;
  std::string verdict;
  RelocalizationInput last_input;
  int frames = 0;
  int told = 0;
  int steps = 0;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_TESTING_PARTS_H_
