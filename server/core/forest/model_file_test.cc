#include "server/core/forest/model_file.h"

#include <unistd.h>
#include <xxhash.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include "common/base/file.h"
#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/forest/model_info_json.h"

namespace treeline::forest {
namespace {

using testing::HasSubstr;

class ModelFileTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        testing::TempDir() + "/model_file_test_" + std::to_string(getpid());
    std::filesystem::create_directories(folder_);
    path_ = folder_ + "/model.treeline";
    forest_.nodes = {Node::Split({-511, 3, 2, 1}, -7, 2), Node::Leaf(0),
                     Node::Leaf(1), Node::Leaf(2)};
    forest_.tree_offsets = {0, 3, 4};
    forest_.descriptors.resize(3);
    forest_.descriptors[1].values[59] = -127;
    forest_.payloads.resize(3);
    forest_.payloads[2] = {{1, 2, 3}, {4, 5, 6, 7, 8, 9}, 10};
    forest_.bounds_min_in_world = {-1.25, 0.1, 1. / 3};
    forest_.bounds_max_in_world = {2, 3, 4};
    info_.method = "rgbd";
    info_.software_version = "1.2.3";
    info_.created_utc = "2026-11-21T09:30:00Z";
    info_.dataset = "7scenes:\"odd\" name \xff";
    info_.seed = 0xffffffffffffffffu;
    info_.options = {{"trees", "2"}, {"a", "b"}};
    info_.calibration.color = *camera::Camera::Parse(
        "OPENCV,526.5,525,319.1,236.2,0.1,-0.2,0.01,0.02", 640, 480);
    info_.calibration.color_from_depth = {
        geometry::Rotation3::FromAxisAngle({0.01, -0.02, 0.03}),
        {-0.025, 1. / 3, 0}};
    info_.calibration.depth_scale = 0.99612345678901234;
    info_.calibration.pose_sensor = camera::RgbdSensor::kDepth;
    info_.training_frames = 3;
    info_.training_samples = 12345678901;
    info_.training_s = 12.5;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string Written() {
    EXPECT_TRUE(WriteModel(path_, info_, {forest_.View()}).ok());
    return *base::ReadFile(path_);
  }
  absl::Status OpenBytes(const std::string& bytes) {
    std::ofstream(path_, std::ios::binary) << bytes;
    return ModelFile::Open(path_).status();
  }

  std::string folder_;
  std::string path_;
  Forest forest_;
  ModelInfo info_;
};

TEST(ModelInfoShutter, IsReadBackAndAbsentWhereItIsGlobal) {
  ModelInfo info;
  EXPECT_EQ(ModelInfoToJson(info).find("shutter"), std::string::npos);
  info.shutter = {.readout_s = 0.0275, .offset_s = -0.0055};
  const std::string text = ModelInfoToJson(info);
  EXPECT_EQ(ModelInfoFromJson(text)->shutter, info.shutter);
  for (const auto& [from, to] :
       {std::pair("0.0275", "0.25"), std::pair("0.0275", "-0.01"),
        std::pair("-0.0055", "0.2")}) {
    std::string wrong = text;
    wrong.replace(wrong.find(from), std::string(from).size(), to);
    EXPECT_EQ(ModelInfoFromJson(wrong).status().code(),
              absl::StatusCode::kDataLoss)
        << to;
  }
}

TEST_F(ModelFileTest, ReadsBackWhatWasWritten) {
  Written();
  const auto model = ModelFile::Open(path_);
  ASSERT_TRUE(model.ok()) << model.status();
  const ForestView& forest = (*model)->forest();
  ASSERT_EQ(forest.nodes.size(), 4u);
  EXPECT_EQ(std::memcmp(forest.nodes.data(), forest_.nodes.data(), 32), 0);
  EXPECT_EQ(forest.trees(), 2);
  EXPECT_EQ(forest.descriptors[1].values[59], -127);
  EXPECT_EQ(forest.payloads[2].covariance[5], 9);
  EXPECT_EQ(forest.bounds_min_in_world, forest_.bounds_min_in_world);
  const ModelInfo& info = (*model)->info();
  EXPECT_EQ(info.method, "rgbd");
  EXPECT_EQ(info.seed, info_.seed);
  EXPECT_EQ(info.options, info_.options);
  EXPECT_EQ(info.calibration.color, info_.calibration.color);
  EXPECT_EQ(info.calibration.depth_scale, info_.calibration.depth_scale);
  EXPECT_EQ(info.calibration.pose_sensor, camera::RgbdSensor::kDepth);
  EXPECT_EQ(info.calibration.color_from_depth.translation,
            info_.calibration.color_from_depth.translation);
  EXPECT_EQ(info.training_samples, 12345678901);
  EXPECT_EQ(info.nodes, 4);
  EXPECT_EQ(info.leaves, 3);
  EXPECT_EQ(info.file_bytes, std::filesystem::file_size(path_));
  EXPECT_EQ(info.checksum.size(), 16u);
}

// Enough leaves that sections become shorter.
TEST_F(ModelFileTest, PackedSectionsComeBackToTheBit) {
  base::Random random(5, 0);
  forest_ = {};
  for (uint32_t i = 0; i < 2000; ++i) {
    if (i % 2 == 0) {
      forest_.nodes.push_back(Node::Split(
          {static_cast<int16_t>(random.NextBelow(700)), -7, 2, 1}, -3, 2));
    }
    forest_.nodes.push_back(Node::Leaf(i));
    if (i % 2 == 1) {
      forest_.tree_offsets.push_back(
          static_cast<uint32_t>(forest_.nodes.size()));
    }
    forest_.descriptors.emplace_back().values[i % 60] =
        static_cast<int8_t>(random.NextBelow(64));
    forest_.payloads.push_back(
        {{static_cast<uint16_t>(random.NextBelow(65536)), 65535, 0},
         {1, 0x8002, 3, 4, 5, 6},
         static_cast<uint16_t>(2 + i % 3)});
  }
  forest_.bounds_max_in_world = {2, 3, 4};
  const std::string descriptor(50000, 'd');
  ASSERT_TRUE(WriteModel(path_, info_, {forest_.View(), forest_.View()},
                         std::vector<ModelExtraBytes>{
                             {ModelExtra::kSceneDescriptor, descriptor},
                             {ModelExtra::kKeyframePoints, "x"}})
                  .ok());
  const auto model = ModelFile::Open(path_);
  ASSERT_TRUE(model.ok()) << model.status();
  for (const size_t f : {0u, 1u}) {
    const ForestView& forest = (*model)->forest(f);
    ASSERT_EQ(forest.nodes.size(), forest_.nodes.size());
    EXPECT_EQ(std::memcmp(forest.nodes.data(), forest_.nodes.data(),
                          forest.nodes.size_bytes()),
              0);
    EXPECT_EQ(std::memcmp(forest.descriptors.data(), forest_.descriptors.data(),
                          forest.descriptors.size_bytes()),
              0);
    EXPECT_EQ(std::memcmp(forest.payloads.data(), forest_.payloads.data(),
                          forest.payloads.size_bytes()),
              0);
  }
  const ModelInfo& info = (*model)->info();
  EXPECT_LT(info.file_bytes, info.memory_bytes / 4);
  EXPECT_EQ(*ReadModelMemoryBytes(path_), info.memory_bytes);
  EXPECT_EQ(*ReadModelExtra(path_, ModelExtra::kSceneDescriptor, 50000),
            descriptor);
  EXPECT_TRUE(absl::IsDataLoss(
      ReadModelExtra(path_, ModelExtra::kSceneDescriptor, 49999).status()));
  // Whatever bytes it loses, and whatever bits change, it is found.
  const std::string good = *base::ReadFile(path_);
  for (size_t i = 0; i < good.size(); i += 997) {
    EXPECT_TRUE(absl::IsDataLoss(OpenBytes(good.substr(0, i)))) << i;
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ 4);
    EXPECT_FALSE(OpenBytes(bad).ok()) << i;
  }
}

// What a budget counts with must be true.
TEST_F(ModelFileTest, AFileThatTakesOtherMemoryThanItSaysIsCorrupt) {
  std::string file = Written();
  const auto with_memory = [&](uint64_t bytes) {
    std::string changed = file;
    std::memcpy(changed.data() + 32, &bytes, sizeof(bytes));
    const uint64_t zero = 0;
    std::memcpy(changed.data() + 24, &zero, sizeof(zero));
    const uint64_t checksum =
        XXH3_64bits_withSeed(changed.data() + 64, changed.size() - 64,
                             XXH3_64bits(changed.data(), 64));
    std::memcpy(changed.data() + 24, &checksum, sizeof(checksum));
    return OpenBytes(changed);
  };
  EXPECT_TRUE(with_memory(file.size()).ok());
  for (const uint64_t bytes : {uint64_t{0}, uint64_t{file.size() - 1},
                               uint64_t{file.size() + 1}, ~uint64_t{0}}) {
    EXPECT_TRUE(absl::IsDataLoss(with_memory(bytes))) << bytes;
  }
}

TEST_F(ModelFileTest, KnowsWhoseFeaturesItsKeyframesHave) {
  const std::string old = Written();
  // What older versions wrote has no word of it.
  EXPECT_EQ(old.find("\"keyframes\""), std::string::npos);
  EXPECT_EQ((*ModelFile::Open(path_))->info().keyframe_sift,
            features::SiftKind::kOpenCv);
  info_.keyframe_sift = features::SiftKind::kFast;
  const std::string text = ModelInfoToJson(info_);
  EXPECT_EQ(ModelInfoFromJson(text)->keyframe_sift, features::SiftKind::kFast);
  std::string unknown = text;
  unknown.replace(unknown.find("\"fast\""), 6, "\"slow\"");
  EXPECT_EQ(ModelInfoFromJson(unknown).status().code(),
            absl::StatusCode::kDataLoss);
}

TEST_F(ModelFileTest, AConfidenceLacksNoEvidenceThatEveryVersionKnew) {
  info_.confidence.emplace();
  info_.confidence->weights.fill(2);
  const auto without = [&](const std::string& name) {
    std::string text = ModelInfoToJson(info_);
    const size_t at = text.find("\"" + name + "\"");
    EXPECT_NE(at, std::string::npos);
    return ModelInfoFromJson(text.replace(at, name.size() + 2, "\"other\""));
  };
  EXPECT_EQ(without("correlation").status().code(),
            absl::StatusCode::kDataLoss);
  const auto earlier = without("sharpness");
  ASSERT_TRUE(earlier.ok()) << earlier.status();
  EXPECT_EQ(earlier->confidence->weights.back(), 0);
  EXPECT_EQ(earlier->confidence->weights.front(), 2);
}

TEST_F(ModelFileTest, WhatFeaturesSayOfFocalLengthsMayBeWidened) {
  info_.confidence.emplace();
  // As older versions wrote it, and read it.
  EXPECT_EQ(ModelInfoToJson(info_).find("focal_sigma_scale"),
            std::string::npos);
  EXPECT_EQ(
      ModelInfoFromJson(ModelInfoToJson(info_))->confidence->focal_sigma_scale,
      1);
  info_.confidence->focal_sigma_scale = 3.5;
  const std::string text = ModelInfoToJson(info_);
  EXPECT_EQ(ModelInfoFromJson(text)->confidence, info_.confidence);
  for (const char* const bad : {"0.5", "-3.5", "1e7", "null"}) {
    std::string corrupt = text;
    corrupt.replace(corrupt.find("3.5"), 3, bad);
    EXPECT_EQ(ModelInfoFromJson(corrupt).status().code(),
              absl::StatusCode::kDataLoss)
        << bad;
  }
}

TEST_F(ModelFileTest, FlippedBitsAreDataLoss) {
  const std::string good = Written();
  for (size_t i = 0; i < good.size(); i += i < 256 ? 1 : 13) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ (1 << (i % 8)));
    const absl::Status status = OpenBytes(bad);
    EXPECT_TRUE(
        status.code() == absl::StatusCode::kDataLoss ||
        // A larger version number is a newer file's.
        (i >= 8 && i < 12 && status.code() == absl::StatusCode::kUnimplemented))
        << "byte " << i << ": " << status;
  }
}

TEST_F(ModelFileTest, EveryTruncationIsDataLoss) {
  const std::string good = Written();
  for (size_t length = 0; length < good.size(); length += 7) {
    EXPECT_EQ(OpenBytes(good.substr(0, length)).code(),
              absl::StatusCode::kDataLoss)
        << length;
  }
  EXPECT_EQ(OpenBytes(good + "x").code(), absl::StatusCode::kDataLoss);
}

// The file is only read: what others write to it afterwards changes nothing.
// (A mapping would show other bytes, or end the process with SIGBUS.)
TEST_F(ModelFileTest, AnOpenModelOutlivesWhatHappensToItsFile) {
  const std::string good = Written();
  const auto model = ModelFile::Open(path_);
  ASSERT_TRUE(model.ok()) << model.status();
  const auto expect_unchanged = [&](const char* after) {
    const ForestView& forest = (*model)->forest();
    EXPECT_TRUE(forest.Validate().ok()) << after;
    EXPECT_EQ(std::memcmp(forest.nodes.data(), forest_.nodes.data(),
                          forest.nodes.size_bytes()),
              0)
        << after;
    EXPECT_EQ(forest.payloads[2].covariance[5], 9) << after;
  };
  std::ofstream(path_, std::ios::binary) << std::string(good.size(), 'x');
  expect_unchanged("written over");
  std::filesystem::resize_file(path_, 0);
  expect_unchanged("truncated");
  std::filesystem::remove(path_);
  expect_unchanged("deleted");
}

TEST_F(ModelFileTest, ReadsOneSectionAlone) {
  ASSERT_TRUE(WriteModel(path_, info_, {forest_.View()},
                         std::vector<ModelExtraBytes>{
                             {ModelExtra::kSceneDescriptor, "descriptor"}})
                  .ok());
  const auto read = [&](ModelExtra kind, uint64_t max_bytes) {
    return ReadModelExtra(path_, kind, max_bytes);
  };
  EXPECT_EQ(read(ModelExtra::kSceneDescriptor, 10).value(), "descriptor");
  EXPECT_TRUE(absl::IsDataLoss(read(ModelExtra::kSceneDescriptor, 9).status()));
  EXPECT_TRUE(absl::IsNotFound(read(ModelExtra::kKeyframes, 10).status()));
  std::filesystem::resize_file(path_, 100);
  EXPECT_TRUE(
      absl::IsDataLoss(read(ModelExtra::kSceneDescriptor, 10).status()));
}

TEST_F(ModelFileTest, NamesTheFileAndTheReason) {
  EXPECT_THAT(
      OpenBytes(std::string(1000, 'a')).ToString(),
      testing::AllOf(HasSubstr(path_), HasSubstr("not a Treeline model file")));
  std::string newer = Written();
  newer[8] = static_cast<char>(kModelFormatVersion + 1);
  const absl::Status status = OpenBytes(newer);
  EXPECT_EQ(status.code(), absl::StatusCode::kUnimplemented);
  EXPECT_THAT(status.ToString(), HasSubstr("newer than this software"));
}

TEST_F(ModelFileTest, AMissingFileIsNotFound) {
  EXPECT_EQ(ModelFile::Open(folder_ + "/none").status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(ModelFile::Open(folder_).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST_F(ModelFileTest, AFailedWriteLeavesTheOldFileAndNothingElse) {
  const std::string good = Written();
  Forest broken = forest_;
  broken.nodes[1] = Node::Leaf(99);
  EXPECT_FALSE(WriteModel(path_, info_, {broken.View()}).ok());
  EXPECT_EQ(*base::ReadFile(path_), good);
  EXPECT_FALSE(
      WriteModel(folder_ + "/no/folder/m", info_, {forest_.View()}).ok());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_),
                          std::filesystem::directory_iterator()),
            1);
}

}  // namespace
}  // namespace treeline::forest
