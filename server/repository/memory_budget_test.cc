#include "server/repository/memory_budget.h"

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::repository {
namespace {

using ::testing::ElementsAre;
using ::testing::ElementsAreArray;

TEST(MemoryBudget, CountsReservationsAndResidents) {
  MemoryBudget budget(10);
  EXPECT_TRUE(budget.Fits(10, 0));
  EXPECT_FALSE(budget.Fits(10, 1));
  budget.Reserve(4);
  EXPECT_EQ(budget.reservations(), 1u);
  EXPECT_TRUE(budget.Fits(3, 3));
  EXPECT_FALSE(budget.Fits(4, 3));
  budget.Return(4);
  EXPECT_EQ(budget.reservations(), 0u);
  EXPECT_TRUE(budget.Fits(7, 3));
}

TEST(MemoryBudget, WithoutALimitEverythingFits) {
  const MemoryBudget budget(0);
  EXPECT_TRUE(budget.Fits(1ull << 60, 1ull << 60));
  EXPECT_FALSE(budget.IsTooLarge(1ull << 60));
  EXPECT_THAT(budget.ChooseToGo(std::vector<ResidentModel>{{.bytes = 9}}, 1, 9),
              ElementsAre());
}

TEST(MemoryBudget, AModelLargerThanAllOfItIsTooLarge) {
  const MemoryBudget budget(10);
  EXPECT_FALSE(budget.IsTooLarge(10));
  EXPECT_TRUE(budget.IsTooLarge(11));
}

TEST(MemoryBudget, WhatGoesIsAsFewAsAreEnoughInAStatedOrder) {
  // Each 3 bytes of 10, three of them held: 9 resident unless said otherwise.
  const ResidentModel old{.bytes = 3, .last_use = 1};
  const ResidentModel recent{.bytes = 3, .last_use = 7};
  const ResidentModel busy{.bytes = 3, .last_use = 0, .is_in_use = true};
  const ResidentModel own{.bytes = 3, .last_use = 0, .is_same_scene = true};
  const struct {
    std::string what;
    std::vector<ResidentModel> held;
    uint64_t bytes;
    uint64_t resident_bytes;
    std::vector<size_t> chosen;
  } cases[] = {
      {"fits", {old, recent, busy}, 1, 9, {}},
      {"the longest unused", {recent, old, busy}, 3, 9, {1}},
      {"two of them", {recent, old, busy}, 5, 9, {1, 0}},
      {"idle ones before busy ones", {busy, recent, old}, 3, 9, {2}},
      {"a busy one when idle ones are not enough",
       {busy, recent, old},
       9,
       9,
       {2, 1, 0}},
      {"the scene's own last", {own, busy, recent}, 3, 9, {2}},
      {"the scene's own after busy ones", {own, busy}, 7, 6, {1}},
      {"nothing but what comes free anyway", {busy, busy}, 4, 9, {}},
      {"what comes free, and one more", {busy, busy}, 5, 9, {0}},
  };
  const MemoryBudget budget(10);
  for (const auto& c : cases) {
    EXPECT_THAT(budget.ChooseToGo(c.held, c.bytes, c.resident_bytes),
                ElementsAreArray(c.chosen))
        << c.what;
  }
}

TEST(MemoryBudget, LoadsAtWorkAreWaitedForBeforeBusyModelsGo) {
  MemoryBudget budget(10);
  budget.Reserve(4);
  const ResidentModel busy{.bytes = 6, .is_in_use = true};
  // 4 of the load may come free: enough for 4, not for 5.
  EXPECT_THAT(budget.ChooseToGo(std::vector{busy}, 4, 6), ElementsAre());
  EXPECT_THAT(budget.ChooseToGo(std::vector{busy}, 5, 6), ElementsAre(0));
}

}  // namespace
}  // namespace treeline::repository
