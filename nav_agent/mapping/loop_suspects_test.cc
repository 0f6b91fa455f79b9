#include "nav_agent/mapping/loop_suspects.h"

#include <vector>

#include "gtest/gtest.h"

namespace treeline::mapping {
namespace {

// A drive along x, a metre a keyscan, that is back at its beginning by a loop
// which puts the robot 2 m to the left.
class LoopSuspectsTest : public testing::Test {
 protected:
  void DriveTo(int keyscan) {
    while (static_cast<int>(poses_.size()) <= keyscan) {
      way_m_.push_back(static_cast<double>(poses_.size()));
      poses_.push_back({{way_m_.back(), 0}, 0});
    }
  }
  // From the first keyscan, `aside` of where the graph has it.
  LoopLink Link(int keyscan, double aside_m) const {
    return {
        .constraint = {.from = 0,
                       .to = keyscan,
                       .from_from_to =
                           geometry::Rigid2{
                               {way_m_[static_cast<size_t>(keyscan)], aside_m},
                               0}},
        .wide = true};
  }
  // Each scan from `begin` to `end` is found where the loop puts it, or
  // contradicted there.
  void Follow(int begin, int end, bool is_found) {
    for (int i = begin; i < end; ++i) {
      DriveTo(i);
      suspects_.Follow(i, poses_, [&](const geometry::Rigid2& place) {
        EXPECT_NEAR(place.translation.y, 2, 1e-9);
        FollowedKeyscan seen;
        if (is_found) seen.found = Link(i, 2);
        seen.is_contradicted = !is_found;
        return seen;
      });
    }
  }

  std::vector<geometry::Rigid2> poses_;
  std::vector<double> way_m_;
  LoopSuspects suspects_{{.min_followed = 3, .follow_m = 1.5, .give_up_m = 8}};
};

TEST_F(LoopSuspectsTest, OnlyWhatMovesTheRobotFarIsSuspect) {
  DriveTo(10);
  EXPECT_TRUE(suspects_.IsSuspect(Link(10, 2), poses_));
  EXPECT_FALSE(suspects_.IsSuspect(Link(10, 0.4), poses_));
  LoopLink narrow = Link(10, 2);
  narrow.wide = false;
  EXPECT_FALSE(suspects_.IsSuspect(narrow, poses_));
}

TEST_F(LoopSuspectsTest, IsBelievedOnceItWasFoundOftenEnough) {
  DriveTo(10);
  EXPECT_TRUE(suspects_.Add(Link(10, 2), poses_));
  EXPECT_FALSE(suspects_.Add(Link(10, 2.1), poses_)) << "the same loop";
  EXPECT_TRUE(suspects_.Add(Link(10, -2), poses_));
  suspects_ = LoopSuspects({.min_followed = 3, .follow_m = 1.5});
  ASSERT_TRUE(suspects_.Add(Link(10, 2), poses_));
  Follow(11, 13, true);
  EXPECT_TRUE(suspects_.TakeConfirmed(way_m_, false).empty());
  Follow(13, 14, true);
  EXPECT_EQ(suspects_.TakeConfirmed(way_m_, false).size(), 4u);
  EXPECT_TRUE(suspects_.TakeConfirmed(way_m_, true).empty()) << "forgotten";
}

TEST_F(LoopSuspectsTest, WhatIsContradictedMoreOftenThanFoundIsGivenUp) {
  DriveTo(10);
  ASSERT_TRUE(suspects_.Add(Link(10, 2), poses_));
  Follow(11, 14, true);
  Follow(14, 18, false);
  EXPECT_TRUE(suspects_.TakeConfirmed(way_m_, false).empty());
  EXPECT_TRUE(suspects_.TakeConfirmed(way_m_, true).empty());
  EXPECT_EQ(suspects_.GiveUp(way_m_), 0);
  Follow(18, 20, false);
  EXPECT_EQ(suspects_.GiveUp(way_m_), 1);
}

TEST_F(LoopSuspectsTest, WhatIsSeenThroughThereIsNotBelieved) {
  DriveTo(10);
  LoopLink link = Link(10, 2);
  link.there = {.told = 100, .contradicted = 20};
  ASSERT_TRUE(suspects_.Add(link, poses_));
  Follow(11, 15, true);
  EXPECT_TRUE(suspects_.TakeConfirmed(way_m_, false).empty());
}

TEST_F(LoopSuspectsTest, AtTheEndOneScanOrNoneMayDo) {
  DriveTo(10);
  ASSERT_TRUE(suspects_.Add(Link(10, 2), poses_));
  EXPECT_TRUE(suspects_.TakeConfirmed(way_m_, false).empty());
  EXPECT_EQ(suspects_.TakeConfirmed(way_m_, true).size(), 1u)
      << "nothing was left to follow";
  ASSERT_TRUE(suspects_.Add(Link(10, 2), poses_));
  DriveTo(13);
  EXPECT_TRUE(suspects_.TakeConfirmed(way_m_, true).empty())
      << "it was followed and never found";
}

}  // namespace
}  // namespace treeline::mapping
