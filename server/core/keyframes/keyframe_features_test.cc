#include "server/core/keyframes/keyframe_features.h"

#include <limits>
#include <string>
#include <vector>

#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/keyframes/testing_keyframe_model.h"

namespace treeline::keyframes {
namespace {

using testing::ElementsAre;

// A model of one leaf with three keyframes, of which the second has no
// features.
class KeyframeFeaturesTest : public testing::Test {
 protected:
  KeyframeFeaturesTest() {
    base::Random random(1, 0);
    for (uint32_t i = 0; i < 40; ++i) {
      KeyframeFeature feature;
      feature.keyframe = i < 25 ? 0 : 2;
      feature.position_in_world = {static_cast<float>(i), 0, 0};
      for (uint8_t& v : feature.descriptor) {
        v = static_cast<uint8_t>(random.NextBelow(200));
      }
      features_.push_back(feature);
    }
    records_.resize(3);
  }

  absl::StatusOr<KeyframeMap> Read() {
    auto model = ModelWithKeyframes(
        {.records = records_, .points = {}, .features = features_}, info_);
    if (!model.ok()) return model.status();
    model_ = std::move(*model);
    return KeyframeMap::Read(*model_);
  }

  // What a frame would show of some of the features, a little changed.
  features::SiftFeatures FrameWith(const std::vector<size_t>& shown) const {
    features::SiftFeatures frame;
    for (const size_t i : shown) {
      features::SiftDescriptor descriptor;
      descriptor.values = features_[i].descriptor;
      ++descriptor.values[i];
      frame.keypoints.push_back({{static_cast<double>(i), 7}, 1, 0, 0});
      frame.descriptors.push_back(descriptor);
    }
    return frame;
  }

  forest::ModelInfo info_;
  std::vector<KeyframeRecord> records_;
  std::vector<KeyframeFeature> features_;
  std::unique_ptr<const forest::ModelFile> model_;
};

TEST_F(KeyframeFeaturesTest, EachKeyframeHasItsOwn) {
  const auto map = Read();
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->features(0).size(), 25u);
  EXPECT_EQ(map->features(1).size(), 0u);
  EXPECT_EQ(map->features(2).size(), 15u);
  EXPECT_EQ(map->features(2)[0].position_in_world[0], 25);
}

TEST_F(KeyframeFeaturesTest, MatchesCarryThePointAndThePixel) {
  const auto map = Read();
  ASSERT_TRUE(map.ok()) << map.status();
  const std::vector<size_t> all = {0, 1, 2};
  const std::vector<KeyframeMatch> matches =
      MatchKeyframes(FrameWith({3, 30, 8}), *map, all, 0.5);
  ASSERT_EQ(matches.size(), 3u);
  for (const KeyframeMatch& match : matches) {
    EXPECT_EQ(match.point_in_world.x, match.pixel.x);
    EXPECT_LT(match.ratio, 0.1);
  }
  // Keyframes that are not asked do not answer.
  EXPECT_EQ(
      MatchKeyframes(FrameWith({3, 30, 8}), *map, std::span(all).last(1), 0.5)
          .size(),
      1u);
}

TEST_F(KeyframeFeaturesTest, TheKeyframesMostAlikeStandFirst) {
  const auto map = Read();
  ASSERT_TRUE(map.ok()) << map.status();
  const features::SiftFeatures frame =
      FrameWith({0, 1, 2, 3, 4, 5, 26, 27, 28, 29, 30, 31, 32});
  EXPECT_THAT(MostSimilarKeyframes(frame, *map, 3, 0.5), ElementsAre(2, 0));
  EXPECT_THAT(MostSimilarKeyframes(frame, *map, 1, 0.5), ElementsAre(2));
}

TEST_F(KeyframeFeaturesTest, TheKeyframesMostAlikeStandFirstInTheIndexToo) {
  info_.keyframe_sift = features::SiftKind::kFast;
  const auto map = Read();
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->sift_kind(), features::SiftKind::kFast);
  const features::SiftFeatures frame =
      FrameWith({0, 26, 27, 28, 29, 30, 31, 32});
  EXPECT_THAT(MostSimilarKeyframes(frame, *map, 3, 0.5), ElementsAre(2, 0));
}

TEST_F(KeyframeFeaturesTest, BrokenFeaturesAreDataLoss) {
  features_[39].keyframe = 3;
  EXPECT_EQ(Read().status().code(), absl::StatusCode::kDataLoss);
  features_[39].keyframe = 0;
  EXPECT_EQ(Read().status().code(), absl::StatusCode::kDataLoss);
  features_[39].keyframe = 2;
  features_[7].position_in_world[1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(Read().status().code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace treeline::keyframes
