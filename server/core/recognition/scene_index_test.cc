#include "server/core/recognition/scene_index.h"

#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/recognition/appearance_words.h"

namespace treeline::recognition {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// `count` words that are `seed`'s.
std::vector<uint32_t> Words(uint64_t seed, int count) {
  base::Random random(seed, 0);
  std::vector<uint32_t> words;
  for (int i = 0; i < count; ++i) words.push_back(random.NextBelow(kWords));
  return words;
}

SceneDescriptor Described(std::span<const uint32_t> words) {
  SceneDescriptor descriptor;
  descriptor.Add(words);
  return descriptor;
}

std::vector<std::string> Names(const std::vector<SceneScore>& ranking) {
  std::vector<std::string> names;
  for (const SceneScore& score : ranking) names.push_back(score.scene);
  return names;
}

TEST(SceneIndexTest, RanksTheSceneThatHasTheWordsFirst) {
  SceneIndex index;
  for (uint64_t s = 0; s < 200; ++s) {
    index.Set(absl::StrCat("scene-", s), Described(Words(s, 1000)));
  }
  EXPECT_EQ(index.size(), 200u);
  for (const uint64_t s : {0u, 63u, 64u, 130u, 199u}) {
    const std::vector<SceneScore> ranking = index.RankWords(Words(s, 100));
    ASSERT_EQ(ranking.size(), 200u);
    EXPECT_EQ(ranking[0].scene, absl::StrCat("scene-", s));
    // All words are known there, and the scene has few: nothing is by chance.
    EXPECT_NEAR(ranking[0].similarity, 1, 1e-9);
    EXPECT_LT(ranking[1].similarity, 0.1);
    for (size_t i = 1; i < ranking.size(); ++i) {
      EXPECT_GE(ranking[i - 1].similarity, ranking[i].similarity);
      EXPECT_GE(ranking[i].similarity, 0);
    }
  }
}

TEST(SceneIndexTest, RareWordsCountMore) {
  SceneIndex index;
  index.Set("common", Described(std::vector<uint32_t>{1, 2}));
  index.Set("common too", Described(std::vector<uint32_t>{1, 2}));
  index.Set("rare", Described(std::vector<uint32_t>{3, 9}));
  EXPECT_THAT(Names(index.RankWords(std::vector<uint32_t>{1, 3})),
              ElementsAre("rare", "common", "common too"));
}

TEST(SceneIndexTest, ScenesOfManyWordsHaveSomeByChance) {
  SceneIndex index;
  SceneDescriptor large = Described(Words(1, 500000));
  index.Set("large", large);
  index.Set("small", Described(Words(2, 20000)));
  // Half of the words are small's; two in five of any are large's.
  std::vector<uint32_t> query = Words(3, 500);
  const std::vector<uint32_t> of_small = Words(2, 500);
  query.insert(query.end(), of_small.begin(), of_small.end());
  EXPECT_THAT(Names(index.RankWords(query)), ElementsAre("small", "large"));
}

TEST(SceneIndexTest, CandidatesAreRankedAlone) {
  SceneIndex index;
  index.Set("a", Described(Words(1, 10)));
  index.Set("b", Described(Words(2, 10)));
  index.Set("c", Described(Words(3, 10)));
  const std::vector<std::string> candidates = {"c", "unknown", "b"};
  EXPECT_THAT(Names(index.RankWords(Words(2, 10), candidates)),
              ElementsAre("b", "c"));
  EXPECT_THAT(index.RankWords(Words(2, 10), std::vector<std::string>{}),
              IsEmpty());
}

TEST(SceneIndexTest, ReplacingForgetsTheOldWords) {
  SceneIndex index;
  index.Set("a", Described(Words(1, 100)));
  index.Set("b", Described(Words(2, 100)));
  index.Set("a", Described(Words(3, 100)));
  EXPECT_EQ(index.size(), 2u);
  const auto by_old = index.RankWords(Words(1, 100));
  EXPECT_LT(by_old[0].similarity, 0.1);
  EXPECT_EQ(index.RankWords(Words(3, 100))[0].scene, "a");
}

TEST(SceneIndexTest, RemovedScenesLeaveNothingToThoseThatTakeTheirPlace) {
  SceneIndex index;
  index.Set("a", Described(Words(1, 100)));
  EXPECT_TRUE(index.Remove("a"));
  EXPECT_FALSE(index.Remove("a"));
  EXPECT_FALSE(index.Contains("a"));
  EXPECT_THAT(index.RankWords(Words(1, 100)), IsEmpty());
  index.Set("b", Described(Words(2, 100)));
  const auto ranking = index.RankWords(Words(1, 100));
  ASSERT_EQ(ranking.size(), 1u);
  EXPECT_LT(ranking[0].similarity, 0.1);
}

TEST(SceneIndexTest, AFrameWithoutWordsIsLikeNoScene) {
  SceneIndex index;
  index.Set("b", Described(Words(1, 100)));
  index.Set("a", Described(Words(2, 100)));
  image::Frame wall;
  wall.color = {64, 48, std::vector<uint8_t>(3 * 64 * 48, 90)};
  EXPECT_THAT(index.Rank(wall),
              ElementsAre(SceneScore{"a", 0}, SceneScore{"b", 0}));
}

TEST(SceneIndexTest, RanksWhileScenesComeAndGo) {
  SceneIndex index;
  index.Set("kept", Described(Words(0, 100)));
  std::jthread writer([&](const std::stop_token& stop) {
    for (uint64_t i = 0; !stop.stop_requested(); ++i) {
      index.Set(absl::StrCat(i % 100), Described(Words(i + 1, 100)));
      index.Remove(absl::StrCat((i + 50) % 100));
    }
  });
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(index.RankWords(Words(0, 100))[0].scene, "kept");
  }
}

}  // namespace
}  // namespace treeline::recognition
