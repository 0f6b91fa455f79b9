#include "nav_agent/behavior/relocalization_behavior.h"

#include <cmath>
#include <limits>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_relocalization_behavior.h"

namespace treeline::behavior {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST_F(RelocalizationBehaviorTest, StaysIdleWhileLocalized) {
  EXPECT_EQ(Run(5), RelocalizationState::kIdle);
  EXPECT_EQ(server_.asked, 0);
}

TEST_F(RelocalizationBehaviorTest, AsksStandingAndGoesOnWhenScansFit) {
  BeLost();
  EXPECT_EQ(Run(20), RelocalizationState::kFound) << notes_;
  EXPECT_EQ(server_.asked, 1);
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_EQ(Step(), RelocalizationState::kIdle);
  EXPECT_THAT(notes_, HasSubstr("seen once, and scans fit nowhere else"));
}

TEST_F(RelocalizationBehaviorTest, StopsBeforeItLooks) {
  BeLost();
  tracker_.moves = {.forward_mps = 0.5, .yaw_rate_radps = 0};
  EXPECT_EQ(Step(), RelocalizationState::kStopping);
  // The first frame that is asked about is of 0.3 s after it stood.
  double waited_s = 0;
  while (server_.asked == 0 && waited_s < 5) {
    Step();
    waited_s += kStep_s;
  }
  EXPECT_GE(waited_s, options_.settle_s);
  EXPECT_LT(waited_s, 1);
}

TEST_F(RelocalizationBehaviorTest, RefusesAFixThatLeansOtherwiseThanTheRobot) {
  server_.answers = {[this] {
    const geometry::Rigid3 upside_down = {
        .rotation = geometry::Rotation3::FromAxisAngle({3.1, 0, 0}),
        .translation = {2, 3, 0}};
    return AnswerAt(upside_down, 0.99);
  }};
  BeLost();
  EXPECT_EQ(Run(250), RelocalizationState::kNeedHelp) << notes_;
  EXPECT_EQ(tracker_.told, 0);
  EXPECT_THAT(notes_, HasSubstr("against gravity"));
}

TEST_F(RelocalizationBehaviorTest, TakesTheTiltOfARobotOnARampIntoAccount) {
  tracker_.tilt_rad = 0.2;
  server_.answers = {[this] {
    geometry::Rigid3 pose = Lift(tracker_.truth, 0.02);
    pose.rotation =
        pose.rotation * geometry::Rotation3::FromAxisAngle({0, 0.2, 0});
    return AnswerAt(pose, 0.97);
  }};
  BeLost();
  EXPECT_EQ(Run(20), RelocalizationState::kFound) << notes_;
}

TEST_F(RelocalizationBehaviorTest, RefusesAFixInAWallAndOneInTheAir) {
  server_.answers = {
      [this] {
        return AnswerAt(Lift({{6.5, 3}, 0}, 0), 0.99);
      },
      [this] { return AnswerAt(Lift(tracker_.truth, 0.8), 0.99); },
      [this] {
        return AnswerAt(Lift({{-50, 3}, 0}, 0), 0.99);
      }};
  options_.max_questions = 3;
  Make();
  BeLost();
  EXPECT_EQ(Run(250), RelocalizationState::kNeedHelp) << notes_;
  EXPECT_EQ(tracker_.told, 0);
  EXPECT_THAT(notes_, HasSubstr("no room for the robot at 6.50"));
  EXPECT_THAT(notes_, HasSubstr("above the ground"));
  EXPECT_THAT(notes_, HasSubstr("no room for the robot at -50"));
}

TEST_F(RelocalizationBehaviorTest,
       RefusesTheConfidentFixesOfAnotherRoomOrScene) {
  // Upright, on free ground, and not where it is.
  server_.answers = {[this] { return AnswerAt(Lift({{10, 4}, 1}, 0), 0.999); }};
  BeLost();
  EXPECT_EQ(Run(250), RelocalizationState::kNeedHelp) << notes_;
  EXPECT_EQ(tracker_.told, 0);
  EXPECT_THAT(notes_, HasSubstr("against the scan"));
}

TEST_F(RelocalizationBehaviorTest, OfRoomsThatAreAlikeItBelievesOnlyTwoViews) {
  // The laser fits in both rooms; the camera is wrong once.
  tracker_.alias = geometry::Rigid2{{9, 3}, 0.5};
  server_.answers = {
      [this] { return AnswerAt(Lift(*tracker_.alias, 0.02), 0.99); },
      [this] { return Truth(0.97); }, [this] { return Truth(0.97); }};
  BeLost();
  EXPECT_EQ(Run(60), RelocalizationState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_GE(server_.asked, 3);
  EXPECT_THAT(notes_, HasSubstr("looks a second time"));
}

TEST_F(RelocalizationBehaviorTest, WhereScansFitBetterElsewhereItIsNot) {
  // The gate lets pass what the map explains to a half.
  server_.answers.assign(3, [this] {
    return AnswerAt(Lift(tracker_.truth * geometry::Rigid2{{0.5, 0}, 0}, 0.02),
                    0.99);
  });
  server_.answers.push_back([this] { return Truth(0.97); });
  tracker_.alias = tracker_.truth;
  BeLost();
  EXPECT_EQ(Run(60), RelocalizationState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_THAT(notes_, HasSubstr("scans fit better elsewhere"));
}

TEST_F(RelocalizationBehaviorTest, TwoViewsWaitForWhatTheScanShowsElsewhere) {
  // Views agree that are sure together, and scans fit there, but not as well as
  // elsewhere, which takes longer to find out than the turn does.
  tracker_.search_steps = 300;
  tracker_.alias = tracker_.truth;
  server_.answers.assign(2, [this] {
    return AnswerAt(Lift(tracker_.truth * geometry::Rigid2{{0.42, 0}, 0}, 0.02),
                    0.95);
  });
  server_.answers.push_back([this] { return Truth(0.97); });
  BeLost();
  EXPECT_EQ(Run(60), RelocalizationState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_THAT(notes_, HasSubstr("scans fit better elsewhere"));
}

TEST_F(RelocalizationBehaviorTest, RefusesWhatIsNoNumber) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  server_.answers = {[this, nan] {
                       core::RelocalizationAnswer answer = Truth(0.97);
                       answer.map_from_camera.translation.x = nan;
                       return answer;
                     },
                     [this, nan] { return Truth(nan); },
                     [this, nan] {
                       core::RelocalizationAnswer answer = Truth(0.97);
                       answer.covariance[0] = nan;
                       return answer;
                     },
                     [this] {
                       core::RelocalizationAnswer answer = Truth(0.97);
                       answer.covariance[7] = -1;
                       return answer;
                     },
                     [this] {
                       core::RelocalizationAnswer answer = Truth(0.97);
                       answer.map_from_camera.rotation = {0, 0, 0, 0};
                       return answer;
                     }};
  options_.max_questions = 5;
  options_.max_search_s = 5;
  Make();
  BeLost();
  EXPECT_EQ(Run(250), RelocalizationState::kNeedHelp) << notes_;
  EXPECT_EQ(tracker_.told, 0);
  EXPECT_EQ(server_.asked, 5);
  EXPECT_THAT(notes_, Not(HasSubstr("sure")));
}

TEST_F(RelocalizationBehaviorTest, AWeakFixNeedsASecondViewThatAgrees) {
  server_.answers = {[this] { return Truth(0.6); }};
  BeLost();
  EXPECT_EQ(Run(40), RelocalizationState::kFound) << notes_;
  EXPECT_EQ(server_.asked, 2);
  // From another direction.
  EXPECT_GT(std::abs(server_.yaws_rad[1] - server_.yaws_rad[0]), 0.2);
  EXPECT_LT(Error_m(), 0.2);
}

TEST_F(RelocalizationBehaviorTest, BelowItsScenesThresholdTheServerIsNotSure) {
  server_.answers = {[this] {
    core::RelocalizationAnswer answer = Truth(0.95);
    answer.confidence_threshold = 0.97;
    return answer;
  }};
  BeLost();
  EXPECT_EQ(Run(40), RelocalizationState::kFound) << notes_;
  EXPECT_EQ(server_.asked, 2);
}

TEST_F(RelocalizationBehaviorTest,
       DoubtfulViewsAreNotEnoughWhereRoomsAreAlike) {
  // Camera and laser take the other room for this one, the camera with doubt.
  tracker_.alias = geometry::Rigid2{{9, 3}, 0.5};
  const auto loose_search = [this] {
    return AnswerAt(Lift(*tracker_.alias, 0.02), 0.6);
  };
  server_.answers.assign(6, loose_search);
  server_.answers.push_back([this] { return Truth(0.97); });
  BeLost();
  EXPECT_EQ(Run(100), RelocalizationState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_EQ(server_.asked, 8);
}

TEST_F(RelocalizationBehaviorTest, ViewsOfOtherThingsThatAgreeAreSureTogether) {
  tracker_.alias = geometry::Rigid2{{9, 3}, 0.5};
  server_.answers = {[this] { return Truth(0.85); }};
  BeLost();
  EXPECT_EQ(Run(60), RelocalizationState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_EQ(server_.asked, 3);
}

TEST_F(RelocalizationBehaviorTest, WeakFixesThatDisagreeAreNotTaken) {
  int number = 0;
  server_.answers = {[this, &number] {
    // A metre further each time; the gate alone would let them pass.
    tracker_.judged = 10;
    const geometry::Rigid2 pose = {{1.0 + 0.9 * ++number, 3}, 0.5 * number};
    return AnswerAt(Lift(pose, 0), 0.6);
  }};
  options_.max_questions = 4;
  options_.max_search_s = 5;
  Make();
  BeLost();
  EXPECT_EQ(Run(250), RelocalizationState::kNeedHelp) << notes_;
  EXPECT_EQ(tracker_.told, 0);
}

TEST_F(RelocalizationBehaviorTest, LooksElsewhereIfItIsNotLocalized) {
  core::RelocalizationAnswer none;
  none.reason = "TOO_FEW_INLIERS";
  server_.answers = {[none] { return none; }, [none] { return none; },
                     [this] { return Truth(0.97); }};
  BeLost();
  EXPECT_EQ(Run(60), RelocalizationState::kFound) << notes_;
  ASSERT_EQ(server_.asked, 3);
  EXPECT_GT(std::abs(geometry::NormalizedAngle_rad(server_.yaws_rad[1] -
                                                   server_.yaws_rad[0])),
            0.5);
}

TEST_F(RelocalizationBehaviorTest, AFixThatDoesNotHoldIsDropped) {
  int answers = 0;
  server_.answers = {[this, &answers] {
    core::RelocalizationAnswer answer = Truth(0.97);
    // The gate's scan fits; those after it do not.
    if (++answers == 1) return answer;
    tracker_.best_fit = 0.95;
    return answer;
  }};
  BeLost();
  while (lost_->state() != RelocalizationState::kConfirming) Step();
  tracker_.best_fit = 0.3;
  while (lost_->state() == RelocalizationState::kConfirming) Step();
  EXPECT_THAT(notes_, HasSubstr("not there: scans do not fit"));
  EXPECT_EQ(Run(60), RelocalizationState::kFound) << notes_;
  EXPECT_GE(server_.asked, 2);
}

TEST_F(RelocalizationBehaviorTest, APersonsWordEndsIt) {
  BeLost();
  Step();
  EXPECT_TRUE(lost_->IsActive());
  tracker_.lost_verdict = {};
  lost_->NotePoseWasSet(tracker_.now);
  EXPECT_EQ(lost_->state(), RelocalizationState::kIdle);
  EXPECT_EQ(Run(2), RelocalizationState::kIdle);
}

TEST_F(RelocalizationBehaviorTest, WhatAPersonSaysIsCheckedSoon) {
  drives_straight_ = true;
  lost_->NotePoseWasSet(tracker_.now);
  Run(1.9);
  EXPECT_EQ(server_.asked, 0);
  EXPECT_EQ(Run(20), RelocalizationState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_THAT(notes_, HasSubstr("the server sees the robot"));
}

TEST_F(RelocalizationBehaviorTest, AStartWithoutAPlaceAsks) {
  tracker_.believed.reset();
  lost_->Begin(RelocalizationCause::kStart, tracker_.now);
  EXPECT_EQ(Run(20), RelocalizationState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
}

TEST_F(RelocalizationBehaviorTest, TheCheckAsksNowAndThenAndIsContent) {
  tracker_.believed =
      core::LevelPose{.map_from_base = tracker_.truth, .place = {}};
  drives_straight_ = true;
  EXPECT_EQ(Run(45), RelocalizationState::kIdle);
  EXPECT_EQ(server_.asked, 2);
  EXPECT_EQ(tracker_.told, 0);
  EXPECT_EQ(notes_, "");
}

TEST_F(RelocalizationBehaviorTest, TheCheckCorrectsADrift) {
  geometry::Rigid2 drifted = tracker_.truth;
  drifted.translation.x += 0.4;
  tracker_.believed = core::LevelPose{.map_from_base = drifted, .place = {}};
  drives_straight_ = true;
  EXPECT_EQ(Run(25), RelocalizationState::kIdle);
  EXPECT_EQ(tracker_.told, 1);
  EXPECT_LT(Error_m(), 0.1);
  EXPECT_THAT(notes_, HasSubstr("corrected"));
}

TEST_F(RelocalizationBehaviorTest,
       TheCheckStopsARobotThatIsElsewhereAndLooksTwice) {
  drives_straight_ = true;
  EXPECT_EQ(Run(60), RelocalizationState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_EQ(server_.asked, 3);
  EXPECT_THAT(notes_, HasSubstr("looks again"));
  EXPECT_THAT(notes_, HasSubstr("two views agree"));
}

TEST_F(RelocalizationBehaviorTest, TheCheckDoesNotMoveARobotThatIsRight) {
  tracker_.believed =
      core::LevelPose{.map_from_base = tracker_.truth, .place = {}};
  server_.answers = {[this] { return AnswerAt(Lift({{10, 4}, 1}, 0), 0.999); }};
  drives_straight_ = true;
  EXPECT_EQ(Run(45), RelocalizationState::kIdle) << notes_;
  EXPECT_EQ(tracker_.told, 0);
  EXPECT_LT(Error_m(), 1e-6);
}

TEST(RelocalizationBehaviorOptionsTest, NamesWhatIsOutOfRange) {
  RelocalizationBehaviorOptions options;
  EXPECT_TRUE(options.Validate().ok());
  options.deadline_s = 0;
  EXPECT_THAT(std::string(options.Validate().message()),
              HasSubstr("deadline_s"));
  options = {};
  options.gate.sure_confidence = 0.1;
  EXPECT_THAT(std::string(options.Validate().message()),
              HasSubstr("sure_confidence"));
}

}  // namespace
}  // namespace treeline::behavior
