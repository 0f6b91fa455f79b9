#include "nav_agent/behavior/held_search.h"

#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_relocalization.h"

namespace treeline::behavior {
namespace {

constexpr core::VelocityCommand kTurn = {.forward_mps = 0,
                                         .yaw_rate_radps = 0.5};

TEST(HeldSearch, WhoIsHeldForLongMayTurnAroundOnce) {
  HeldSearch held;
  EXPECT_TRUE(held.MaySuppose(At(0)));
  double now_s = 0;
  for (; now_s < kSearchHeld_s - 0.1; now_s += kStep_s) {
    held.Step(kTurn, {}, At(now_s));
    EXPECT_TRUE(held.MaySuppose(At(now_s)));
  }
  for (int i = 0; i < 8; ++i, now_s += kStep_s) held.Step(kTurn, {}, At(now_s));
  EXPECT_FALSE(held.MaySuppose(At(now_s)));
  EXPECT_FALSE(held.MaySuppose(At(now_s + kFullTurn_s - 0.5)));
  EXPECT_TRUE(held.MaySuppose(At(now_s + kFullTurn_s + 0.5)));
}

TEST(HeldSearch, WhoMovesOrStandsByItselfIsNotHeld) {
  HeldSearch held;
  for (double now_s = 0; now_s < 20; now_s += kStep_s) {
    // Now and then it gets on; in between it wants nothing.
    const bool moves = static_cast<int>(now_s) % 2 == 0;
    held.Step(moves ? kTurn : core::VelocityCommand{},
              moves ? kTurn : core::VelocityCommand{}, At(now_s));
    EXPECT_TRUE(held.MaySuppose(At(now_s)));
  }
}

}  // namespace
}  // namespace treeline::behavior
