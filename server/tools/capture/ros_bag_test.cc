// Which topics are taken, and what is said where something is missing.
#include "server/tools/capture/ros_bag.h"

#include <algorithm>
#include <numbers>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "common/dataset/dataset.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/capture/recording_writer.h"
#include "server/tools/capture/testing_ros_captures.h"

namespace treeline::capture {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr int kFrames = 6;

class RosBagTest : public testing::Test {
 protected:
  static const TrueScene& Scene() {
    static const TrueScene* const scene = new TrueScene(MakeTrueScene(kFrames));
    return *scene;
  }

  // Without the topics whose names begin so.
  absl::StatusOr<Capture> Open(const RosRecorder& recorder,
                               const OpenOptions& options = {},
                               const std::vector<std::string>& without = {}) {
    std::vector<bag::TestingMessage> messages = RosMessages(Scene(), recorder);
    std::erase_if(messages, [&](const bag::TestingMessage& message) {
      return std::ranges::any_of(without, [&](const std::string& topic) {
        return message.topic.rfind(topic, 0) == 0;
      });
    });
    const std::string path = folder_.Path(std::to_string(count_++) + ".mcap");
    bag::WriteMcapBag(messages, "zstd", path);
    return OpenRosBag(path, options);
  }
  std::string ErrorOf(const RosRecorder& recorder, const OpenOptions& options,
                      const std::vector<std::string>& without = {}) {
    const auto capture = Open(recorder, options, without);
    EXPECT_EQ(capture.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(capture.status().message());
  }

  const base::TestingFolder folder_;
  int count_ = 0;
};

TEST_F(RosBagTest, SaysWhatItTook) {
  const auto capture = Open({});
  ASSERT_TRUE(capture.ok()) << capture.status();
  EXPECT_EQ(capture->frames.size(), static_cast<size_t>(kFrames));
  EXPECT_THAT(capture->notes,
              ElementsAre("colour: /camera/color/image_raw, rgb8; camera: "
                          "/camera/color/camera_info",
                          "depth: /camera/depth/image_raw, 16UC1",
                          "poses: /tf, frame camera_color_optical_frame in "
                          "map"));
}

TEST_F(RosBagTest, WhatIsMissingIsSaidWithWhatIsThere) {
  EXPECT_THAT(ErrorOf({}, {}, {"/tf"}),
              HasSubstr("nothing tells where the camera was"));
  EXPECT_THAT(ErrorOf({.poses = "odometry"}, {}, {"/tf_static"}),
              HasSubstr("/odom tells where base_link is, but nothing where the "
                        "camera's frame camera_color_optical_frame is on it"));
  const std::string no_color = ErrorOf({}, {}, {"/camera/color/image"});
  EXPECT_THAT(no_color, HasSubstr("there are no colour pictures"));
  EXPECT_THAT(no_color,
              HasSubstr("/camera/depth/image_raw: 6 depth maps, 16UC1"));
  const std::string no_info =
      ErrorOf({}, {}, {"/camera/color/camera_info", "/camera/depth"});
  EXPECT_THAT(no_info, HasSubstr("--camera-info"));
}

TEST_F(RosBagTest, TopicsThatAreNotThereAreErrors) {
  for (const auto& [set, flag] :
       std::vector<std::pair<std::string RosOptions::*, std::string>>{
           {&RosOptions::color_topic, "with colour pictures"},
           {&RosOptions::depth_topic, "with depth"},
           {&RosOptions::camera_info, "of type sensor_msgs/CameraInfo"},
           {&RosOptions::depth_camera_info, "of type sensor_msgs/CameraInfo"},
           {&RosOptions::pose_topic, "of poses"}}) {
    OpenOptions options;
    options.ros.*set = "/nowhere";
    EXPECT_THAT(
        ErrorOf({}, options),
        AllOf(HasSubstr("there is no topic /nowhere"), HasSubstr(flag)));
  }
  OpenOptions options;
  options.ros.world_frame = "mars";
  EXPECT_THAT(ErrorOf({}, options), HasSubstr("in mars"));
}

TEST_F(RosBagTest, DepthCanBeLeftOut) {
  OpenOptions options;
  options.ros.depth_topic = "none";
  const auto capture = Open({}, options);
  ASSERT_TRUE(capture.ok()) << capture.status();
  EXPECT_FALSE(capture->pictures->Load(0)->depth.has_value());
}

TEST_F(RosBagTest, FramesBeyondThePosesAreLeftOut) {
  std::vector<bag::TestingMessage> messages = RosMessages(Scene(), {});
  // The last transforms: of the last picture, and the one half-way before.
  for (int i = 0; i < 2; ++i) {
    const auto last = std::ranges::find(messages.rbegin(), messages.rend(),
                                        "/tf", &bag::TestingMessage::topic);
    messages.erase(std::next(last).base());
  }
  bag::WriteMcapBag(messages, "", folder_.Path("a.mcap"));
  const auto capture = OpenRosBag(folder_.Path("a.mcap"), {});
  ASSERT_TRUE(capture.ok()) << capture.status();
  EXPECT_EQ(capture->frames.size(), static_cast<size_t>(kFrames - 1));
  EXPECT_THAT(capture->left_out.Lines(),
              ElementsAre(HasSubstr("1 frame: there is no pose at its time")));
}

TEST_F(RosBagTest, ABrokenRecordingIsReadAsFarAsItGoes) {
  WriteRosMcap(Scene(), folder_.Path("a.mcap"));
  std::string bytes = base::ReadFile(folder_.Path("a.mcap")).value();
  const size_t at = 2 * bytes.size() / 3;
  bytes[at] = static_cast<char>(bytes[at] ^ 0x55);
  ASSERT_TRUE(base::WriteFileAtomically(folder_.Path("a.mcap"), bytes).ok());
  const auto capture = OpenRosBag(folder_.Path("a.mcap"), {});
  ASSERT_TRUE(capture.ok()) << capture.status();
  EXPECT_GE(capture->frames.size(), 1U);
  EXPECT_LT(capture->frames.size(), static_cast<size_t>(kFrames));
  EXPECT_THAT(capture->notes, Contains(HasSubstr("the recording is broken")));
}

// A depth camera beside the colour camera: where it is comes from /tf_static,
// also when the pictures are turned upright.
TEST_F(RosBagTest, DepthThatIsNotRegisteredKeepsItsPlace) {
  const geometry::Rigid3 color_from_depth{
      geometry::Rotation3::FromAxisAngle({0, 0.01, 0}), {-0.015, 0.002, 0}};
  auto capture = Open({.color_from_depth = color_from_depth});
  ASSERT_TRUE(capture.ok()) << capture.status();
  const WriteOptions options = {.folder = folder_.Path("out"),
                                .source = "test"};
  const auto written =
      WriteRecording(*std::move(capture), options, {}, std::stop_token());
  ASSERT_TRUE(written.ok()) << written.status();
  const auto dataset =
      dataset::Dataset::Open({.uri = "7scenes:" + options.folder});
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  const geometry::PoseError error = geometry::ErrorBetween(
      dataset->calibration().color_from_depth, color_from_depth);
  EXPECT_LT(error.translation_m, 1e-9);
  EXPECT_LT(error.rotation_rad, 1e-9);
}

// Not registered, and nothing says where it is: no depth is better than depth
// beside its place.
TEST_F(RosBagTest, DepthWhosePlaceIsNotKnownIsAnError) {
  const geometry::Rigid3 beside{{}, {0.1, 0, 0}};
  EXPECT_THAT(ErrorOf({.poses = "pose", .color_from_depth = beside}, {},
                      {"/tf_static"}),
              HasSubstr("/camera/depth/image_raw is not registered to colour"));
}

}  // namespace
}  // namespace treeline::capture
