#include "server/tools/shrink.h"

#include <filesystem>
#include <memory>

#include "common/base/file.h"
#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/keyframes/keyframe_map.h"
#include "server/core/training/quantize_forest.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::tools {
namespace {

using testing::HasSubstr;

// A chain of splits: a leaf after the other, of 2 to 60 samples.
forest::Forest SomeForest() {
  base::Random random(1, 0);
  training::GrownTree tree;
  constexpr uint32_t kLeaves = 2000;
  for (uint32_t i = 0; i < kLeaves; ++i) {
    if (i + 1 < kLeaves) {
      tree.nodes.push_back(forest::Node::Split(
          {static_cast<int16_t>(random.NextBelow(100)), 5, 0, 1}, 7, 2));
    }
    tree.nodes.push_back(forest::Node::Leaf(i));
    training::GrownLeaf leaf;
    leaf.mean_in_world = {random.NextUnit(), random.NextUnit(), 1};
    leaf.count = 2 + random.NextBelow(random.NextBelow(59) + 1);
    for (int8_t& value : leaf.descriptor.values) {
      value = static_cast<int8_t>(random.NextBelow(16));
    }
    tree.leaves.push_back(leaf);
  }
  return training::QuantizeForest({tree});
}

class ShrinkTest : public testing::Test {
 protected:
  ShrinkTest() : forest_(SomeForest()), features_(200) {
    base::Random random(2, 0);
    for (keyframes::KeyframeFeature& feature : features_) {
      for (uint8_t& value : feature.descriptor) {
        value = static_cast<uint8_t>(random.NextBelow(200));
      }
    }
    info_.method = "universal";
    info_.options = {{"min-kept-samples", "1"}};
  }

  std::unique_ptr<const forest::ModelFile> Opened(const std::string& file) {
    const std::string path = folder_ / "model.treeline";
    EXPECT_TRUE(base::WriteFileAtomically(path, file).ok());
    auto model = forest::ModelFile::Open(path);
    EXPECT_TRUE(model.ok()) << model.status();
    return *std::move(model);
  }
  std::unique_ptr<const forest::ModelFile> Model() {
    const forest::ModelExtraBytes extra{
        forest::ModelExtra::kKeyframeFeatures,
        {reinterpret_cast<const char*>(features_.data()),
         features_.size() * sizeof(features_[0])}};
    return Opened(
        *forest::EncodeModel(info_, {forest_.View()}, std::span(&extra, 1)));
  }

  TestFolder folder_;
  forest::Forest forest_;
  std::vector<keyframes::KeyframeFeature> features_;
  forest::ModelInfo info_;
};

TEST_F(ShrinkTest, WhatIsSmallEnoughLosesNothing) {
  const auto model = Model();
  const auto shrunk = ShrinkModel(*model, model->info().file_bytes);
  ASSERT_TRUE(shrunk.ok()) << shrunk.status();
  EXPECT_EQ(shrunk->min_kept_samples, 1u);
  EXPECT_EQ(shrunk->feature_step, 1);
  EXPECT_EQ(Opened(shrunk->file)->info().checksum, model->info().checksum);
}

TEST_F(ShrinkTest, SmallLeavesGoAndFeaturesBecomeCoarse) {
  const auto model = Model();
  const uint64_t limit = model->info().file_bytes / 2;
  const auto shrunk = ShrinkModel(*model, limit);
  ASSERT_TRUE(shrunk.ok()) << shrunk.status();
  EXPECT_LE(shrunk->file.size(), limit);
  EXPECT_GT(shrunk->min_kept_samples, 5u);
  const auto small = Opened(shrunk->file);
  EXPECT_LT(small->info().leaves, model->info().leaves);
  for (const forest::LeafPayload& leaf : small->forest().payloads) {
    EXPECT_GE(leaf.count, shrunk->min_kept_samples);
  }
  const auto features = *small->Extra<keyframes::KeyframeFeature>(
      forest::ModelExtra::kKeyframeFeatures);
  ASSERT_EQ(features.size(), features_.size());
  for (size_t i = 0; i < features.size(); ++i) {
    for (size_t k = 0; k < 128; ++k) {
      EXPECT_LE(
          std::abs(features[i].descriptor[k] - features_[i].descriptor[k]),
          shrunk->feature_step / 2);
    }
  }
  EXPECT_THAT(
      small->info().options,
      testing::Contains(testing::Pair(
          "min-kept-samples", std::to_string(shrunk->min_kept_samples))));
  // Shrunk again to the same, it stays what it is.
  EXPECT_EQ(ShrinkModel(*small, limit)->file, shrunk->file);
}

TEST_F(ShrinkTest, SaysHowSmallItCanBe) {
  const auto none = ShrinkModel(*Model(), 100);
  EXPECT_TRUE(absl::IsInvalidArgument(none.status()));
  EXPECT_THAT(none.status().ToString(), HasSubstr("the least is"));
  info_.method = "points-lines";
  const auto lines = ShrinkModel(*Model(), 100);
  EXPECT_THAT(lines.status().ToString(), HasSubstr("method points-lines"));
  const auto model = Model();
  const auto packed = ShrinkModel(*model, model->info().file_bytes);
  EXPECT_EQ(Opened(packed->file)->info().leaves, model->info().leaves);
}

TEST_F(ShrinkTest, PartsAndBasesAreRefused) {
  info_.part.emplace();
  info_.part->trees = 5;
  info_.part->frames_checksum = "0123456789abcdef";
  const auto part = ShrinkModel(*Model(), 1 << 30);
  EXPECT_TRUE(absl::IsFailedPrecondition(part.status()));
  EXPECT_THAT(part.status().ToString(), HasSubstr("treeline merge"));
  info_.part.reset();
  forest_ = training::SplitsOf(forest_.View());
  EXPECT_TRUE(
      absl::IsFailedPrecondition(ShrinkModel(*Model(), 1 << 30).status()));
}

}  // namespace
}  // namespace treeline::tools
