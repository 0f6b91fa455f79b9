#include <algorithm>

#include "absl/strings/match.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_relocalization_behavior.h"

namespace treeline::behavior {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST_F(RelocalizationBehaviorTest, WithADeadServerTheLaserFindsThePlace) {
  server_.answers = {[] { return absl::UnavailableError("dead"); }};
  tracker_.finds = tracker_.truth;
  BeLost();
  EXPECT_EQ(Run(100), RelocalizationState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_EQ(tracker_.spread, 1);
  EXPECT_THAT(notes_, HasSubstr("the server does not answer"));
}

TEST_F(RelocalizationBehaviorTest, WithASlowServerItDoesNotWaitForEver) {
  server_.delay_s = 100;
  tracker_.finds = tracker_.truth;
  BeLost();
  EXPECT_EQ(Run(100), RelocalizationState::kFound) << notes_;
  EXPECT_THAT(notes_, HasSubstr("DEADLINE_EXCEEDED"));
}

TEST_F(RelocalizationBehaviorTest, TheLaserLooksWhileASlowServerIsAsked) {
  server_.delay_s = 100;
  tracker_.laser_knows = true;
  BeLost();
  EXPECT_EQ(Run(100), RelocalizationState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_THAT(notes_, HasSubstr("takes its time"));
  EXPECT_THAT(notes_, HasSubstr("found after 6."));
  // Particles were not spread: it was seen at once where it is.
  EXPECT_EQ(tracker_.spread, 0);
}

TEST_F(RelocalizationBehaviorTest, ALateAnswerIsTakenWhileTheLaserLooks) {
  server_.delay_s = 2.5;
  tracker_.laser_knows = true;
  BeLost();
  while (server_.asked == 0) Step();
  // Of where it was asked; it turns meanwhile.
  const core::RelocalizationAnswer then = Truth(0.97);
  server_.answers = {[then] { return then; }};
  EXPECT_EQ(Run(100), RelocalizationState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_THAT(notes_, HasSubstr("seen once, and scans fit nowhere else"));
  EXPECT_EQ(server_.asked, 1);
}

TEST_F(RelocalizationBehaviorTest, WhatTheLaserSaysMustHoldLikeAllElse) {
  // It says so of one scan, and those after it do not fit there.
  tracker_.laser_knows = true;
  tracker_.laser_says = geometry::Rigid2{{9, 3}, 0.5};
  core::RelocalizationAnswer none;
  none.reason = "TOO_FEW_INLIERS";
  const auto nothing = [none] { return none; };
  server_.answers = {nothing, nothing, nothing, [this] { return Truth(0.97); }};
  BeLost();
  EXPECT_EQ(Run(100), RelocalizationState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_THAT(notes_, HasSubstr("tries what the laser says"));
  EXPECT_THAT(notes_, HasSubstr("what the laser said does not hold"));
}

TEST_F(RelocalizationBehaviorTest, WhereRoomsAreAlikeTheLaserAloneSaysNothing) {
  tracker_.laser_knows = true;
  tracker_.alias = geometry::Rigid2{{9, 3}, 0.5};
  core::RelocalizationAnswer none;
  none.reason = "TOO_FEW_INLIERS";
  server_.answers = {[none] { return none; }};
  options_.max_questions = 3;
  options_.max_search_s = 10;
  Make();
  BeLost();
  EXPECT_EQ(Run(100), RelocalizationState::kNeedHelp) << notes_;
  EXPECT_THAT(notes_, Not(HasSubstr("tries what the laser says")));
}

TEST_F(RelocalizationBehaviorTest,
       AWeakFixWhereTheLaserSaysSoNeedsNoSecondView) {
  server_.answers = {[this] { return Truth(0.6); }};
  tracker_.laser_knows = true;
  BeLost();
  EXPECT_EQ(Run(40), RelocalizationState::kFound) << notes_;
  EXPECT_EQ(server_.asked, 1);
  EXPECT_LT(Error_m(), 0.2);
}

TEST_F(RelocalizationBehaviorTest, AWeakFixIsTakenWhenTheLaserSaysSoLater) {
  core::RelocalizationAnswer none;
  none.reason = "TOO_FEW_INLIERS";
  server_.answers = {[this] {
                       tracker_.laser_knows = true;
                       return Truth(0.6);
                     },
                     [none] { return none; }};
  BeLost();
  EXPECT_EQ(Run(40), RelocalizationState::kFound) << notes_;
  EXPECT_EQ(server_.asked, 2);
  EXPECT_THAT(notes_, HasSubstr("scans fit where it was seen"));
  EXPECT_LT(Error_m(), 0.2);
}

TEST_F(RelocalizationBehaviorTest, AfterTheLaserErredTheCameraGetsViewsAnew) {
  // What the server refused while the laser's place was tried does not count.
  tracker_.laser_knows = true;
  tracker_.laser_says = geometry::Rigid2{{9, 3}, 0.5};
  core::RelocalizationAnswer none;
  none.reason = "TOO_FEW_INLIERS";
  int asked_at_turn = -1;
  server_.answers = {[none] { return none; }};
  BeLost();
  for (int i = 0; i < 100 / kStep_s && tracker_.spread == 0; ++i) {
    Step();
    if (asked_at_turn < 0 &&
        absl::StrContains(notes_, "what the laser said does not hold")) {
      asked_at_turn = server_.asked;
    }
  }
  ASSERT_GE(asked_at_turn, 2) << notes_;
  EXPECT_GE(server_.asked, asked_at_turn + 4) << notes_;
}

TEST_F(RelocalizationBehaviorTest, ViewsThatTheServerDoesNotKnowAreLeftAlone) {
  core::RelocalizationAnswer none;
  none.reason = "TOO_FEW_INLIERS";
  server_.answers = {[none] { return none; }};
  tracker_.finds = tracker_.truth;
  BeLost();
  while (tracker_.spread == 0 && tracker_.now < At(160)) Step();
  EXPECT_EQ(server_.asked, 4);
  EXPECT_THAT(notes_, HasSubstr("the server knows none of these views"));
  // Asked on, now and then, while the laser looks.
  EXPECT_EQ(Run(60), RelocalizationState::kFound) << notes_;
  EXPECT_GT(server_.asked, 4);
  EXPECT_LT(Error_m(), 0.2);
}

class DoubtTest : public RelocalizationBehaviorTest {
 protected:
  // Four answers say nothing, the fifth, of the search by laser, is weak; the
  // laser's share of where the robot is by then.
  void SearchWithAWeakFix(double share) {
    core::RelocalizationAnswer none;
    none.reason = "TOO_FEW_INLIERS";
    server_.answers.assign(4, [none] { return none; });
    server_.answers.push_back([this, share] {
      tracker_.believed =
          core::LevelPose{.map_from_base = tracker_.truth, .place = {}};
      tracker_.searches = false;
      tracker_.is_in_doubt = true;
      tracker_.place_share = share;
      return Truth(0.4);
    });
    server_.answers.push_back([none] { return none; });
    // Rooms are alike in every single scan.
    tracker_.alias = geometry::Rigid2{{9, 3}, 0.5};
    BeLost();
    Run(30);
  }
};

TEST_F(DoubtTest, AWeakFixWhereScansOfAllViewpointsAreSureIsEnough) {
  SearchWithAWeakFix(0.995);
  EXPECT_EQ(lost_->state(), RelocalizationState::kFound) << notes_;
  EXPECT_THAT(notes_, HasSubstr("scans of all viewpoints say the same"));
  EXPECT_LT(Error_m(), 0.2);
}

TEST_F(DoubtTest, AWeakFixWhereTheyAreNotSureIsNot) {
  SearchWithAWeakFix(0.9);
  EXPECT_NE(lost_->state(), RelocalizationState::kFound) << notes_;
  EXPECT_THAT(notes_, Not(HasSubstr("say the same")));
}

TEST_F(RelocalizationBehaviorTest, ASecondSecondLookIsTheLasers) {
  // Weak views of one and the same thing that agree, of rooms that are alike.
  server_.answers = {[this] { return Truth(0.4); }};
  tracker_.alias = geometry::Rigid2{{9, 3}, 0.5};
  tracker_.finds = tracker_.truth;
  BeLost();
  Run(15);
  EXPECT_THAT(notes_, HasSubstr("looks a second time"));
  EXPECT_THAT(notes_, HasSubstr("goes on by laser"));
}

TEST_F(RelocalizationBehaviorTest,
       AServerThatKnowsAnotherPlaceIsAskedThreeTimes) {
  server_.answers = {[this] { return AnswerAt(Lift({{10, 4}, 1}, 0), 0.999); }};
  tracker_.finds = tracker_.truth;
  BeLost();
  EXPECT_EQ(Run(100), RelocalizationState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_EQ(server_.asked, 3);
  EXPECT_THAT(notes_, HasSubstr("does not fit here"));
}

TEST_F(RelocalizationBehaviorTest, AServerThatIsWrongAndSaysSoIsAskedOn) {
  server_.answers.assign(4, [this] {
    return AnswerAt(Lift({{10, 4}, 1}, 0), 0.5);
  });
  server_.answers.push_back([this] { return Truth(0.97); });
  BeLost();
  EXPECT_EQ(Run(40), RelocalizationState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_EQ(server_.asked, 5);
}

TEST_F(RelocalizationBehaviorTest, WhoNeedsHelpAsksAServerThatHasComeBack) {
  server_.answers = {[] { return absl::UnavailableError("dead"); }};
  options_.max_search_s = 5;
  Make();
  BeLost();
  EXPECT_EQ(Run(100), RelocalizationState::kNeedHelp) << notes_;
  const int asked = server_.asked;
  const geometry::Rigid2 stood = tracker_.odom_from_base;
  for (int i = 0; i < 65 / kStep_s; ++i) {
    EXPECT_EQ(Step(), RelocalizationState::kNeedHelp);
  }
  EXPECT_EQ(server_.asked, asked + 3);
  EXPECT_EQ(tracker_.odom_from_base, stood);
  // Another place is not believed now either.
  server_.answers = {[this] { return AnswerAt(Lift({{10, 4}, 1}, 0), 0.999); }};
  for (int i = 0; i < 20 / kStep_s; ++i) {
    EXPECT_EQ(Step(), RelocalizationState::kNeedHelp);
  }
  server_.answers = {[this] { return Truth(0.97); }};
  for (int i = 0; i < 30 / kStep_s; ++i) {
    if (Step() == RelocalizationState::kFound) break;
  }
  EXPECT_EQ(lost_->state(), RelocalizationState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
}

TEST_F(RelocalizationBehaviorTest, WhoNeedsHelpListensToAPerson) {
  server_.answers = {[] { return absl::UnavailableError("dead"); }};
  options_.max_search_s = 5;
  Make();
  BeLost();
  EXPECT_EQ(Run(100), RelocalizationState::kNeedHelp) << notes_;
  // Also while it asks.
  server_.delay_s = 2;
  const int asked = server_.asked;
  while (server_.asked == asked) Step();
  tracker_.lost_verdict = {};
  lost_->NotePoseWasSet(tracker_.now);
  server_.answers = {[this] { return AnswerAt(Lift({{10, 4}, 1}, 0), 0.999); }};
  EXPECT_EQ(Run(40), RelocalizationState::kIdle) << notes_;
  EXPECT_EQ(tracker_.told, 0);
  EXPECT_EQ(server_.asked, asked + 1);
}

TEST_F(RelocalizationBehaviorTest, PicturesAreWantedForQuestionsAndChecksOnly) {
  EXPECT_FALSE(lost_->WantsPictures(tracker_.now));
  Run(1);
  EXPECT_FALSE(lost_->WantsPictures(tracker_.now));
  Run(options_.check_interval_s);
  EXPECT_TRUE(lost_->WantsPictures(tracker_.now));
  BeLost();
  has_camera_ = false;
  for (int i = 0; i < 100 && lost_->state() != RelocalizationState::kLooking;
       ++i) {
    EXPECT_FALSE(Step() != RelocalizationState::kLooking &&
                 lost_->WantsPictures(tracker_.now));
  }
  EXPECT_TRUE(lost_->WantsPictures(tracker_.now));
  EXPECT_EQ(lost_->state(), RelocalizationState::kLooking);
}

TEST_F(RelocalizationBehaviorTest, AnUnknownSceneIsAskedForOnce) {
  server_.answers = {[] { return absl::NotFoundError("no scene 'x'"); }};
  tracker_.finds = tracker_.truth;
  BeLost();
  EXPECT_EQ(Run(100), RelocalizationState::kFound) << notes_;
  EXPECT_EQ(server_.asked, 1);
}

TEST_F(RelocalizationBehaviorTest, WithoutAServerTheLaserLooksOverTheMap) {
  lost_ = *RelocalizationBehavior::Create(map_, robot_, tracker_, nullptr,
                                          options_);
  tracker_.laser_knows = true;
  BeLost();
  EXPECT_EQ(Run(20), RelocalizationState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_THAT(notes_, HasSubstr("and nowhere else: turns"));
}

TEST_F(RelocalizationBehaviorTest, WithoutPicturesItSearchesByLaser) {
  has_camera_ = false;
  tracker_.finds = tracker_.truth;
  BeLost();
  EXPECT_EQ(Run(100), RelocalizationState::kFound) << notes_;
  EXPECT_THAT(notes_, HasSubstr("the camera gives no pictures"));
  EXPECT_EQ(server_.asked, 0);
}

TEST_F(RelocalizationBehaviorTest, TheSearchDoesNotBelieveAPlaceThatHasATwin) {
  options_.method = RelocalizationMethod::kAmclOnly;
  Make();
  tracker_.alias = geometry::Rigid2{{9, 3}, 0.5};
  tracker_.finds = *tracker_.alias;
  BeLost();
  EXPECT_EQ(Run(250), RelocalizationState::kNeedHelp) << notes_;
  EXPECT_THAT(notes_, HasSubstr("the laser fits another place as well"));
  EXPECT_EQ(server_.asked, 0);
}

TEST_F(RelocalizationBehaviorTest, TheSearchEndsInTimeIfItFindsAWrongPlace) {
  options_.method = RelocalizationMethod::kAmclOnly;
  options_.max_search_s = 60;
  Make();
  tracker_.finds = geometry::Rigid2{{10, 4}, 1};
  BeLost();
  EXPECT_EQ(Run(62), RelocalizationState::kNeedHelp) << notes_;
  // What particles gathered at was wrong: they were spread again.
  EXPECT_GE(tracker_.spread, 2);
}

TEST_F(RelocalizationBehaviorTest, InjectionOnlySpreadsNothing) {
  options_.method = RelocalizationMethod::kInjectionOnly;
  options_.max_search_s = 30;
  Make();
  BeLost();
  EXPECT_EQ(Run(60), RelocalizationState::kNeedHelp) << notes_;
  EXPECT_EQ(tracker_.spread, 0);
  EXPECT_EQ(tracker_.told, 0);
}

TEST_F(RelocalizationBehaviorTest, TheSearchPausesForPictures) {
  core::RelocalizationAnswer none;
  server_.answers = {[none] { return none; }};
  BeLost();
  while (Step() != RelocalizationState::kSearching) {
  }
  const int asked = server_.asked;
  EXPECT_EQ(Run(20), RelocalizationState::kSearching) << notes_;
  EXPECT_EQ(server_.asked, asked + 4) << notes_;
  server_.answers = {[this] { return Truth(0.97); }};
  EXPECT_EQ(Run(10), RelocalizationState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
}

TEST_F(RelocalizationBehaviorTest, WhatHeldItOnceItDoesNotTurnAgainst) {
  // The laser sees room, and something holds it at both ends all the same.
  swings_rad_ = 1.2;
  can_turn_ = false;
  free_ahead_m_ = 0;
  core::RelocalizationAnswer none;
  server_.answers = {[none] { return none; }};
  BeLost();
  while (Step() != RelocalizationState::kSearching) {
  }
  int held = 0;
  bool was_held = false;
  for (int i = 0; i < 40 / kStep_s; ++i) {
    const double before_rad = tracker_.odom_from_base.yaw_rad;
    Step();
    const bool is_held = before_rad == tracker_.odom_from_base.yaw_rad &&
                         (before_rad < 0.05 || before_rad > 1.15);
    held += is_held && !was_held ? 1 : 0;
    was_held = is_held;
  }
  EXPECT_LE(held, 3) << notes_;
}

TEST_F(RelocalizationBehaviorTest, WithoutRoomToTurnItLooksTwice) {
  can_turn_ = false;
  free_ahead_m_ = 0;
  BeLost();
  EXPECT_EQ(Run(20), RelocalizationState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_EQ(server_.asked, 2);
  EXPECT_EQ(tracker_.odom_from_base, geometry::Rigid2());
  EXPECT_THAT(notes_, HasSubstr("there is no room to turn"));
}

TEST_F(RelocalizationBehaviorTest, WhereItCannotTurnItGoesAheadAndNeverBack) {
  can_turn_ = false;
  free_ahead_m_ = 1;
  core::RelocalizationAnswer none;
  server_.answers = {[none] { return none; }};
  BeLost();
  double min_distance_m = 0;
  for (int i = 0; i < 30 / kStep_s; ++i) {
    Step();
    min_distance_m =
        std::min(min_distance_m, tracker_.odom_from_base.translation.x);
  }
  EXPECT_EQ(min_distance_m, 0);
  EXPECT_GT(tracker_.odom_from_base.translation.x, 0.2);
}

TEST_F(RelocalizationBehaviorTest, ARobotThatCannotTurnEndsInTime) {
  can_turn_ = false;
  free_ahead_m_ = 0;
  core::RelocalizationAnswer none;
  server_.answers = {[none] { return none; }};
  BeLost();
  EXPECT_EQ(Run(250), RelocalizationState::kNeedHelp) << notes_;
  EXPECT_EQ(tracker_.odom_from_base, geometry::Rigid2());
}

TEST_F(RelocalizationBehaviorTest,
       WithoutRoomForAFullTurnItSwingsThereAndBack) {
  can_turn_ = false;
  swings_rad_ = 1.2;
  free_ahead_m_ = 0;
  tracker_.laser_knows = true;
  core::RelocalizationAnswer none;
  server_.answers = {[none] { return none; }};
  BeLost();
  EXPECT_EQ(Run(20), RelocalizationState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_THAT(notes_, HasSubstr("by laser alone"));
}

}  // namespace
}  // namespace treeline::behavior
