#include "nav_agent/behavior/search_motion.h"

#include <cmath>
#include <functional>
#include <numbers>

#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_relocalization.h"

namespace treeline::behavior {
namespace {

// A robot that does what it is told to, with a way ahead that depends on where
// it looks.
class SearchMotionTest : public testing::Test {
 protected:
  SearchMotionTest() { search_.Begin(At(now_s_)); }

  SearchMotion::Result Step() {
    now_s_ += kStep_s;
    const double yaw_rad = motion_.odom_from_base.yaw_rad;
    const SearchMotion::Result result =
        search_.Step(motion_,
                     {.now = At(now_s_),
                      .free_ahead_m = free_at_(yaw_rad),
                      .free_behind_m = free_behind_m_},
                     {.turn_radps = 0.8, .move_mps = 0.15}, swing_);
    core::VelocityCommand moves = result.wanted;
    if (is_stuck_) moves = {};
    if (motion_.odom_from_base.translation.x > turns_below_m_) {
      moves.yaw_rate_radps = 0;
    }
    if (std::abs(geometry::NormalizedAngle_rad(
            motion_.odom_from_base.yaw_rad)) < held_within_rad_) {
      moves.forward_mps = 0;
    }
    const geometry::Rigid2 step = {{kStep_s * moves.forward_mps, 0},
                                   kStep_s * moves.yaw_rate_radps};
    motion_.odom_from_base = motion_.odom_from_base * step;
    motion_.forward_mps = moves.forward_mps;
    motion_.yaw_rate_radps = moves.yaw_rate_radps;
    search_.AddTurn(std::abs(step.yaw_rad));
    turns_ += result.has_turned_around ? 1 : 0;
    return result;
  }
  void Run(double seconds) {
    for (double s = 0; s < seconds; s += kStep_s) Step();
  }

  SearchMotion search_;
  SwingMotion swing_;
  localization::TrackedMotion motion_;
  double now_s_ = 100;
  bool is_stuck_ = false;
  double free_behind_m_ = 0;
  // Further on, something holds it when it turns.
  double turns_below_m_ = INFINITY;
  // So near to its first heading nothing lets it move on, whatever looks free.
  double held_within_rad_ = 0;
  int turns_ = 0;
  std::function<double(double)> free_at_ = [](double) { return 0.0; };
};

TEST_F(SearchMotionTest, TurnsAroundInPlaceWhereNothingIsFree) {
  Run(7.5);
  EXPECT_EQ(turns_, 0);
  Run(1);
  EXPECT_EQ(turns_, 1);
  Run(8.5);
  EXPECT_EQ(turns_, 2);
  EXPECT_EQ(motion_.odom_from_base.translation, (geometry::Vec2{0, 0}));
}

TEST_F(SearchMotionTest, WhereNoSideIsFreeItBacksUpOnceATurn) {
  free_behind_m_ = 0.2;
  Run(12);
  EXPECT_EQ(turns_, 1);
  EXPECT_NEAR(geometry::Norm(motion_.odom_from_base.translation), 0.2, 0.03);
}

TEST_F(SearchMotionTest, MovesToTheFreestSideAndNotFurtherThanIsFree) {
  free_at_ = [](double yaw_rad) {
    return std::abs(geometry::NormalizedAngle_rad(yaw_rad - 2)) < 0.2 ? 1.0
                                                                      : 0.4;
  };
  Run(20);
  const geometry::Vec2 at = motion_.odom_from_base.translation;
  EXPECT_NEAR(geometry::Norm(at), 0.7, 0.02);
  EXPECT_NEAR(std::atan2(at.y, at.x), 1.75, 0.15);
}

TEST_F(SearchMotionTest, AMoveEndsBeforeWhatComesInItsWay) {
  free_at_ = [this](double) {
    const double moved_m = geometry::Norm(motion_.odom_from_base.translation);
    return moved_m < 0.4 ? 1.0 : 0.2;
  };
  Run(16);
  EXPECT_NEAR(geometry::Norm(motion_.odom_from_base.translation), 0.4, 0.02);
}

TEST_F(SearchMotionTest, AMoveThatIsHeldEndsSoonAndAnotherWayIsTaken) {
  held_within_rad_ = 0.4;
  free_at_ = [](double yaw_rad) {
    return std::abs(geometry::NormalizedAngle_rad(yaw_rad)) < 0.2 ? 1.0 : 0.8;
  };
  // A turn, a way that it is held on, another turn.
  Run(8 + 0.5 + kTurnStart_s + 8);
  EXPECT_EQ(turns_, 2);
  EXPECT_EQ(motion_.odom_from_base.translation, (geometry::Vec2{0, 0}));
  Run(6);
  EXPECT_GT(geometry::Norm(motion_.odom_from_base.translation), 0.4);
}

TEST_F(SearchMotionTest, AnOrderedWayThatIsHeldIsBlocked) {
  held_within_rad_ = 1;
  free_at_ = [](double) { return 1.0; };
  search_.GoTo(0, 2, 0.3, motion_, At(now_s_));
  SearchMotion::Result result;
  double took_s = 0;
  for (; took_s < 10 && !result.has_arrived; took_s += kStep_s) {
    result = Step();
  }
  EXPECT_TRUE(result.was_blocked);
  EXPECT_NEAR(took_s, kTurnStart_s, 0.2);
}

TEST_F(SearchMotionTest, WhoCannotFaceAnOrderedWayNorBackUpGoesAhead) {
  turns_below_m_ = -0.1;
  free_at_ = [](double) { return 1.0; };
  search_.GoTo(2, 1, 0.3, motion_, At(now_s_));
  SearchMotion::Result result;
  for (double s = 0; s < 10 && !result.has_arrived; s += kStep_s) {
    result = Step();
  }
  // There, a way from where it is then can be ordered.
  EXPECT_TRUE(result.has_arrived);
  EXPECT_FALSE(result.was_blocked);
  EXPECT_NEAR(motion_.odom_from_base.translation.x, kMinSearchMove_m, 0.02);
}

TEST_F(SearchMotionTest, DoesNotGoBackToWhereItCameFrom) {
  // A corridor: 1.2 m ahead, and 2 m back.
  free_at_ = [this](double yaw_rad) {
    const bool is_first = turns_ == 0;
    const double away_rad = std::abs(geometry::NormalizedAngle_rad(yaw_rad));
    if (away_rad < 0.2) return 1.2;
    return !is_first && away_rad > std::numbers::pi - 0.2 ? 2.0 : 0.4;
  };
  Run(40);
  EXPECT_GT(motion_.odom_from_base.translation.x, 1.0);
}

TEST_F(SearchMotionTest, WhoIsStuckEndsTheTurnInTime) {
  is_stuck_ = true;
  Run(14);
  EXPECT_EQ(turns_, 0);
  Run(2);
  EXPECT_EQ(turns_, 1);
}

TEST_F(SearchMotionTest, AnInterruptionDoesNotCount) {
  is_stuck_ = true;
  Run(14);
  search_.Resume(At(now_s_));
  Run(2);
  EXPECT_EQ(turns_, 0);
}

TEST_F(SearchMotionTest, AnOrderedWayIsDrivenInsteadOfTheFreest) {
  free_at_ = [](double) { return 1.0; };
  Run(3);
  search_.GoTo(-1, 2.5, 0.3, motion_, At(now_s_));
  EXPECT_TRUE(search_.is_under_way());
  bool has_arrived = false;
  double took_s = 0;
  for (; took_s < 30 && !has_arrived; took_s += kStep_s) {
    const SearchMotion::Result result = Step();
    has_arrived = result.has_arrived;
    EXPECT_FALSE(result.was_blocked);
  }
  EXPECT_FALSE(search_.is_under_way());
  const geometry::Vec2 at = motion_.odom_from_base.translation;
  // Further than what is free ahead at any moment, and twice as fast.
  EXPECT_NEAR(geometry::Norm(at), 2.5, 0.02);
  EXPECT_NEAR(std::atan2(at.y, at.x), -1, 0.15);
  EXPECT_LT(took_s, 16);
  // A turn follows.
  const double yaw_rad = motion_.odom_from_base.yaw_rad;
  Run(1);
  EXPECT_GT(std::abs(motion_.odom_from_base.yaw_rad - yaw_rad), 0.5);
}

TEST_F(SearchMotionTest, AnOrderedWayEndsBeforeWhatComesInItsWay) {
  free_at_ = [this](double) {
    return geometry::Norm(motion_.odom_from_base.translation) < 0.6 ? 1.0 : 0.2;
  };
  search_.GoTo(1, 2, 0.3, motion_, At(now_s_));
  SearchMotion::Result result;
  for (double s = 0; s < 20 && !result.has_arrived; s += kStep_s) {
    result = Step();
  }
  EXPECT_TRUE(result.has_arrived);
  EXPECT_TRUE(result.was_blocked);
  EXPECT_NEAR(geometry::Norm(motion_.odom_from_base.translation), 0.6, 0.02);
}

TEST_F(SearchMotionTest, WhoCannotFaceAnOrderedWaySwingsInstead) {
  is_stuck_ = true;
  search_.GoTo(1, 2, 0.3, motion_, At(now_s_));
  Run(1.4);
  EXPECT_TRUE(search_.is_under_way());
  Run(0.3);
  EXPECT_FALSE(search_.is_under_way());
}

TEST_F(SearchMotionTest, WhoCannotFaceAnOrderedWayBacksUpFirst) {
  turns_below_m_ = -0.1;
  free_behind_m_ = 0.3;
  free_at_ = [](double) { return 1.0; };
  search_.GoTo(2, 1, 0.3, motion_, At(now_s_));
  bool has_arrived = false;
  for (double s = 0; s < 30 && !has_arrived; s += kStep_s) {
    has_arrived = Step().has_arrived;
  }
  EXPECT_TRUE(has_arrived);
  const geometry::Vec2 at = motion_.odom_from_base.translation;
  EXPECT_NEAR(at.x, -0.3 + std::cos(2), 0.15);
  EXPECT_NEAR(at.y, std::sin(2), 0.1);
}

TEST_F(SearchMotionTest, WhoIsHeldAfterBackingUpSwings) {
  turns_below_m_ = -5;
  free_behind_m_ = 0.3;
  search_.GoTo(2, 1, 0.3, motion_, At(now_s_));
  Run(10);
  EXPECT_FALSE(search_.is_under_way());
  EXPECT_NEAR(motion_.odom_from_base.translation.x, -0.3, 0.03);
}

TEST_F(SearchMotionTest, AnOrderedWayCanBeCutShort) {
  free_at_ = [](double) { return 1.0; };
  search_.GoTo(0, 2, 0.3, motion_, At(now_s_));
  Run(1);
  EXPECT_GT(motion_.odom_from_base.translation.x, 0.2);
  search_.EndWay(motion_, At(now_s_));
  EXPECT_FALSE(search_.is_under_way());
  const geometry::Vec2 at = motion_.odom_from_base.translation;
  Run(1);
  EXPECT_EQ(motion_.odom_from_base.translation, at);
}

}  // namespace
}  // namespace treeline::behavior
