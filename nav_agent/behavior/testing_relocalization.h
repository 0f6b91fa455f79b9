// What tests of lost robots are made of: a tracker and a server that do as they
// are told, and a map of two rooms.
#ifndef NAV_AGENT_BEHAVIOR_TESTING_RELOCALIZATION_H_
#define NAV_AGENT_BEHAVIOR_TESTING_RELOCALIZATION_H_

#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nav_agent/behavior/relocalization_behavior.h"

namespace treeline::behavior {

inline constexpr double kStep_s = 0.025;
inline constexpr localization::PoseCovariance2 kCovariance = {
    0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.002};

inline base::MonotonicTime At(double seconds) {
  return base::MonotonicTime() +
         std::chrono::duration_cast<base::MonotonicTime::duration>(
             std::chrono::duration<double>(seconds));
}

inline geometry::Rigid3 Lift(const geometry::Rigid2& pose, double height_m) {
  return {.rotation = geometry::Rotation3::FromAxisAngle({0, 0, pose.yaw_rad}),
          .translation = {pose.translation.x, pose.translation.y, height_m}};
}

// Two rooms of 6 x 6 m with a wall between them, floor at 0.
inline traversability::TraversableMap TwoRooms() {
  traversability::TraversableLevel level;
  level.grid =
      core::OccupancyGrid::Filled(260, 120, 0.05, {}, core::Occupancy::kFree);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 260; ++x) {
      const bool is_wall =
          x < 2 || y < 2 || x >= 258 || y >= 118 || (x >= 120 && x < 140);
      if (is_wall) level.grid.Set({x, y}, core::Occupancy::kOccupied);
    }
  }
  level.height_m.assign(level.grid.cells.size(), -0.025f);
  level.slope_rad.assign(level.grid.cells.size(), 0);
  level.clearance_m.assign(level.grid.cells.size(), 2.5f);
  return {.levels = {level}, .joins = {}};
}

// A robot that turns as it is told, and knows the truth: how well scans fit
// falls with the distance from it.
class ScriptedTracker : public localization::RobotTracker {
 public:
  geometry::Rigid2 truth = {{2, 3}, 0.5};
  geometry::Rigid2 odom_from_base;
  std::optional<core::LevelPose> believed;
  localization::LostVerdict lost_verdict;
  base::MonotonicTime now;
  core::VelocityCommand moves;
  // How many times particles were spread, and places told.
  int spread = 0;
  int told = 0;
  bool searches = false;
  bool is_in_doubt = false;
  // Of what is believed, meanwhile.
  double place_share = 0.5;
  // Other places that are possible, at this moment.
  std::vector<localization::PossiblePlace> others;
  std::function<std::vector<float>(const core::LevelPose&, int)> expected_at;
  // AMCL finds this so long after it was spread (s).
  double finds_after_s = 5;
  std::optional<geometry::Rigid2> finds;
  base::MonotonicTime spread_at;
  // Where scans fit as well as at the truth.
  std::optional<geometry::Rigid2> alias;
  // A search over the map takes so many steps.
  int search_steps = 1;
  // Over the whole map it finds the truth, or this instead.
  bool laser_knows = false;
  std::optional<geometry::Rigid2> laser_says;
  double tilt_rad = 0;
  int judged = 100;
  double best_fit = 0.95;

  void Move(double seconds, const core::VelocityCommand& command) {
    moves = command;
    const geometry::Rigid2 step = {{seconds * command.forward_mps, 0},
                                   seconds * command.yaw_rate_radps};
    odom_from_base = odom_from_base * step;
    truth = truth * step;
    if (alias.has_value()) alias = *alias * step;
    if (finds.has_value()) finds = *finds * step;
    for (localization::PossiblePlace& other : others) {
      other.pose.map_from_base = other.pose.map_from_base * step;
    }
    if (believed.has_value()) {
      believed->map_from_base = believed->map_from_base * step;
    }
    if (searches && finds.has_value() &&
        std::chrono::duration<double>(now - spread_at).count() >
            finds_after_s) {
      searches = false;
      believed = core::LevelPose{.map_from_base = *finds, .place = {}};
    }
  }

  absl::Status AddReading(const core::BaseReading&) override {
    return absl::OkStatus();
  }
  absl::Status AddScan(const core::LaserScan&) override {
    return absl::OkStatus();
  }
  absl::Status SetPose(const core::LevelPose& pose,
                       const localization::PoseCovariance2&,
                       base::MonotonicTime) override {
    believed = pose;
    searches = false;
    is_in_doubt = false;
    others.clear();
    lost_verdict = {};
    ++told;
    return absl::OkStatus();
  }
  void StartGlobalLocalization(base::MonotonicTime when) override {
    ++spread;
    searches = true;
    spread_at = when;
    lost_verdict = {};
    if (!believed.has_value()) believed = core::LevelPose();
  }
  std::optional<localization::TrackedPose> Pose() const override {
    if (!believed.has_value()) return std::nullopt;
    return localization::TrackedPose{
        .stamp = now,
        .pose = *believed,
        .covariance = kCovariance,
        .level_from_base = {},
        .forward_mps = moves.forward_mps,
        .yaw_rate_radps = moves.yaw_rate_radps,
        .share = searches ? 0.1 : 1.0,
        .is_searching = searches,
        .in_doubt = is_in_doubt,
        .place_share = is_in_doubt ? place_share : 1,
        .other_places = others};
  }
  std::optional<localization::TrackedPose> PoseAt(
      base::MonotonicTime) const override {
    return Pose();
  }
  std::optional<localization::TrackedMotion> Motion() const override {
    return localization::TrackedMotion{
        .stamp = now,
        .odom_from_base = odom_from_base,
        .level_from_base = geometry::Rotation3::FromAxisAngle({0, tilt_rad, 0}),
        .forward_mps = moves.forward_mps,
        .yaw_rate_radps = moves.yaw_rate_radps};
  }
  std::optional<localization::TrackedMotion> MotionAt(
      base::MonotonicTime) const override {
    return Motion();
  }
  const localization::LostVerdict& verdict() const override {
    return lost_verdict;
  }
  std::optional<localization::ScanFit> FitAt(
      const core::LevelPose& pose) const override {
    double off_m = Off_m(pose.map_from_base, truth);
    if (alias.has_value()) {
      off_m = std::min(off_m, Off_m(pose.map_from_base, *alias));
    }
    return localization::ScanFit{
        .explained = std::max(0.2, best_fit - 0.5 * off_m),
        .contradicted = std::min(0.5, 0.01 + 0.4 * off_m),
        .judged = judged};
  }
  void BeginOtherPlaces(const std::optional<core::LevelPose>& than) override {
    looks_everywhere_ = !than.has_value();
    search_steps_left_ = search_steps;
    looked_at_truth_ = truth;
  }
  bool StepOtherPlaces() override { return --search_steps_left_ <= 0; }
  std::vector<OtherPlace> BestPlaces() const override {
    const localization::ScanFit fit = {
        .explained = best_fit, .contradicted = 0.01, .judged = judged};
    std::vector<OtherPlace> places;
    if (looks_everywhere_) {
      if (!laser_knows) return {};
      places.push_back(
          {.pose = {.map_from_base = laser_says.value_or(looked_at_truth_),
                    .place = {}},
           .fit = fit});
    }
    if (alias.has_value()) {
      places.push_back(
          {.pose = {.map_from_base = *alias, .place = {}}, .fit = fit});
    }
    return places;
  }
  std::vector<float> ExpectedRanges_m(const core::LevelPose& pose,
                                      int directions) const override {
    if (expected_at) return expected_at(pose, directions);
    return {};
  }
  std::optional<base::MonotonicTime> ScanStamp() const override {
    // Ten times a second.
    const auto tenth = std::chrono::milliseconds(100);
    return base::MonotonicTime() + (now.time_since_epoch() / tenth) * tenth;
  }
  std::vector<geometry::Vec2> ScanInBase() const override {
    std::vector<geometry::Vec2> ends;
    for (int i = -135; i <= 135; ++i) {
      const double angle_rad = i * 0.01745;
      const double range_m = 2 + 1.5 * std::sin(5 * angle_rad);
      ends.push_back(
          {range_m * std::cos(angle_rad), range_m * std::sin(angle_rad)});
    }
    return ends;
  }
  std::vector<localization::Particle> Particles(size_t) const override {
    return {};
  }
  std::vector<localization::PlaceCandidate> Candidates(size_t) const override {
    return {};
  }
  int64_t dropped() const override { return 0; }

 private:
  static double Off_m(const geometry::Rigid2& a, const geometry::Rigid2& b) {
    return geometry::Norm(a.translation - b.translation) +
           std::abs(geometry::NormalizedAngle_rad(a.yaw_rad - b.yaw_rad));
  }
  bool looks_everywhere_ = false;
  int search_steps_left_ = 0;
  geometry::Rigid2 looked_at_truth_;
};

// Answers from a list, then with the last again.
class FakeServer final : public core::RelocalizationPort {
 public:
  using Answer = absl::StatusOr<core::RelocalizationAnswer>;
  explicit FakeServer(ScriptedTracker& tracker) : tracker_(tracker) {}

  std::vector<std::function<Answer()>> answers;
  double delay_s = 0.2;
  int asked = 0;
  std::vector<double> yaws_rad;

  void Ask(const core::RgbdFrame&, double timeout_s) override {
    is_asking_ = true;
    timeout_s_ = timeout_s;
    asked_at_ = tracker_.now;
    ++asked;
    yaws_rad.push_back(tracker_.odom_from_base.yaw_rad);
  }
  std::optional<Answer> TakeAnswer() override {
    const double waited_s =
        std::chrono::duration<double>(tracker_.now - asked_at_).count();
    if (!is_asking_ || (waited_s < delay_s && waited_s < timeout_s_)) {
      return std::nullopt;
    }
    is_asking_ = false;
    if (delay_s > timeout_s_) {
      return Answer(absl::DeadlineExceededError("slow"));
    }
    const auto number = std::min(answers.size(), static_cast<size_t>(asked));
    return answers[number - 1]();
  }
  bool IsAsking() const override { return is_asking_; }
  void Cancel() override { is_asking_ = false; }

 private:
  ScriptedTracker& tracker_;
  bool is_asking_ = false;
  double timeout_s_ = 0;
  base::MonotonicTime asked_at_;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_TESTING_RELOCALIZATION_H_
