#include "server/core/keyframes/distinct_matches.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "common/base/random.h"
#include "gtest/gtest.h"
#include "server/core/keyframes/testing_keyframe_model.h"

namespace treeline::keyframes {
namespace {

constexpr uint32_t kKeyframes = 40;
constexpr uint32_t kFeaturesOfKeyframe = 50;
constexpr float kSpacing_m = 4;

// Keyframes 4 m apart. Those of the first half have features of their own;
// those of the second half all look alike but for some noise.
class DistinctMatchesTest : public testing::Test {
 protected:
  explicit DistinctMatchesTest(
      features::SiftKind kind = features::SiftKind::kFast) {
    base::Random random(1, 0);
    std::vector<KeyframeFeature> room(kFeaturesOfKeyframe);
    for (KeyframeFeature& feature : room) Draw(feature, random);
    for (uint32_t k = 0; k < kKeyframes; ++k) {
      for (uint32_t i = 0; i < kFeaturesOfKeyframe; ++i) {
        KeyframeFeature feature;
        if (LooksAlike(k)) {
          feature = room[i];
          for (uint8_t& v : feature.descriptor) {
            v = static_cast<uint8_t>(v + random.NextBelow(2));
          }
        } else {
          Draw(feature, random);
        }
        feature.keyframe = k;
        feature.position_in_world = {kSpacing_m * static_cast<float>(k),
                                     0.02F * static_cast<float>(i), 0};
        features_.push_back(feature);
      }
    }
    forest::ModelInfo info;
    info.keyframe_sift = kind;
    auto model =
        ModelWithKeyframes({.records = std::vector<KeyframeRecord>(kKeyframes),
                            .points = {},
                            .features = features_},
                           info);
    EXPECT_TRUE(model.ok()) << model.status();
    model_ = std::move(*model);
    map_ = *KeyframeMap::Read(*model_);
  }

  static bool LooksAlike(uint32_t keyframe) {
    return keyframe >= kKeyframes / 2;
  }
  static void Draw(KeyframeFeature& feature, base::Random& random) {
    for (uint8_t& v : feature.descriptor) {
      v = static_cast<uint8_t>(random.NextBelow(91));
    }
  }

  // The share of distinct ones among the matches of a frame that shows all of
  // keyframe k, with its own noise.
  double ShareOf(uint32_t k) const {
    base::Random random(2 + k, 0);
    features::SiftFeatures frame;
    for (uint32_t i = 0; i < kFeaturesOfKeyframe; ++i) {
      features::SiftDescriptor descriptor;
      descriptor.values = features_[k * kFeaturesOfKeyframe + i].descriptor;
      for (uint8_t& v : descriptor.values) {
        v = static_cast<uint8_t>(v + random.NextBelow(9));
      }
      frame.keypoints.push_back({{10.0 * i, 7}, 1, 0, 0});
      frame.descriptors.push_back(descriptor);
    }
    const std::vector<size_t> asked = {k};
    const std::vector<KeyframeMatch> matches =
        MatchKeyframes(frame, map_, asked, 0.8);
    EXPECT_GT(matches.size(), kFeaturesOfKeyframe / 2);
    return static_cast<double>(CountDistinct(frame, map_, matches)) /
           static_cast<double>(matches.size());
  }

  std::vector<KeyframeFeature> features_;
  std::unique_ptr<const forest::ModelFile> model_;
  KeyframeMap map_;
};

TEST_F(DistinctMatchesTest, PlacesOfTheirOwnAreToldByNearlyAllMatches) {
  EXPECT_GT(ShareOf(0), 0.95);
  EXPECT_GT(ShareOf(13), 0.95);
}

TEST_F(DistinctMatchesTest, PlacesThatLookAlikeAreToldByHardlyAny) {
  EXPECT_LT(ShareOf(kKeyframes / 2), 0.3);
  EXPECT_LT(ShareOf(kKeyframes - 1), 0.3);
}

TEST_F(DistinctMatchesTest, NothingIsMatchedWithoutMatches) {
  EXPECT_EQ(CountDistinct({}, map_, {}), 0u);
}

class DistinctWithoutIndexTest : public DistinctMatchesTest {
 protected:
  DistinctWithoutIndexTest()
      : DistinctMatchesTest(features::SiftKind::kOpenCv) {}
};

TEST_F(DistinctWithoutIndexTest, AllAreDistinctWhereNoneCanBeLookedUp) {
  EXPECT_EQ(ShareOf(kKeyframes - 1), 1);
}

// One thing seen by several keyframes is one thing.
TEST_F(DistinctMatchesTest, NeighboursThatSeeTheSameDoNotCount) {
  for (KeyframeFeature& feature : features_) {
    feature.position_in_world[0] /= 200;
  }
  forest::ModelInfo info;
  info.keyframe_sift = features::SiftKind::kFast;
  model_ =
      *ModelWithKeyframes({.records = std::vector<KeyframeRecord>(kKeyframes),
                           .points = {},
                           .features = features_},
                          info);
  map_ = *KeyframeMap::Read(*model_);
  EXPECT_EQ(ShareOf(kKeyframes - 1), 1);
}

}  // namespace
}  // namespace treeline::keyframes
