#include "nav_agent/behavior/confirming_state.h"

#include <memory>
#include <string>

#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_relocalization.h"

namespace treeline::behavior {
namespace {

using Outcome = ConfirmingState::Outcome;

class ConfirmingStateTest : public testing::Test {
 protected:
  ConfirmingStateTest() { tracker_.now = At(100); }

  // The tracker was told a place that is so far off (m).
  void Seed(bool seen_twice, double off_m = 0) {
    GatedFix fix;
    fix.verdict = FixVerdict::kSure;
    fix.pose.map_from_base = tracker_.truth * geometry::Rigid2{{off_m, 0}, 0};
    fix.motion = *tracker_.Motion();
    tracker_.believed = fix.pose;
    confirming_.emplace(fix, seen_twice, tools_, tracker_.now);
  }
  ConfirmingState::Result Step() {
    tracker_.now += std::chrono::milliseconds(25);
    const ConfirmingState::Result result = confirming_->Step(
        {.now = tracker_.now, .can_turn = can_turn_, .free_ahead_m = 0},
        tools_);
    tracker_.Move(kStep_s, can_turn_ ? result.wanted : core::VelocityCommand{});
    return result;
  }
  // Until it is decided, or for so long.
  Outcome Run(double at_most_s = 20) {
    for (double s = 0; s < at_most_s; s += kStep_s) {
      const ConfirmingState::Result result = Step();
      why_ = result.why;
      took_s_ = s;
      if (result.outcome != Outcome::kOpen) return result.outcome;
    }
    return Outcome::kOpen;
  }

  ScriptedTracker tracker_;
  RelocalizationBehaviorOptions options_;
  RelocalizationTools tools_{
      std::make_shared<const traversability::NavigationMap>(
          *traversability::NavigationMap::Make(TwoRooms())),
      core::RobotModel(), tracker_, options_};
  std::optional<ConfirmingState> confirming_;
  bool can_turn_ = true;
  std::string why_;
  double took_s_ = 0;
};

TEST_F(ConfirmingStateTest, OneViewIsEnoughWhereTheScanFitsNowhereElse) {
  Seed(false);
  EXPECT_EQ(Run(), Outcome::kFound);
  EXPECT_EQ(why_, "seen once, and scans fit nowhere else");
  // It has turned, and eight scans have come.
  EXPECT_GE(tracker_.odom_from_base.yaw_rad, 0.5);
  EXPECT_GE(took_s_, 0.75);
}

TEST_F(ConfirmingStateTest, WhereRoomsAreAlikeItAsksForASecondView) {
  tracker_.alias = geometry::Rigid2{{9, 3}, 0.5};
  Seed(false);
  EXPECT_EQ(Run(), Outcome::kSecondView);
  EXPECT_EQ(why_, "the laser would fit elsewhere too");
}

TEST_F(ConfirmingStateTest, TwoViewsAreEnoughWhereRoomsAreAlike) {
  tracker_.alias = geometry::Rigid2{{9, 3}, 0.5};
  Seed(true);
  EXPECT_EQ(Run(), Outcome::kFound);
  EXPECT_EQ(why_, "seen twice, and scans fit");
}

TEST_F(ConfirmingStateTest, WhereScansFitBetterElsewhereItIsNot) {
  Seed(true, 0.3);
  tracker_.alias = tracker_.truth;
  EXPECT_EQ(Run(), Outcome::kRefuted);
  EXPECT_EQ(why_, "scans fit better elsewhere");
}

TEST_F(ConfirmingStateTest, TwoViewsWaitForTheSearchUnlessNothingCanBeBetter) {
  tracker_.search_steps = 120;
  Seed(true, 0.1);
  EXPECT_EQ(Run(), Outcome::kFound);
  EXPECT_GE(took_s_, 120 * kStep_s);
  Seed(true);
  EXPECT_EQ(Run(), Outcome::kFound);
  EXPECT_LT(took_s_, 120 * kStep_s);
}

TEST_F(ConfirmingStateTest, ScansThatDoNotFitEndIt) {
  Seed(true);
  tracker_.best_fit = 0.5;
  EXPECT_EQ(Run(), Outcome::kRefuted);
  EXPECT_EQ(why_, "scans do not fit there");
  // The thirteenth.
  EXPECT_NEAR(took_s_, 1.3, 0.1);
}

TEST_F(ConfirmingStateTest, AmclMustStayWhereItWasPut) {
  Seed(true);
  tracker_.believed->map_from_base.translation.x += 0.61;
  EXPECT_EQ(Run(), Outcome::kRefuted);
  EXPECT_EQ(why_, "localization went elsewhere");
}

TEST_F(ConfirmingStateTest, TheVerdictMustNotSayLost) {
  Seed(true);
  tracker_.lost_verdict.state = localization::LostState::kLost;
  EXPECT_EQ(Run(), Outcome::kRefuted);
  Seed(true);
  tracker_.lost_verdict = {};
  tracker_.lost_verdict.probability = 0.31;
  EXPECT_EQ(Run(), Outcome::kRefuted);
  EXPECT_EQ(why_, "it was not confirmed in time");
  EXPECT_NEAR(took_s_, kMaxConfirming_s, 0.1);
}

TEST_F(ConfirmingStateTest, WithoutRoomToTurnItNeedsASecondView) {
  can_turn_ = false;
  Seed(false);
  EXPECT_EQ(Run(), Outcome::kSecondView);
  EXPECT_EQ(why_, "there is no room to turn");
  EXPECT_NEAR(took_s_, 4, 0.1);
  Seed(true);
  EXPECT_EQ(Run(), Outcome::kFound);
  EXPECT_EQ(why_, "seen twice, and scans fit nowhere else");
}

TEST_F(ConfirmingStateTest, WithoutRoomWhereRoomsAreAlikeItIsNotConfirmed) {
  can_turn_ = false;
  tracker_.alias = geometry::Rigid2{{9, 3}, 0.5};
  Seed(true);
  EXPECT_EQ(Run(), Outcome::kRefuted);
  EXPECT_EQ(why_, "it was not confirmed in time");
}

}  // namespace
}  // namespace treeline::behavior
