#include "nav_agent/behavior/lost_and_found.h"

#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_recovery.h"

namespace treeline {
namespace {

using testing::Contains;
using testing::Field;
using testing::HasSubstr;
using testing::Not;

class LostAndFoundTest : public testing::Test {
 protected:
  LostAndFoundTest() {
    tracker_.now = At(100);
    tracker_.believed = LevelPose{.map_from_base = {{10, 1}, 2}, .place = {}};
    server_.answers = {[this] { return Truth(0.97); }};
    Make();
  }
  void Make() {
    lost_ = *LostAndFound::Create(map_, robot_, tracker_, &server_, options_);
  }

  RelocalizationAnswer AnswerAt(const Rigid3& map_from_base,
                                double confidence) const {
    RelocalizationAnswer answer;
    answer.localized = true;
    answer.confidence = confidence;
    answer.map_from_camera = map_from_base * robot_.base_from_camera;
    for (size_t i = 0; i < 36; i += 7) answer.covariance[i] = 1e-4;
    return answer;
  }
  RelocalizationAnswer Truth(double confidence) const {
    return AnswerAt(Lift(tracker_.truth, 0.02), confidence);
  }
  void BeLost() {
    tracker_.lost_verdict.state = LostState::kLost;
    tracker_.lost_verdict.probability = 0.99;
  }
  RecoveryState Step() {
    tracker_.now += std::chrono::milliseconds(25);
    if (has_camera_) {
      RgbdFrame frame;
      frame.stamp = tracker_.now;
      lost_->AddFrame(frame);
    }
    const LostAndFound::Output output =
        lost_->Step({.now = tracker_.now,
                     .drives_straight = drives_straight_,
                     .can_turn = can_turn_,
                     .free_ahead_m = free_ahead_m_,
                     .free_behind_m = 0});
    // What the collision stop lets through.
    VelocityCommand moves = output.wanted;
    const double yaw_rad = tracker_.odom_from_base.yaw_rad;
    const bool is_blocked =
        !can_turn_ && (yaw_rad + kStep_s * moves.yaw_rate_radps > swings_rad_ ||
                       yaw_rad + kStep_s * moves.yaw_rate_radps < 0);
    if (is_blocked) moves.yaw_rate_radps = 0;
    tracker_.Move(kStep_s, moves);
    for (RecoveryNote& note : lost_->TakeNotes()) {
      notes_ += note.kind + ": " + note.text + "\n";
    }
    return output.state;
  }
  // Until found or help is needed.
  RecoveryState Run(double at_most_s) {
    for (int i = 0; i < at_most_s / kStep_s; ++i) {
      const RecoveryState state = Step();
      if (state == RecoveryState::kFound || state == RecoveryState::kNeedHelp) {
        return state;
      }
    }
    return lost_->state();
  }
  double Error_m() const {
    return Norm(tracker_.believed->map_from_base.translation -
                tracker_.truth.translation);
  }

  RobotModel robot_;
  std::shared_ptr<const NavigationMap> map_ =
      std::make_shared<const NavigationMap>(*NavigationMap::Make(TwoRooms()));
  FakeTracker tracker_;
  FakeServer server_{tracker_};
  LostAndFoundOptions options_;
  std::unique_ptr<LostAndFound> lost_;
  std::string notes_;
  bool has_camera_ = true;
  bool can_turn_ = true;
  // Of a robot that cannot turn all the way: from 0 to this.
  double swings_rad_ = 0;
  bool drives_straight_ = false;
  double free_ahead_m_ = 2;
};

TEST_F(LostAndFoundTest, StaysIdleWhileLocalized) {
  EXPECT_EQ(Run(5), RecoveryState::kIdle);
  EXPECT_EQ(server_.asked, 0);
}

TEST_F(LostAndFoundTest, AsksStandingAndGoesOnWhenScansFit) {
  BeLost();
  EXPECT_EQ(Run(20), RecoveryState::kFound) << notes_;
  EXPECT_EQ(server_.asked, 1);
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_EQ(Step(), RecoveryState::kIdle);
  EXPECT_THAT(notes_, HasSubstr("seen once, and scans fit nowhere else"));
}

TEST_F(LostAndFoundTest, StopsBeforeItLooks) {
  BeLost();
  tracker_.moves = {.forward_mps = 0.5, .yaw_rate_radps = 0};
  EXPECT_EQ(Step(), RecoveryState::kStopping);
  // The first frame that is asked about is of 0.3 s after it stood.
  double waited_s = 0;
  while (server_.asked == 0 && waited_s < 5) {
    Step();
    waited_s += kStep_s;
  }
  EXPECT_GE(waited_s, options_.settle_s);
  EXPECT_LT(waited_s, 1);
}

TEST_F(LostAndFoundTest, RefusesAFixThatLeansOtherwiseThanTheRobot) {
  server_.answers = {[this] {
    const Rigid3 upside_down = {
        .rotation = Rotation3::FromAxisAngle({3.1, 0, 0}),
        .translation = {2, 3, 0}};
    return AnswerAt(upside_down, 0.99);
  }};
  BeLost();
  EXPECT_EQ(Run(250), RecoveryState::kNeedHelp) << notes_;
  EXPECT_EQ(tracker_.told, 0);
  EXPECT_THAT(notes_, HasSubstr("against gravity"));
}

TEST_F(LostAndFoundTest, TakesTheTiltOfARobotOnARampIntoAccount) {
  tracker_.tilt_rad = 0.2;
  server_.answers = {[this] {
    Rigid3 pose = Lift(tracker_.truth, 0.02);
    pose.rotation = pose.rotation * Rotation3::FromAxisAngle({0, 0.2, 0});
    return AnswerAt(pose, 0.97);
  }};
  BeLost();
  EXPECT_EQ(Run(20), RecoveryState::kFound) << notes_;
}

TEST_F(LostAndFoundTest, RefusesAFixInAWallAndOneInTheAir) {
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
  EXPECT_EQ(Run(250), RecoveryState::kNeedHelp) << notes_;
  EXPECT_EQ(tracker_.told, 0);
  EXPECT_THAT(notes_, HasSubstr("no room for the robot at 6.50"));
  EXPECT_THAT(notes_, HasSubstr("above the ground"));
  EXPECT_THAT(notes_, HasSubstr("no room for the robot at -50"));
}

TEST_F(LostAndFoundTest, RefusesTheConfidentFixesOfAnotherRoomOrScene) {
  // Upright, on free ground, and not where it is.
  server_.answers = {[this] { return AnswerAt(Lift({{10, 4}, 1}, 0), 0.999); }};
  BeLost();
  EXPECT_EQ(Run(250), RecoveryState::kNeedHelp) << notes_;
  EXPECT_EQ(tracker_.told, 0);
  EXPECT_THAT(notes_, HasSubstr("against the scan"));
}

TEST_F(LostAndFoundTest, OfRoomsThatAreAlikeItBelievesOnlyTwoViews) {
  // The laser fits in both rooms; the camera is wrong once.
  tracker_.alias = Rigid2{{9, 3}, 0.5};
  server_.answers = {
      [this] { return AnswerAt(Lift(*tracker_.alias, 0.02), 0.99); },
      [this] { return Truth(0.97); }, [this] { return Truth(0.97); }};
  BeLost();
  EXPECT_EQ(Run(60), RecoveryState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_GE(server_.asked, 3);
  EXPECT_THAT(notes_, HasSubstr("looks a second time"));
}

TEST_F(LostAndFoundTest, RefusesWhatIsNoNumber) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  server_.answers = {[this, nan] {
                       RelocalizationAnswer answer = Truth(0.97);
                       answer.map_from_camera.translation.x = nan;
                       return answer;
                     },
                     [this, nan] { return Truth(nan); },
                     [this, nan] {
                       RelocalizationAnswer answer = Truth(0.97);
                       answer.covariance[0] = nan;
                       return answer;
                     },
                     [this] {
                       RelocalizationAnswer answer = Truth(0.97);
                       answer.covariance[7] = -1;
                       return answer;
                     },
                     [this] {
                       RelocalizationAnswer answer = Truth(0.97);
                       answer.map_from_camera.rotation = {0, 0, 0, 0};
                       return answer;
                     }};
  options_.max_questions = 5;
  options_.most_search_s = 5;
  Make();
  BeLost();
  EXPECT_EQ(Run(250), RecoveryState::kNeedHelp) << notes_;
  EXPECT_EQ(tracker_.told, 0);
  EXPECT_EQ(server_.asked, 5);
  EXPECT_THAT(notes_, Not(HasSubstr("sure")));
}

TEST_F(LostAndFoundTest, AWeakFixNeedsASecondViewThatAgrees) {
  server_.answers = {[this] { return Truth(0.6); }};
  BeLost();
  EXPECT_EQ(Run(40), RecoveryState::kFound) << notes_;
  EXPECT_EQ(server_.asked, 2);
  // From another direction.
  EXPECT_GT(std::abs(server_.yaws_rad[1] - server_.yaws_rad[0]), 0.2);
  EXPECT_LT(Error_m(), 0.2);
}

TEST_F(LostAndFoundTest, WeakFixesThatDisagreeAreNotTaken) {
  int number = 0;
  server_.answers = {[this, &number] {
    // A metre further each time; the gate alone would let them pass.
    tracker_.judged = 10;
    const Rigid2 pose = {{1.0 + 0.9 * ++number, 3}, 0.5 * number};
    return AnswerAt(Lift(pose, 0), 0.6);
  }};
  options_.max_questions = 4;
  options_.most_search_s = 5;
  Make();
  BeLost();
  EXPECT_EQ(Run(250), RecoveryState::kNeedHelp) << notes_;
  EXPECT_EQ(tracker_.told, 0);
}

TEST_F(LostAndFoundTest, LooksElsewhereIfItIsNotLocalized) {
  RelocalizationAnswer none;
  none.reason = "TOO_FEW_INLIERS";
  server_.answers = {[none] { return none; }, [none] { return none; },
                     [this] { return Truth(0.97); }};
  BeLost();
  EXPECT_EQ(Run(60), RecoveryState::kFound) << notes_;
  ASSERT_EQ(server_.asked, 3);
  EXPECT_GT(
      std::abs(NormalizedAngle_rad(server_.yaws_rad[1] - server_.yaws_rad[0])),
      0.5);
}

TEST_F(LostAndFoundTest, AFixThatDoesNotHoldIsDropped) {
  int answers = 0;
  server_.answers = {[this, &answers] {
    RelocalizationAnswer answer = Truth(0.97);
    // The gate's scan fits; those after it do not.
    if (++answers == 1) return answer;
    tracker_.best_fit = 0.95;
    return answer;
  }};
  BeLost();
  while (lost_->state() != RecoveryState::kConfirming) Step();
  tracker_.best_fit = 0.3;
  while (lost_->state() == RecoveryState::kConfirming) Step();
  EXPECT_THAT(notes_, HasSubstr("not there: scans do not fit"));
  EXPECT_EQ(Run(60), RecoveryState::kFound) << notes_;
  EXPECT_GE(server_.asked, 2);
}

TEST_F(LostAndFoundTest, WithADeadServerTheLaserFindsThePlace) {
  server_.answers = {[] { return absl::UnavailableError("dead"); }};
  tracker_.finds = tracker_.truth;
  BeLost();
  EXPECT_EQ(Run(100), RecoveryState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_EQ(tracker_.spread, 1);
  EXPECT_THAT(notes_, HasSubstr("the server does not answer"));
}

TEST_F(LostAndFoundTest, WithASlowServerItDoesNotWaitForEver) {
  server_.delay_s = 100;
  tracker_.finds = tracker_.truth;
  BeLost();
  EXPECT_EQ(Run(100), RecoveryState::kFound) << notes_;
  EXPECT_THAT(notes_, HasSubstr("DEADLINE_EXCEEDED"));
}

TEST_F(LostAndFoundTest, TheLaserLooksWhileASlowServerIsAsked) {
  server_.delay_s = 100;
  tracker_.laser_knows = true;
  BeLost();
  EXPECT_EQ(Run(100), RecoveryState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_THAT(notes_, HasSubstr("takes its time"));
  EXPECT_THAT(notes_, HasSubstr("found after 8."));
  // Particles were not spread: it was seen at once where it is.
  EXPECT_EQ(tracker_.spread, 0);
}

TEST_F(LostAndFoundTest, ALateAnswerIsTakenWhileTheLaserLooks) {
  server_.delay_s = 2.5;
  tracker_.laser_knows = true;
  BeLost();
  while (server_.asked == 0) Step();
  // Of where it was asked; it turns meanwhile.
  const RelocalizationAnswer then = Truth(0.97);
  server_.answers = {[then] { return then; }};
  EXPECT_EQ(Run(100), RecoveryState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_THAT(notes_, HasSubstr("seen once, and scans fit nowhere else"));
  EXPECT_EQ(server_.asked, 1);
}

TEST_F(LostAndFoundTest, WhatTheLaserSaysMustHoldLikeAllElse) {
  // It says so of one scan, and those after it do not fit there.
  tracker_.laser_knows = true;
  tracker_.laser_says = Rigid2{{9, 3}, 0.5};
  RelocalizationAnswer none;
  none.reason = "TOO_FEW_INLIERS";
  server_.answers = {[none] { return none; }, [this] { return Truth(0.97); }};
  BeLost();
  EXPECT_EQ(Run(100), RecoveryState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_THAT(notes_, HasSubstr("tries what the laser says"));
  EXPECT_THAT(notes_, HasSubstr("what the laser said does not hold"));
}

TEST_F(LostAndFoundTest, WhereRoomsAreAlikeTheLaserAloneSaysNothing) {
  tracker_.laser_knows = true;
  tracker_.alias = Rigid2{{9, 3}, 0.5};
  RelocalizationAnswer none;
  none.reason = "TOO_FEW_INLIERS";
  server_.answers = {[none] { return none; }};
  options_.max_questions = 3;
  options_.most_search_s = 10;
  Make();
  BeLost();
  EXPECT_EQ(Run(100), RecoveryState::kNeedHelp) << notes_;
  EXPECT_THAT(notes_, Not(HasSubstr("tries what the laser says")));
}

TEST_F(LostAndFoundTest, AWeakFixWhereTheLaserSaysSoNeedsNoSecondView) {
  server_.answers = {[this] { return Truth(0.6); }};
  tracker_.laser_knows = true;
  BeLost();
  EXPECT_EQ(Run(40), RecoveryState::kFound) << notes_;
  EXPECT_EQ(server_.asked, 1);
  EXPECT_LT(Error_m(), 0.2);
}

TEST_F(LostAndFoundTest, AServerThatKnowsAnotherPlaceIsAskedThreeTimes) {
  server_.answers = {[this] { return AnswerAt(Lift({{10, 4}, 1}, 0), 0.999); }};
  tracker_.finds = tracker_.truth;
  BeLost();
  EXPECT_EQ(Run(100), RecoveryState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_EQ(server_.asked, 3);
  EXPECT_THAT(notes_, HasSubstr("does not fit here"));
}

TEST_F(LostAndFoundTest, WhoNeedsHelpAsksAServerThatHasComeBack) {
  server_.answers = {[] { return absl::UnavailableError("dead"); }};
  options_.most_search_s = 5;
  Make();
  BeLost();
  EXPECT_EQ(Run(100), RecoveryState::kNeedHelp) << notes_;
  const int asked = server_.asked;
  const Rigid2 stood = tracker_.odom_from_base;
  for (int i = 0; i < 50 / kStep_s; ++i) {
    EXPECT_EQ(Step(), RecoveryState::kNeedHelp);
  }
  EXPECT_EQ(server_.asked, asked + 3);
  EXPECT_EQ(tracker_.odom_from_base, stood);
  // Another place is not believed now either.
  server_.answers = {[this] { return AnswerAt(Lift({{10, 4}, 1}, 0), 0.999); }};
  for (int i = 0; i < 20 / kStep_s; ++i) {
    EXPECT_EQ(Step(), RecoveryState::kNeedHelp);
  }
  server_.answers = {[this] { return Truth(0.97); }};
  for (int i = 0; i < 30 / kStep_s; ++i) {
    if (Step() == RecoveryState::kFound) break;
  }
  EXPECT_EQ(lost_->state(), RecoveryState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
}

TEST_F(LostAndFoundTest, WhoNeedsHelpListensToAPerson) {
  server_.answers = {[] { return absl::UnavailableError("dead"); }};
  options_.most_search_s = 5;
  Make();
  BeLost();
  EXPECT_EQ(Run(100), RecoveryState::kNeedHelp) << notes_;
  // Also while it asks.
  server_.delay_s = 2;
  const int asked = server_.asked;
  while (server_.asked == asked) Step();
  tracker_.lost_verdict = {};
  lost_->WasTold(tracker_.now);
  server_.answers = {[this] { return AnswerAt(Lift({{10, 4}, 1}, 0), 0.999); }};
  EXPECT_EQ(Run(40), RecoveryState::kIdle) << notes_;
  EXPECT_EQ(tracker_.told, 0);
  EXPECT_EQ(server_.asked, asked + 1);
}

TEST_F(LostAndFoundTest, PicturesAreWantedForQuestionsAndChecksOnly) {
  EXPECT_FALSE(lost_->WantsPictures(tracker_.now));
  Run(1);
  EXPECT_FALSE(lost_->WantsPictures(tracker_.now));
  Run(options_.check_interval_s);
  EXPECT_TRUE(lost_->WantsPictures(tracker_.now));
  BeLost();
  has_camera_ = false;
  for (int i = 0; i < 100 && lost_->state() != RecoveryState::kLooking; ++i) {
    EXPECT_FALSE(Step() != RecoveryState::kLooking &&
                 lost_->WantsPictures(tracker_.now));
  }
  EXPECT_TRUE(lost_->WantsPictures(tracker_.now));
  EXPECT_EQ(lost_->state(), RecoveryState::kLooking);
}

TEST_F(LostAndFoundTest, AnUnknownSceneIsAskedForOnce) {
  server_.answers = {[] { return absl::NotFoundError("no scene 'x'"); }};
  tracker_.finds = tracker_.truth;
  BeLost();
  EXPECT_EQ(Run(100), RecoveryState::kFound) << notes_;
  EXPECT_EQ(server_.asked, 1);
}

TEST_F(LostAndFoundTest, WithoutPicturesItSearchesByLaser) {
  has_camera_ = false;
  tracker_.finds = tracker_.truth;
  BeLost();
  EXPECT_EQ(Run(100), RecoveryState::kFound) << notes_;
  EXPECT_THAT(notes_, HasSubstr("the camera gives no pictures"));
  EXPECT_EQ(server_.asked, 0);
}

TEST_F(LostAndFoundTest, TheSearchDoesNotBelieveAPlaceThatHasATwin) {
  options_.method = RecoveryMethod::kAmclOnly;
  Make();
  tracker_.alias = Rigid2{{9, 3}, 0.5};
  tracker_.finds = *tracker_.alias;
  BeLost();
  EXPECT_EQ(Run(250), RecoveryState::kNeedHelp) << notes_;
  EXPECT_THAT(notes_, HasSubstr("the laser fits another place as well"));
  EXPECT_EQ(server_.asked, 0);
}

TEST_F(LostAndFoundTest, TheSearchEndsInTimeIfItFindsAWrongPlace) {
  options_.method = RecoveryMethod::kAmclOnly;
  options_.most_search_s = 60;
  Make();
  tracker_.finds = Rigid2{{10, 4}, 1};
  BeLost();
  EXPECT_EQ(Run(62), RecoveryState::kNeedHelp) << notes_;
  // What particles gathered at was wrong: they were spread again.
  EXPECT_GE(tracker_.spread, 2);
}

TEST_F(LostAndFoundTest, InjectionOnlySpreadsNothing) {
  options_.method = RecoveryMethod::kInjectionOnly;
  options_.most_search_s = 30;
  Make();
  BeLost();
  EXPECT_EQ(Run(60), RecoveryState::kNeedHelp) << notes_;
  EXPECT_EQ(tracker_.spread, 0);
  EXPECT_EQ(tracker_.told, 0);
}

TEST_F(LostAndFoundTest, ARobotThatCannotTurnEndsInTime) {
  can_turn_ = false;
  free_ahead_m_ = 0;
  RelocalizationAnswer none;
  server_.answers = {[none] { return none; }};
  BeLost();
  EXPECT_EQ(Run(250), RecoveryState::kNeedHelp) << notes_;
  EXPECT_EQ(tracker_.odom_from_base, Rigid2());
}

TEST_F(LostAndFoundTest, WithoutRoomForAFullTurnItSwingsThereAndBack) {
  can_turn_ = false;
  swings_rad_ = 1.2;
  free_ahead_m_ = 0;
  tracker_.laser_knows = true;
  RelocalizationAnswer none;
  server_.answers = {[none] { return none; }};
  BeLost();
  EXPECT_EQ(Run(20), RecoveryState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_THAT(notes_, HasSubstr("by laser alone"));
}

TEST_F(LostAndFoundTest, APersonsWordEndsIt) {
  BeLost();
  Step();
  EXPECT_TRUE(lost_->IsActive());
  tracker_.lost_verdict = {};
  lost_->WasTold(tracker_.now);
  EXPECT_EQ(lost_->state(), RecoveryState::kIdle);
  EXPECT_EQ(Run(2), RecoveryState::kIdle);
}

TEST_F(LostAndFoundTest, AStartWithoutAPlaceAsks) {
  tracker_.believed.reset();
  lost_->Begin(RecoveryCause::kStart, tracker_.now);
  EXPECT_EQ(Run(20), RecoveryState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
}

TEST_F(LostAndFoundTest, TheCheckAsksNowAndThenAndIsContent) {
  tracker_.believed = LevelPose{.map_from_base = tracker_.truth, .place = {}};
  drives_straight_ = true;
  EXPECT_EQ(Run(45), RecoveryState::kIdle);
  EXPECT_EQ(server_.asked, 2);
  EXPECT_EQ(tracker_.told, 0);
  EXPECT_EQ(notes_, "");
}

TEST_F(LostAndFoundTest, TheCheckCorrectsADrift) {
  Rigid2 drifted = tracker_.truth;
  drifted.translation.x += 0.4;
  tracker_.believed = LevelPose{.map_from_base = drifted, .place = {}};
  drives_straight_ = true;
  EXPECT_EQ(Run(25), RecoveryState::kIdle);
  EXPECT_EQ(tracker_.told, 1);
  EXPECT_LT(Error_m(), 0.1);
  EXPECT_THAT(notes_, HasSubstr("corrected"));
}

TEST_F(LostAndFoundTest, TheCheckStopsARobotThatIsElsewhereAndLooksTwice) {
  drives_straight_ = true;
  EXPECT_EQ(Run(60), RecoveryState::kFound) << notes_;
  EXPECT_LT(Error_m(), 0.2);
  EXPECT_EQ(server_.asked, 3);
  EXPECT_THAT(notes_, HasSubstr("looks again"));
  EXPECT_THAT(notes_, HasSubstr("two views agree"));
}

TEST_F(LostAndFoundTest, TheCheckDoesNotMoveARobotThatIsRight) {
  tracker_.believed = LevelPose{.map_from_base = tracker_.truth, .place = {}};
  server_.answers = {[this] { return AnswerAt(Lift({{10, 4}, 1}, 0), 0.999); }};
  drives_straight_ = true;
  EXPECT_EQ(Run(45), RecoveryState::kIdle) << notes_;
  EXPECT_EQ(tracker_.told, 0);
  EXPECT_LT(Error_m(), 1e-6);
}

TEST(LostAndFoundOptionsTest, NamesWhatIsOutOfRange) {
  LostAndFoundOptions options;
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
}  // namespace treeline
