#include "server/core/recognition/scene_descriptor.h"

#include <unistd.h>

#include <cstdio>
#include <string>

#include "common/base/file.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/forest/model_file.h"
#include "server/core/recognition/appearance_words.h"

namespace treeline::recognition {
namespace {

using testing::HasSubstr;

SceneDescriptor Example() {
  SceneDescriptor descriptor;
  descriptor.Add(std::vector<uint32_t>{0, 63, 64, kWords - 1, 64});
  descriptor.Add(std::vector<uint32_t>{777});
  return descriptor;
}

TEST(SceneDescriptorTest, KnowsItsWords) {
  const SceneDescriptor descriptor = Example();
  EXPECT_EQ(descriptor.images(), 2u);
  EXPECT_EQ(descriptor.bits()[0], (uint64_t{1} << 63) | 1);
  EXPECT_EQ(descriptor.bits()[1], 1u);
  EXPECT_DOUBLE_EQ(descriptor.Fill(), 5.0 / kWords);
}

TEST(SceneDescriptorTest, MergingIsAddingBoth) {
  SceneDescriptor first;
  first.Add(std::vector<uint32_t>{0, 63, 64, kWords - 1});
  SceneDescriptor second;
  second.Add(std::vector<uint32_t>{777, 0});
  first.Merge(second);
  EXPECT_EQ(first, Example());
}

TEST(SceneDescriptorTest, ReadsBackWhatWasWritten) {
  const absl::StatusOr<SceneDescriptor> read =
      SceneDescriptor::Parse(Example().Serialize());
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(*read, Example());
}

TEST(SceneDescriptorTest, FlippedBitsAreRefused) {
  const std::string good = Example().Serialize();
  for (size_t i = 0; i < good.size(); i += i < 64 ? 1 : 4099) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ (1 << (i % 8)));
    const absl::Status status = SceneDescriptor::Parse(bad).status();
    EXPECT_EQ(status.code(), i < 4 ? absl::StatusCode::kUnimplemented
                                   : absl::StatusCode::kDataLoss)
        << "byte " << i;
  }
}

TEST(SceneDescriptorTest, OtherLengthsAreDataLoss) {
  const std::string good = Example().Serialize();
  for (const std::string& bad :
       {std::string(), good.substr(0, 15), good.substr(0, 16),
        good.substr(0, good.size() - 1), good + "x"}) {
    EXPECT_EQ(SceneDescriptor::Parse(bad).status().code(),
              absl::StatusCode::kDataLoss)
        << bad.size();
  }
}

class ReadSceneDescriptorTest : public testing::Test {
 protected:
  void SetUp() override {
    forest_.nodes = {forest::Node::Leaf(0)};
    forest_.tree_offsets = {0, 1};
    forest_.descriptors.resize(1);
    forest_.payloads.resize(1);
    info_.method = "rgbd";
    info_.calibration.color =
        *camera::Camera::Parse("PINHOLE,525,525,320,240", 640, 480);
    info_.calibration.depth = info_.calibration.color;
  }
  void TearDown() override { std::remove(path_.c_str()); }

  void Write(std::span<const forest::ModelExtraBytes> extras) {
    ASSERT_TRUE(
        forest::WriteModel(path_, info_, {forest_.View()}, extras).ok());
  }

  const std::string path_ = testing::TempDir() + "/read_scene_descriptor_" +
                            std::to_string(getpid()) + ".treeline";
  forest::Forest forest_{};
  forest::ModelInfo info_{};
};

TEST_F(ReadSceneDescriptorTest, FindsItAmongTheSections) {
  const std::string bytes = Example().Serialize();
  const forest::ModelExtraBytes extras[] = {
      {forest::ModelExtra::kKeyframes, ""},
      {forest::ModelExtra::kSceneDescriptor, bytes}};
  Write(extras);
  const absl::StatusOr<SceneDescriptor> read = ReadSceneDescriptor(path_);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(*read, Example());
  // What else is in the file need not be intact.
  std::string file = *base::ReadFile(path_);
  const size_t info = file.find("rgbd");
  ASSERT_NE(info, std::string::npos);
  file[info] = 'x';
  ASSERT_TRUE(base::WriteFileAtomically(path_, file).ok());
  EXPECT_TRUE(ReadSceneDescriptor(path_).ok());
  // The descriptor, the last section, must be.
  for (const size_t from_end : {1u, 2u, 5u, 10u}) {
    std::string damaged = file;
    damaged[damaged.size() - from_end] ^= 1;
    ASSERT_TRUE(base::WriteFileAtomically(path_, damaged).ok());
    const absl::Status status = ReadSceneDescriptor(path_).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << from_end;
    EXPECT_THAT(std::string(status.message()), HasSubstr(path_));
  }
}

TEST_F(ReadSceneDescriptorTest, ModelsWithoutOneAreNotFound) {
  Write({});
  EXPECT_EQ(ReadSceneDescriptor(path_).status().code(),
            absl::StatusCode::kNotFound);
}

TEST_F(ReadSceneDescriptorTest, MissingFilesAreNotFound) {
  EXPECT_EQ(ReadSceneDescriptor(path_ + ".absent").status().code(),
            absl::StatusCode::kNotFound);
}

TEST_F(ReadSceneDescriptorTest, TruncatedFilesAreDataLoss) {
  const std::string bytes = Example().Serialize();
  const forest::ModelExtraBytes extra{forest::ModelExtra::kSceneDescriptor,
                                      bytes};
  Write({&extra, 1});
  const std::string good = *base::ReadFile(path_);
  for (const size_t length :
       {size_t{0}, size_t{63}, size_t{100}, good.size() / 2, good.size() - 1}) {
    ASSERT_TRUE(base::WriteFileAtomically(path_, good.substr(0, length)).ok());
    EXPECT_EQ(ReadSceneDescriptor(path_).status().code(),
              absl::StatusCode::kDataLoss)
        << length;
  }
}

TEST_F(ReadSceneDescriptorTest, ADescriptorTooLongIsDataLoss) {
  const std::string bytes = Example().Serialize() + "more";
  const forest::ModelExtraBytes extra{forest::ModelExtra::kSceneDescriptor,
                                      bytes};
  Write({&extra, 1});
  EXPECT_EQ(ReadSceneDescriptor(path_).status().code(),
            absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace treeline::recognition
