#include "server/core/recognition/appearance_words.h"

#include <algorithm>
#include <set>

#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::recognition {
namespace {

// Tiles of random colours, `tile` pixels wide.
image::ColorImage Tiles(int width, int height, int tile, uint64_t seed) {
  image::ColorImage image{width, height, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      base::Random random(seed,
                          static_cast<uint64_t>(y / tile * 1000 + x / tile));
      for (int c = 0; c < 3; ++c) {
        image.rgb.push_back(static_cast<uint8_t>(random.NextBelow(200)));
      }
    }
  }
  return image;
}

std::vector<uint32_t> WordsOf(const image::ColorImage& image) {
  AppearanceWords words;
  return words.Extract(image);
}

// The share of the words of `a` that are among those of `b`.
double SharedWords(const image::ColorImage& a, const image::ColorImage& b) {
  const std::vector<uint32_t> words = WordsOf(a);
  const std::vector<uint32_t> others = WordsOf(b);
  const std::set<uint32_t> known(others.begin(), others.end());
  const auto shared = std::ranges::count_if(
      words, [&](uint32_t word) { return known.contains(word); });
  return static_cast<double>(shared) / static_cast<double>(words.size());
}

TEST(AppearanceWordsTest, AreNumbersOfTheVocabularyFernByFern) {
  const std::vector<uint32_t> words = WordsOf(Tiles(640, 480, 40, 1));
  ASSERT_GT(words.size(), 100u * kFerns);
  ASSERT_EQ(words.size() % kFerns, 0u);
  for (size_t i = 0; i < words.size(); ++i) {
    EXPECT_EQ(words[i] / kWordsPerFern, i % kFerns);
  }
}

TEST(AppearanceWordsTest, AreTheSameAgainWithTheSameScratch) {
  AppearanceWords words;
  const image::ColorImage image = Tiles(640, 480, 40, 1);
  const std::vector<uint32_t> first = words.Extract(image);
  words.Extract(Tiles(320, 200, 16, 2));
  EXPECT_EQ(words.Extract(image), first);
}

// Golden: a change here makes the descriptors of all models worthless, and
// must come with another kVocabulary.
TEST(AppearanceWordsTest, KeepTheirMeaning) {
  const std::vector<uint32_t> words = WordsOf(Tiles(640, 480, 40, 1));
  uint64_t hash = 0;
  for (const uint32_t word : words) hash = base::MixBits(hash + word + 1);
  EXPECT_EQ(hash, 5573438390418063884u) << "of " << words.size() << " words";
}

TEST(AppearanceWordsTest, DifferentImagesShareFewOfThem) {
  EXPECT_LT(SharedWords(Tiles(640, 480, 40, 1), Tiles(640, 480, 40, 2)), 0.05);
}

TEST(AppearanceWordsTest, SurviveAnotherSizeOfTheImage) {
  EXPECT_GT(SharedWords(Tiles(640, 480, 40, 1), Tiles(1280, 960, 80, 1)), 0.95);
}

TEST(AppearanceWordsTest, SurviveHalfTheExposure) {
  const image::ColorImage bright = Tiles(640, 480, 40, 1);
  image::ColorImage dark = bright;
  for (uint8_t& value : dark.rgb) value = static_cast<uint8_t>(value * 4 / 5);
  EXPECT_GT(SharedWords(bright, dark), 0.2);
}

TEST(AppearanceWordsTest, AWallHasNone) {
  EXPECT_THAT(WordsOf(Tiles(640, 480, 640, 1)), testing::IsEmpty());
}

TEST(AppearanceWordsTest, ImagesOfAnySizeAreFine) {
  EXPECT_THAT(WordsOf({}), testing::IsEmpty());
  for (const auto& [width, height] :
       {std::pair{1, 1}, {1, 500}, {500, 1}, {3, 7}, {161, 159}, {4000, 30}}) {
    WordsOf(Tiles(width, height, 2, 3));
  }
}

}  // namespace
}  // namespace treeline::recognition
