#include "client/bench/workload.h"

#include <grpcpp/impl/codegen/proto_utils.h>
#include <unistd.h>

#include <filesystem>
#include <set>
#include <string>

#include "common/base/file.h"
#include "common/image/decode.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline::bench {
namespace {

using ::testing::HasSubstr;

class WorkloadTest : public testing::Test {
 protected:
  static constexpr int kFrames = 5;

  void SetUp() override {
    std::filesystem::create_directories(root_);
    image::ColorImage color{.width = 8, .height = 6, .rgb = {}};
    color.rgb.assign(8 * 6 * 3, 77);
    const image::DepthImage depth{
        .width = 8, .height = 6, .values = std::vector<uint16_t>(48, 1500)};
    std::string list;
    for (int i = 0; i < kFrames; ++i) {
      const std::string stem = "f" + std::to_string(i);
      Put(stem + ".color.jpg", image::EncodeJpeg(color, 90).value());
      Put(stem + ".depth.png", image::EncodeDepthPng(depth).value());
      list += stem + "\n";
    }
    Put("f0.pose.txt", "1 0 0 4 0 1 0 5 0 0 1 6 0 0 0 1");
    Put("test.txt", list);
  }
  void TearDown() override { std::filesystem::remove_all(root_); }

  void Put(const std::string& name, const std::string& bytes) const {
    ASSERT_TRUE(base::WriteFileAtomically(root_ + "/" + name, bytes).ok());
  }

  WorkloadOptions Options() const {
    WorkloadOptions options;
    options.scenes = {SceneFrames::Parse("room=" + root_).value()};
    options.seed = 3;
    return options;
  }

  static v1::LocalizeRequest RequestOf(const WorkItem& item) {
    grpc::Slice bytes;
    EXPECT_TRUE(item.request.DumpToSingleSlice(&bytes).ok());
    v1::LocalizeRequest request;
    EXPECT_TRUE(
        request.ParseFromArray(bytes.begin(), static_cast<int>(bytes.size())));
    return request;
  }

  const std::string root_ =
      testing::TempDir() + "/workload-" + std::to_string(getpid());
};

TEST_F(WorkloadTest, EveryFrameInEverySceneAndEncoding) {
  WorkloadOptions options = Options();
  options.scenes.push_back(SceneFrames::Parse("lab=" + root_).value());
  options.encodings = {FrameEncoding::Parse("file").value(),
                       FrameEncoding::Parse("raw+raw").value()};
  const auto items = LoadWorkload(options);
  ASSERT_TRUE(items.ok()) << items.status();
  std::set<std::string> names;
  for (const WorkItem& item : *items) {
    names.insert(item.scene + item.stem + item.encoding);
    EXPECT_EQ(RequestOf(item).scene(), item.scene);
    EXPECT_EQ(RequestOf(item).options().seed(), 3u);
    EXPECT_EQ(item.world_from_camera.has_value(), item.stem == "f0");
  }
  EXPECT_EQ(names.size(), 2u * kFrames * 2u);
  EXPECT_EQ(items->size(), names.size());
}

TEST_F(WorkloadTest, EncodingsAreWhatTheySay) {
  const auto frame_as = [&](const char* encoding) {
    WorkloadOptions options = Options();
    options.encodings = {FrameEncoding::Parse(encoding).value()};
    options.max_frames = 1;
    return RequestOf(LoadWorkload(options).value().front()).frame();
  };
  EXPECT_EQ(image::SniffFormat(frame_as("file").color().encoded()),
            image::ImageFormat::kJpeg);
  EXPECT_EQ(image::SniffFormat(frame_as("png").color().encoded()),
            image::ImageFormat::kPng);
  EXPECT_EQ(image::SniffFormat(frame_as("jpeg").color().encoded()),
            image::ImageFormat::kJpeg);
  EXPECT_EQ(frame_as("raw").color().rgb8().data().size(), 8u * 6u * 3u);
  EXPECT_EQ(image::SniffFormat(frame_as("raw").depth().png()),
            image::ImageFormat::kPng);
  EXPECT_EQ(frame_as("jpeg+raw").depth().raw().data().size(), 8u * 6u * 2u);
  EXPECT_FALSE(frame_as("jpeg+none").has_depth());
}

TEST_F(WorkloadTest, FewFramesAreSpreadOverTheList) {
  WorkloadOptions options = Options();
  options.max_frames = 2;
  const auto items = LoadWorkload(options);
  std::set<std::string> stems;
  for (const WorkItem& item : *items) stems.insert(item.stem);
  EXPECT_EQ(stems, (std::set<std::string>{"f0", "f2"}));
}

TEST_F(WorkloadTest, WhatIsNotThereIsNamed) {
  Put("test.txt", "f0\nnone\n");
  EXPECT_THAT(std::string(LoadWorkload(Options()).status().message()),
              HasSubstr("none"));
}

TEST(SceneFrames, NamesAPlaceAndAList) {
  const auto with_list = SceneFrames::Parse("room=/a/b,/c.txt").value();
  EXPECT_EQ(with_list.scene, "room");
  EXPECT_EQ(with_list.root, "/a/b");
  EXPECT_EQ(with_list.list, "/c.txt");
  EXPECT_EQ(SceneFrames::Parse("room=/a").value().list, "/a/test.txt");
  for (const char* bad : {"", "room", "room=", "=/a", "room=,list"}) {
    EXPECT_EQ(SceneFrames::Parse(bad).status().code(),
              absl::StatusCode::kInvalidArgument)
        << bad;
  }
}

TEST(FrameEncoding, NamesBothImages) {
  EXPECT_EQ(FrameEncoding::Parse("jpeg").value().Name(), "jpeg+png");
  EXPECT_EQ(FrameEncoding::Parse("raw+none").value().Name(), "raw+none");
  for (const char* bad : {"", "bmp", "raw+jpeg", "raw+raw+raw"}) {
    EXPECT_FALSE(FrameEncoding::Parse(bad).ok()) << bad;
  }
}

}  // namespace
}  // namespace treeline::bench
