#include "nav_agent/behavior/pending_fixes.h"

#include "gtest/gtest.h"

namespace treeline::behavior {
namespace {

GatedFix Fix(FixVerdict verdict, double x_m, double yaw_rad = 0) {
  GatedFix fix;
  fix.verdict = verdict;
  fix.pose.map_from_base = {{x_m, 0}, yaw_rad};
  fix.motion.odom_from_base = {{0, 0}, yaw_rad};
  fix.covariance = FixCovariance({});
  fix.log_odds = 1;
  return fix;
}
GatedFix ServerSure(GatedFix fix) {
  fix.is_server_sure = true;
  return fix;
}

class PendingFixesTest : public testing::Test {
 protected:
  FixDecision Add(const GatedFix& fix, bool may_take_one = true,
                  bool is_unique = false) {
    return pending_.Add(fix, options_, may_take_one, is_unique).decision;
  }
  FixGateOptions options_;
  PendingFixes pending_;
};

TEST_F(PendingFixesTest, ASureOneIsTakenAtOnce) {
  EXPECT_EQ(Add(Fix(FixVerdict::kSure, 1)), FixDecision::kTake);
  EXPECT_TRUE(pending_.empty());
}

TEST_F(PendingFixesTest, AWeakOneWaitsForOneThatAgrees) {
  EXPECT_EQ(Add(Fix(FixVerdict::kWeak, 1)), FixDecision::kLookOn);
  EXPECT_EQ(pending_.size(), 1u);
  EXPECT_EQ(Add(Fix(FixVerdict::kWeak, 5)), FixDecision::kLookOn);
  const PendingFixes::Result result =
      pending_.Add(Fix(FixVerdict::kWeak, 1.1, 1), options_, true, false);
  EXPECT_EQ(result.decision, FixDecision::kTakeAgreed);
  // From another direction: what both say adds up.
  EXPECT_DOUBLE_EQ(result.fix.log_odds, 2);
  EXPECT_DOUBLE_EQ(result.fix.pose.map_from_base.translation.x, 1.1);
}

TEST_F(PendingFixesTest, AWeakOneThatTheLaserSaysTooIsTaken) {
  EXPECT_EQ(Add(Fix(FixVerdict::kWeak, 1), true, true), FixDecision::kTake);
}

TEST_F(PendingFixesTest, NoneIsTakenAloneWhereTwoAreAskedFor) {
  EXPECT_EQ(Add(Fix(FixVerdict::kSure, 1), false), FixDecision::kLookOn);
  EXPECT_EQ(Add(Fix(FixVerdict::kWeak, 5), false, true), FixDecision::kLookOn);
  EXPECT_EQ(Add(Fix(FixVerdict::kSure, 1), false), FixDecision::kTakeAgreed);
}

TEST_F(PendingFixesTest, ASureOneThatASureOneDisputesWaits) {
  pending_.Reset(ServerSure(Fix(FixVerdict::kSure, 5)));
  EXPECT_EQ(Add(ServerSure(Fix(FixVerdict::kSure, 1))), FixDecision::kLookOn);
  EXPECT_EQ(pending_.size(), 2u);
  // A loose_search one disputes nothing.
  pending_.Reset(Fix(FixVerdict::kWeak, 5));
  EXPECT_EQ(Add(ServerSure(Fix(FixVerdict::kSure, 1))), FixDecision::kTake);
}

TEST_F(PendingFixesTest, ThreeSureOnesInARowThatAreRefusedAreEnough) {
  const GatedFix refused = ServerSure(Fix(FixVerdict::kAgainstScan, 1));
  EXPECT_EQ(Add(refused), FixDecision::kLookOn);
  EXPECT_EQ(Add(refused), FixDecision::kLookOn);
  EXPECT_EQ(Add(refused), FixDecision::kServerIsLost);
}

TEST_F(PendingFixesTest, DoubtAndOneThatPassesBeginTheRowAnew) {
  const GatedFix refused = ServerSure(Fix(FixVerdict::kNotOnGround, 1));
  Add(refused);
  Add(refused);
  // The server is not sure of these, or says so itself.
  EXPECT_EQ(Add(Fix(FixVerdict::kAgainstGravity, 1)), FixDecision::kLookOn);
  EXPECT_EQ(Add(ServerSure(Fix(FixVerdict::kNotLocalized, 1))),
            FixDecision::kLookOn);
  EXPECT_EQ(Add(ServerSure(Fix(FixVerdict::kLowConfidence, 1))),
            FixDecision::kLookOn);
  Add(Fix(FixVerdict::kWeak, 1));
  EXPECT_EQ(Add(refused), FixDecision::kLookOn);
  EXPECT_EQ(Add(refused), FixDecision::kLookOn);
  EXPECT_EQ(Add(refused), FixDecision::kServerIsLost);
}

TEST_F(PendingFixesTest, TheOldestGoFirst) {
  for (int i = 0; i < 20; ++i) Add(Fix(FixVerdict::kWeak, 10.0 * i));
  EXPECT_EQ(pending_.size(), 8u);
  const auto x_is = [](double x_m) {
    return [x_m](const GatedFix& fix) {
      return fix.pose.map_from_base.translation.x == x_m;
    };
  };
  EXPECT_FALSE(pending_.TakeFirst(x_is(110)).has_value());
  EXPECT_TRUE(pending_.TakeFirst(x_is(120)).has_value());
  EXPECT_FALSE(pending_.TakeFirst(x_is(120)).has_value());
  EXPECT_EQ(pending_.size(), 7u);
}

TEST_F(PendingFixesTest, KnowsWhereTheLastViewWas) {
  EXPECT_FALSE(pending_.LastYaw_rad().has_value());
  Add(Fix(FixVerdict::kWeak, 1, 0.5));
  Add(Fix(FixVerdict::kWeak, 5, 0.7));
  EXPECT_EQ(pending_.LastYaw_rad(), 0.7);
  pending_.Clear();
  EXPECT_FALSE(pending_.LastYaw_rad().has_value());
}

}  // namespace
}  // namespace treeline::behavior
