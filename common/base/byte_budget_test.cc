#include "common/base/byte_budget.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>
#include <utility>

namespace treeline::base {
namespace {

constexpr std::chrono::hours kLong{1};

TEST(ByteBudget, RefusesWhatGoesBeyondItAndTakesItBack) {
  ByteBudget budget(400);
  ByteLease first(&budget);
  ByteLease second(&budget);
  EXPECT_TRUE(first.Resize(200));
  EXPECT_FALSE(second.Resize(101));
  EXPECT_EQ(second.bytes(), 0u);
  EXPECT_TRUE(second.Resize(100));
  EXPECT_FALSE(first.Resize(201));
  EXPECT_EQ(first.bytes(), 200u);
  EXPECT_TRUE(first.Resize(10));
  EXPECT_EQ(budget.used_bytes(), 110u);
  second.Release();
  EXPECT_EQ(budget.used_bytes(), 10u);
}

TEST(ByteBudget, KeepsAQuarterForSmallOnes) {
  ByteBudget budget(6400);
  ByteLease large(&budget);
  EXPECT_TRUE(large.Resize(4800));
  ByteLease small(&budget);
  EXPECT_FALSE(small.Resize(101));
  EXPECT_TRUE(small.Resize(100));
}

TEST(ByteBudget, WhatIsLargerThanAllOfItGoesAlone) {
  ByteBudget budget(100);
  ByteLease giant(&budget);
  EXPECT_TRUE(giant.Resize(1000));
  ByteLease other(&budget);
  EXPECT_FALSE(other.Resize(1));
  EXPECT_TRUE(giant.Resize(500));
  EXPECT_FALSE(other.Resize(1));
  giant.Release();
  EXPECT_TRUE(other.Resize(1));
  EXPECT_FALSE(giant.Resize(1000));
}

TEST(ByteBudget, GivesBackWhatAMovedLeaseHeldOnce) {
  ByteBudget budget(1000);
  {
    ByteLease first(&budget);
    ASSERT_TRUE(first.Resize(50));
    ByteLease second = std::move(first);
    EXPECT_EQ(second.bytes(), 50u);
    ByteLease third(&budget);
    ASSERT_TRUE(third.Resize(20));
    third = std::move(second);
    EXPECT_EQ(budget.used_bytes(), 50u);
  }
  EXPECT_EQ(budget.used_bytes(), 0u);
}

TEST(ByteBudget, AWaiterGoesOnWhenThereIsRoom) {
  ByteBudget budget(100);
  ByteLease first(&budget);
  ASSERT_TRUE(first.Resize(100));
  bool granted = false;
  std::thread waiter([&] {
    ByteLease second(&budget);
    granted = second.Resize(50, kLong);
  });
  first.Release();
  waiter.join();
  EXPECT_TRUE(granted);
}

TEST(ByteLease, OfNoBudgetIsGrantedEverything) {
  ByteLease lease;
  EXPECT_TRUE(lease.Resize(1ull << 60));
  EXPECT_EQ(lease.bytes(), 1ull << 60);
}

}  // namespace
}  // namespace treeline::base
