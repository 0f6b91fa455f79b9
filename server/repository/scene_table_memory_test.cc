#include <string>
#include <vector>

#include "common/base/error_info.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/repository/load_failure.h"
#include "server/repository/scene_table_fixture.h"

namespace treeline::repository {
namespace {

using ::testing::ElementsAre;

// Room for ten bytes.
class BudgetTest : public SceneTableTest {
 protected:
  BudgetTest() : SceneTableTest(10) {}

  std::vector<std::string> InMemory() {
    std::vector<std::string> names;
    for (const SceneStatus& scene : table_.List()) {
      if (scene.resident_bytes > 0) names.push_back(scene.name);
    }
    return names;
  }
};

TEST_F(BudgetTest, TheLongestUnusedGoesFirst) {
  for (const char* scene : {"a", "b", "c"}) source_.Put(scene, "1", "good", 4);
  Rescan();
  Answer("a");
  Answer("b");
  Answer("a");
  Answer("c");
  EXPECT_THAT(InMemory(), ElementsAre("a", "c"));
  EXPECT_EQ(table_.Stats().counts.evictions, 1u);
  EXPECT_THAT(events_, ::testing::Contains("EVICTED b/1"));
  EXPECT_EQ(resident_, 8u);
}

TEST_F(BudgetTest, WhatFitsIsLoadedOnce) {
  for (const char* scene : {"a", "b", "c"}) source_.Put(scene, "1", "good", 3);
  Rescan();
  for (int round = 0; round < 10; ++round) {
    for (const char* scene : {"a", "b", "c"}) EXPECT_EQ(Answer(scene), "1");
  }
  EXPECT_EQ(table_.Stats().counts.loads, 3u);
  EXPECT_EQ(table_.Stats().counts.evictions, 0u);
}

TEST_F(BudgetTest, OnlyAsMuchGoesAsIsNeeded) {
  for (const char* scene : {"a", "b", "c", "d"}) {
    source_.Put(scene, "1", "good", 2);
  }
  source_.Put("e", "1", "good", 5);
  Rescan();
  for (const char* scene : {"a", "b", "c", "d", "e"}) Answer(scene);
  EXPECT_THAT(InMemory(), ElementsAre("c", "d", "e"));
}

TEST_F(BudgetTest, AModelThatIsLargerThanTheBudgetIsRefusedAndNothingGoes) {
  source_.Put("a", "1", "good", 10);
  source_.Put("b", "1", "good", 11);
  source_.Put("c", "1", "good", ~uint64_t{0});
  Rescan();
  Answer("a");
  for (const char* scene : {"b", "c"}) {
    const auto asked = Ask(scene);
    EXPECT_THAT(RunLoads(), ElementsAre());
    EXPECT_EQ(asked->scene.status().code(),
              absl::StatusCode::kResourceExhausted);
    EXPECT_EQ(base::ErrorInfoOf(asked->scene.status()).reason, kMemoryBudget);
    EXPECT_FALSE(base::RetryAfterOf(asked->scene.status()));
  }
  EXPECT_THAT(InMemory(), ElementsAre("a"));
}

// As files are that are shorter than what they hold.
TEST_F(BudgetTest, AModelThatTakesMoreThanItsFileWaitsForRoomForThat) {
  source_.Put("a", "1", "good", 6);
  source_.Put("b", "1", "good", 3);
  Rescan();
  Answer("a");
  auto waiting = Ask("b");
  const auto job = Next();
  ASSERT_TRUE(job);
  table_.Postpone(*job, 7);
  EXPECT_FALSE(waiting->answered);
  EXPECT_FALSE(table_.is_settled());
  EXPECT_THAT(RunLoads(), ElementsAre("b/1"));
  EXPECT_TRUE(waiting->answered);
  EXPECT_THAT(InMemory(), ElementsAre("b"));
  EXPECT_EQ(resident_, 7u);
  EXPECT_TRUE(table_.is_settled());
  waiting.reset();
  // What is known of it stays known while its file is the same.
  Rescan();
  Answer("a");
  EXPECT_THAT(InMemory(), ElementsAre("a"));
}

TEST_F(BudgetTest, AModelThatTakesMoreThanTheBudgetIsRefusedWhateverItsFile) {
  source_.Put("a", "1", "good", 3);
  Rescan();
  const auto asked = Ask("a");
  table_.Postpone(*Next(), 11);
  EXPECT_THAT(RunLoads(), ElementsAre());
  ASSERT_TRUE(asked->answered);
  EXPECT_EQ(base::ErrorInfoOf(asked->scene.status()).reason, kMemoryBudget);
  // Another file of the version may be smaller.
  source_.Put("a", "1", "good", 4);
  Rescan();
  EXPECT_EQ(Answer("a"), "1");
}

TEST_F(BudgetTest, WhatAQueryUsesCountsUntilTheQueryEnds) {
  source_.Put("a", "1", "good", 8);
  source_.Put("b", "1", "good", 8);
  Rescan();
  auto query = Ask("a");
  RunLoads();
  const auto waiting = Ask("b");
  EXPECT_THAT(RunLoads(), ElementsAre());
  EXPECT_FALSE(waiting->answered);
  EXPECT_EQ(resident_, 8u);
  EXPECT_TRUE((*query->scene)->localizer != nullptr);
  query.reset();
  EXPECT_EQ(resident_, 0u);
  EXPECT_THAT(RunLoads(), ElementsAre("b/1"));
  EXPECT_TRUE(waiting->answered);
}

TEST_F(BudgetTest, TheIdleGoBeforeThoseInUse) {
  for (const char* scene : {"a", "b", "c"}) source_.Put(scene, "1", "good", 4);
  Rescan();
  const auto query = Ask("a");
  RunLoads();
  Answer("b");
  Answer("c");
  EXPECT_THAT(InMemory(), ElementsAre("a", "c"));
}

TEST_F(BudgetTest, ALargeModelThatWaitsIsNotOvertakenForever) {
  for (const char* scene : {"a", "b"}) source_.Put(scene, "1", "good", 5);
  source_.Put("large", "1", "good", 10);
  source_.Put("small", "1", "good", 5);
  Rescan();
  auto query_a = Ask("a");
  auto query_b = Ask("b");
  RunLoads();
  const auto large = Ask("large");
  const auto small = Ask("small");
  EXPECT_THAT(RunLoads(), ElementsAre());
  query_a.reset();
  EXPECT_THAT(RunLoads(), ElementsAre());
  query_b.reset();
  EXPECT_THAT(RunLoads(1), ElementsAre("large/1"));
  EXPECT_TRUE(large->answered);
  EXPECT_FALSE(small->answered);
}

TEST_F(BudgetTest, ASmallModelNeedNotWaitForALargeOneIfBothFit) {
  source_.Put("a", "1", "good", 6);
  source_.Put("b", "1", "good", 5);
  source_.Put("c", "1", "good", 4);
  Rescan();
  auto query = Ask("a");
  RunLoads();
  const auto b = Ask("b");
  const auto c = Ask("c");
  EXPECT_FALSE(b->answered);
  EXPECT_THAT(RunLoads(), ElementsAre());  // 6 + 5 + 4 > 10
  query.reset();
  EXPECT_THAT(RunLoads(), ElementsAre("b/1", "c/1"));
}

TEST_F(BudgetTest, ForANewVersionOthersGoRatherThanTheOldOne) {
  source_.Put("a", "1", "good", 5);
  source_.Put("b", "1", "good", 5);
  Rescan();
  Answer("a");
  Answer("b");  // used after a
  source_.Put("a", "2", "good", 5);
  Rescan();
  const auto job = Next();
  ASSERT_TRUE(job);
  EXPECT_EQ((*Ask("a")->scene)->version, "1");
  Finish(*job);
  EXPECT_EQ((*Ask("a")->scene)->version, "2");
  EXPECT_THAT(InMemory(), ElementsAre("a"));
}

TEST_F(BudgetTest, WhereBothVersionsDoNotFitTheOldOneGoesFirst) {
  source_.Put("a", "1", "good", 6);
  Rescan();
  Answer("a");
  source_.Put("a", "2", "good", 6);
  Rescan();
  const auto job = Next();
  ASSERT_TRUE(job);
  EXPECT_EQ(resident_, 0u);
  const auto asked = Ask("a");
  EXPECT_FALSE(asked->answered);
  Finish(*job);
  EXPECT_EQ((*asked->scene)->version, "2");
}

TEST_F(BudgetTest, AtTheStartNothingGoesForAnother) {
  for (const char* scene : {"a", "b", "c"}) source_.Put(scene, "1", "good", 4);
  source_.Put("b", "2", "bad", 4);
  Rescan();
  table_.LoadWhatFits(clock_.Now());
  RunLoads();
  EXPECT_EQ(table_.Stats().counts.evictions, 0u);
  EXPECT_EQ(table_.Stats().counts.loads, 2u);
  EXPECT_TRUE(table_.is_settled());
  EXPECT_EQ(resident_, 8u);
}

}  // namespace
}  // namespace treeline::repository
