#include "server/core/keyframes/keyframe_index.h"

#include <algorithm>
#include <vector>

#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::keyframes {
namespace {

using features::SiftDescriptor;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr size_t kKeyframes = 60;
constexpr size_t kFeatures = 250;

std::vector<SiftDescriptor> RandomDescriptors(size_t count, uint64_t seed) {
  base::Random random(seed, 0);
  std::vector<SiftDescriptor> descriptors(count);
  for (SiftDescriptor& d : descriptors) {
    for (uint8_t& v : d.values) v = static_cast<uint8_t>(random.NextBelow(91));
  }
  return descriptors;
}

// Each value off by up to `most`.
SiftDescriptor Disturbed(const SiftDescriptor& descriptor, int most,
                         base::Random& random) {
  SiftDescriptor disturbed;
  for (size_t i = 0; i < disturbed.values.size(); ++i) {
    const int off =
        static_cast<int>(random.NextBelow(static_cast<uint32_t>(2 * most + 1)));
    disturbed.values[i] = static_cast<uint8_t>(
        std::clamp(descriptor.values[i] + off - most, 0, 255));
  }
  return disturbed;
}

KeyframeIndex IndexOf(const features::SiftDescriptorView& descriptors,
                      std::span<const size_t> first) {
  return *KeyframeIndex::Create(LearnWords(descriptors, first), descriptors,
                                first);
}

KeyframeIndex IndexOf(const std::vector<SiftDescriptor>& descriptors) {
  std::vector<size_t> first;
  for (size_t k = 0; k <= kKeyframes; ++k) first.push_back(k * kFeatures);
  return IndexOf({.data = descriptors[0].values.data(),
                  .stride_bytes = sizeof(SiftDescriptor),
                  .size = descriptors.size()},
                 first);
}

TEST(KeyframeIndexTest, FindsTheKeyframesThatAFrameSharesFeaturesWith) {
  const auto known = RandomDescriptors(kKeyframes * kFeatures, 1);
  const KeyframeIndex index = IndexOf(known);
  base::Random random(2, 0);
  for (size_t k = 0; k < kKeyframes; k += 7) {
    // A quarter of the features of one keyframe, an eighth of another's, and as
    // many of none.
    const size_t other = (k + 11) % kKeyframes;
    std::vector<SiftDescriptor> frame = RandomDescriptors(90, 3 + k);
    for (size_t i = 0; i < 60; ++i) {
      frame.push_back(Disturbed(known[k * kFeatures + i], 9, random));
    }
    for (size_t i = 0; i < 30; ++i) {
      frame.push_back(Disturbed(known[other * kFeatures + i], 9, random));
    }
    EXPECT_THAT(index.MostSimilar(frame, 2), ElementsAre(k, other));
    EXPECT_THAT(index.MostSimilar(frame, 1), ElementsAre(k));
  }
}

TEST(KeyframeIndexTest, IsAFunctionOfTheDescriptors) {
  const auto known = RandomDescriptors(kKeyframes * kFeatures, 1);
  const auto frame = RandomDescriptors(200, 5);
  EXPECT_EQ(IndexOf(known).MostSimilar(frame, kKeyframes),
            IndexOf(known).MostSimilar(frame, kKeyframes));
}

TEST(KeyframeIndexTest, WithoutFeaturesNothingIsSimilar) {
  const auto frame = RandomDescriptors(10, 1);
  EXPECT_THAT(KeyframeIndex().MostSimilar(frame, 3), IsEmpty());
  const std::vector<size_t> first = {0, 0, 0};
  EXPECT_THAT(IndexOf({}, first).MostSimilar(frame, 3), IsEmpty());
  const std::vector<size_t> one = {0, 0, 1};
  const KeyframeIndex index =
      IndexOf({.data = frame[4].values.data(), .size = 1}, one);
  EXPECT_THAT(index.MostSimilar(std::span(frame).subspan(4, 1), 3),
              ElementsAre(1));
  EXPECT_THAT(index.MostSimilar({}, 3), IsEmpty());
}

TEST(KeyframeIndexTest, WordsOfOtherFeaturesAreDataLoss) {
  const auto known = RandomDescriptors(4, 1);
  const features::SiftDescriptorView view = {.data = known[0].values.data(),
                                             .size = known.size()};
  const std::vector<size_t> first = {0, 4};
  const KeyframeWords words = LearnWords(view, first);
  EXPECT_TRUE(KeyframeIndex::Create(words, view, first).ok());
  const auto code_of = [&](const KeyframeWords& broken) {
    return KeyframeIndex::Create(broken, view, first).status().code();
  };
  KeyframeWords broken = words;
  broken.word_of.pop_back();
  EXPECT_EQ(code_of(broken), absl::StatusCode::kDataLoss);
  broken = words;
  broken.word_of[2] = 1000;
  EXPECT_EQ(code_of(broken), absl::StatusCode::kDataLoss);
  broken = words;
  broken.means.emplace_back();
  EXPECT_EQ(code_of(broken), absl::StatusCode::kDataLoss);
  EXPECT_EQ(code_of({}), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace treeline::keyframes
