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

namespace treeline {

// Two levels of 10 x 10 m, all free, one above the other.
inline std::shared_ptr<const NavigationMap> OpenMap() {
  TraversableMap map;
  for (const float height_m : {0.0f, 3.0f}) {
    TraversableLevel level;
    level.grid = OccupancyGrid::Filled(100, 100, 0.1, {}, Occupancy::kFree);
    level.height_m.assign(10000, height_m);
    level.slope_rad.assign(10000, 0);
    level.clearance_m.assign(10000, 3);
    map.levels.push_back(std::move(level));
  }
  return std::make_shared<const NavigationMap>(
      *NavigationMap::Make(std::move(map)));
}

inline LevelPose PoseAtPoint(double x_m, double y_m, double yaw_rad = 0,
                             int level = 0) {
  return {.map_from_base = {{x_m, y_m}, yaw_rad},
          .place = {.level = level, .height_m = 3.0 * level}};
}

// Answers what a test put into it, in order; then straight ways.
class FakePlanRunner final : public PlanRunner {
 public:
  void Start(const PlanRequest& request, const PlanBudget& budget) override {
    requests.push_back(request);
    budgets.push_back(budget);
    is_busy_ = true;
  }
  std::optional<absl::StatusOr<PlanResult>> Take() override {
    if (!is_busy_ || holds) return std::nullopt;
    is_busy_ = false;
    if (!answers.empty()) {
      absl::StatusOr<PlanResult> answer = std::move(answers.front());
      answers.pop_front();
      return answer;
    }
    return Straight(requests.back().start, requests.back().goal);
  }
  bool IsBusy() const override { return is_busy_; }
  PlanTally Tally() const override { return {}; }
  void Cancel() override { is_busy_ = false; }

  static PlanResult Straight(const LevelPose& from, const LevelPose& to) {
    PlanResult result;
    result.path = {from, to};
    result.length_m =
        Norm(to.map_from_base.translation - from.map_from_base.translation);
    return result;
  }
  static PlanResult Failure(NavigationCause cause, std::string why) {
    PlanResult result;
    result.failure = cause;
    result.why = std::move(why);
    return result;
  }

  std::vector<PlanRequest> requests;
  std::vector<PlanBudget> budgets;
  std::deque<absl::StatusOr<PlanResult>> answers;
  // Nothing comes while this is set.
  bool holds = false;

 private:
  bool is_busy_ = false;
};

class FakeController final : public LocalController {
 public:
  absl::Status AddScan(const ControlPose& pose,
                       const LaserScan& /*scan*/) override {
    ++scans;
    last_scan_pose = pose;
    return absl::OkStatus();
  }
  absl::Status AddRearScan(const ControlPose& /*pose*/,
                           const LaserScan& /*scan*/) override {
    ++rear_scans;
    return absl::OkStatus();
  }
  absl::Status AddDepth(const ControlPose& /*pose*/,
                        const RgbdFrame& /*frame*/) override {
    ++frames;
    return absl::OkStatus();
  }
  void ClearObstacles() override { ++clears; }
  void SetPath(const std::vector<LevelPose>& set) override { path = set; }
  ControlResult Step(const ControlPose& /*pose*/) override {
    ++steps;
    return result;
  }
  VelocityCommand Guard(const ControlPose& pose,
                        const VelocityCommand& wanted) override {
    last_guarded = pose;
    return wanted;
  }
  bool CanTurn(const ControlPose& /*pose*/) const override { return can_turn; }
  double QuietFor_s(MonotonicTime /*now*/) const override { return quiet_s; }
  double FreeWay_m(const ControlPose& /*pose*/,
                   double at_most_m) const override {
    return std::abs(at_most_m) > free_m ? std::copysign(free_m, at_most_m)
                                        : at_most_m;
  }
  std::vector<Bubble> Bubbles() const override { return {}; }
  CostmapView Costmap() const override { return {}; }

  std::vector<LevelPose> path;
  ControlResult result = {.state = ControlState::kDriving,
                          .command = {.forward_mps = 0.5, .yaw_rate_radps = 0},
                          .obstacle_in_map = {},
                          .obstacle_radius_m = 0,
                          .is_stopped_by_guard = false,
                          .to_go_m = 5};
  int scans = 0;
  int rear_scans = 0;
  int frames = 0;
  int clears = 0;
  int steps = 0;
  bool can_turn = true;
  double quiet_s = 100;
  double free_m = 10;
  std::optional<ControlPose> last_scan_pose;
  std::optional<ControlPose> last_guarded;
};

// Is where the test says, all the time.
class FakeTracker final : public RobotTracker {
 public:
  absl::Status AddReading(const BaseReading& reading) override {
    ++readings;
    stamp = reading.stamp;
    forward_mps = reading.forward_mps;
    return absl::OkStatus();
  }
  absl::Status AddScan(const LaserScan& /*scan*/) override {
    ++scans;
    return absl::OkStatus();
  }
  absl::Status SetPose(const LevelPose& told,
                       const PoseCovariance2& /*covariance*/,
                       MonotonicTime /*now*/) override {
    pose = told;
    return absl::OkStatus();
  }
  void SetAnywhere(MonotonicTime /*now*/) override {}
  std::optional<TrackedPose> Pose() const override {
    if (!pose.has_value() || readings == 0) return std::nullopt;
    TrackedPose tracked;
    tracked.stamp = stamp;
    tracked.pose = *pose;
    tracked.forward_mps = forward_mps;
    return tracked;
  }
  std::optional<TrackedPose> PoseAt(MonotonicTime /*stamp*/) const override {
    return Pose();
  }
  std::optional<TrackedMotion> Motion() const override {
    if (readings == 0) return std::nullopt;
    TrackedMotion motion;
    motion.stamp = stamp;
    motion.forward_mps = forward_mps;
    return motion;
  }
  std::optional<TrackedMotion> MotionAt(
      MonotonicTime /*stamp*/) const override {
    return Motion();
  }
  const LostVerdict& verdict() const override { return lost; }
  std::optional<ScanFit> FitAt(const LevelPose& /*pose*/) const override {
    return std::nullopt;
  }
  void BeginOtherPlaces(const std::optional<LevelPose>& /*than*/) override {}
  bool StepOtherPlaces() override { return true; }
  std::vector<OtherPlace> BestPlaces() const override { return {}; }
  std::optional<MonotonicTime> ScanStamp() const override {
    return std::nullopt;
  }
  std::vector<Vec2> ScanInBase() const override { return {}; }
  std::vector<Particle> Particles(size_t /*at_most*/) const override {
    return {};
  }
  std::vector<PlaceCandidate> Candidates(size_t /*at_most*/) const override {
    return {};
  }
  int64_t dropped() const override { return 0; }

  std::optional<LevelPose> pose;
  LostVerdict lost;
  MonotonicTime stamp;
  double forward_mps = 0;
  int readings = 0;
  int scans = 0;
};

class FakeLost final : public LostAndFound {
 public:
  bool WantsPictures(MonotonicTime /*now*/) const override {
    return wants_pictures;
  }
  void AddFrame(const RgbdFrame& /*frame*/) override { ++frames; }
  void Begin(RecoveryCause cause, MonotonicTime /*now*/) override {
    begun.push_back(cause);
    now_state = RecoveryState::kStopping;
  }
  void WasTold(MonotonicTime /*now*/) override {
    ++told;
    now_state = RecoveryState::kIdle;
  }
  Output Step(const RecoveryInput& input) override {
    ++steps;
    last_input = input;
    return {.state = now_state, .wanted = wanted};
  }
  RecoveryState state() const override { return now_state; }
  std::vector<RecoveryNote> TakeNotes() override {
    return std::exchange(notes, {});
  }
  const std::optional<RelocalizationAnswer>& answer() const override {
    return fix;
  }
  const std::string& answer_verdict() const override { return verdict; }
  std::shared_ptr<const RgbdFrame> QueryFrame() const override {
    return nullptr;
  }

  bool wants_pictures = false;
  RecoveryState now_state = RecoveryState::kIdle;
  VelocityCommand wanted;
  std::vector<RecoveryCause> begun;
  std::vector<RecoveryNote> notes;
  std::optional<RelocalizationAnswer> fix;
  std::string verdict;
  RecoveryInput last_input;
  int frames = 0;
  int told = 0;
  int steps = 0;
};

}  // namespace treeline

#endif  // NAV_AGENT_BEHAVIOR_TESTING_PARTS_H_
