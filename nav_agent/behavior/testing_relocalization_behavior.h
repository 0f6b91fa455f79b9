// For tests: a lost robot on a map of two rooms, with a tracker, a server and a
// camera that do as they are told.
#ifndef NAV_AGENT_BEHAVIOR_TESTING_RELOCALIZATION_BEHAVIOR_H_
#define NAV_AGENT_BEHAVIOR_TESTING_RELOCALIZATION_BEHAVIOR_H_

#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "gtest/gtest.h"
#include "nav_agent/behavior/relocalization_behavior.h"
#include "nav_agent/behavior/testing_relocalization.h"

namespace treeline::behavior {

class RelocalizationBehaviorTest : public testing::Test {
 protected:
  RelocalizationBehaviorTest() {
    tracker_.now = At(100);
    tracker_.believed =
        core::LevelPose{.map_from_base = {{10, 1}, 2}, .place = {}};
    server_.answers = {[this] { return Truth(0.97); }};
    Make();
  }
  void Make() {
    lost_ = *RelocalizationBehavior::Create(map_, robot_, tracker_, &server_,
                                            options_);
  }

  core::RelocalizationAnswer AnswerAt(const geometry::Rigid3& map_from_base,
                                      double confidence) const {
    core::RelocalizationAnswer answer;
    answer.localized = true;
    answer.confidence = confidence;
    answer.map_from_camera = map_from_base * robot_.base_from_camera;
    for (size_t i = 0; i < 36; i += 7) answer.covariance[i] = 1e-4;
    return answer;
  }
  core::RelocalizationAnswer Truth(double confidence) const {
    return AnswerAt(Lift(tracker_.truth, 0.02), confidence);
  }
  void BeLost() {
    tracker_.lost_verdict.state = localization::LostState::kLost;
    tracker_.lost_verdict.probability = 0.99;
  }
  RelocalizationState Step() {
    tracker_.now += std::chrono::milliseconds(25);
    if (has_camera_) {
      core::RgbdFrame frame;
      frame.stamp = tracker_.now;
      lost_->AddFrame(frame);
    }
    const RelocalizationBehavior::Output output =
        lost_->Step({.now = tracker_.now,
                     .drives_straight = drives_straight_,
                     .can_turn = can_turn_,
                     .free_ahead_m = free_ahead_m_});
    // What the collision stop lets through.
    core::VelocityCommand moves = output.wanted;
    const double yaw_rad = tracker_.odom_from_base.yaw_rad;
    const bool is_blocked =
        !can_turn_ && (yaw_rad + kStep_s * moves.yaw_rate_radps > swings_rad_ ||
                       yaw_rad + kStep_s * moves.yaw_rate_radps < 0);
    if (is_blocked) moves.yaw_rate_radps = 0;
    tracker_.Move(kStep_s, moves);
    for (RelocalizationNote& note : lost_->TakeNotes()) {
      notes_ += note.kind + ": " + note.text + "\n";
    }
    return output.state;
  }
  // Until found or help is needed.
  RelocalizationState Run(double at_most_s) {
    for (int i = 0; i < at_most_s / kStep_s; ++i) {
      const RelocalizationState state = Step();
      if (state == RelocalizationState::kFound ||
          state == RelocalizationState::kNeedHelp) {
        return state;
      }
    }
    return lost_->state();
  }
  double Error_m() const {
    return geometry::Norm(tracker_.believed->map_from_base.translation -
                          tracker_.truth.translation);
  }

  core::RobotModel robot_;
  std::shared_ptr<const traversability::NavigationMap> map_ =
      std::make_shared<const traversability::NavigationMap>(
          *traversability::NavigationMap::Make(TwoRooms()));
  ScriptedTracker tracker_;
  FakeServer server_{tracker_};
  RelocalizationBehaviorOptions options_;
  std::unique_ptr<RelocalizationBehavior> lost_;
  std::string notes_;
  bool has_camera_ = true;
  bool can_turn_ = true;
  // Of a robot that cannot turn all the way: from 0 to this.
  double swings_rad_ = 0;
  bool drives_straight_ = false;
  double free_ahead_m_ = 2;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_TESTING_RELOCALIZATION_BEHAVIOR_H_
