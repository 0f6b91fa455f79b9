#include "common/base/byte_budget.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "absl/time/time.h"

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

// Each holds what another needs: the small ones give up, without patience's
// end, until the others get on.
TEST(ByteBudget, OfThoseThatWaitForEachOtherTheSmallestIsRefused) {
  constexpr int kLeases = 8;
  ByteBudget budget(400);
  std::vector<ByteLease> leases;
  for (int i = 0; i < kLeases; ++i) {
    leases.emplace_back(&budget);
    ASSERT_TRUE(leases.back().Resize(i == 3 ? 38 : 37));
  }
  std::atomic<int> granted = 0;
  std::atomic<bool> is_greatest_granted = false;
  std::vector<std::thread> waiters;
  for (ByteLease& lease : leases) {
    waiters.emplace_back([&] {
      const bool is_greatest = lease.bytes() == 38;
      if (lease.Resize(140, kLong)) {
        ++granted;
        if (is_greatest) is_greatest_granted = true;
      }
      lease.Release();
    });
  }
  for (std::thread& waiter : waiters) waiter.join();
  EXPECT_TRUE(is_greatest_granted);
  EXPECT_GE(granted, 2);
  EXPECT_EQ(budget.used_bytes(), 0u);
}

// There is somebody who may give back what is missing.
TEST(ByteBudget, NobodyIsRefusedWhileSomebodyElseHoldsWhatIsMissing) {
  ByteBudget budget(100);
  ByteLease first(&budget);
  ASSERT_TRUE(first.Resize(30));
  ByteLease second(&budget);
  ASSERT_TRUE(second.Resize(20));
  ByteLease third(&budget);
  ASSERT_TRUE(third.Resize(20));
  std::atomic<int> granted = 0;
  std::vector<std::thread> waiters;
  for (ByteLease* lease : {&second, &third}) {
    waiters.emplace_back([&granted, lease] {
      if (lease->Resize(30, kLong)) ++granted;
    });
  }
  absl::SleepFor(absl::Milliseconds(20));
  first.Release();
  for (std::thread& waiter : waiters) waiter.join();
  EXPECT_EQ(granted, 2);
}

TEST(ByteLease, OfNoBudgetIsGrantedEverything) {
  ByteLease lease;
  EXPECT_TRUE(lease.Resize(1ull << 60));
  EXPECT_EQ(lease.bytes(), 1ull << 60);
}

}  // namespace
}  // namespace treeline::base
