#include "server/tools/capture/recording_writer.h"

#include <memory>
#include <utility>

#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "common/dataset/dataset.h"
#include "common/image/decode.h"
#include "common/image/quarter_turn.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/training/box_room_recording.h"
#include "server/tools/capture/common_camera.h"
#include "server/tools/capture/conventions.h"
#include "server/tools/capture/testing_captures.h"

namespace treeline::capture {
namespace {

using testing::HasSubstr;

class MemoryPictures final : public PictureSource {
 public:
  explicit MemoryPictures(std::vector<Pictures> pictures)
      : pictures_(std::move(pictures)) {}
  absl::StatusOr<Pictures> Load(size_t frame) override {
    return pictures_[frame];
  }

 private:
  const std::vector<Pictures> pictures_;
};

// The frames of a scene, as they were taken by a phone that was turned.
Capture CaptureOf(const TrueScene& scene, image::QuarterTurn turn) {
  Capture capture;
  capture.format = "memory";
  std::vector<Pictures> pictures;
  const geometry::Rigid3 turned_from_camera{image::TurnedFromCamera(turn), {}};
  for (size_t i = 0; i < scene.frames.size(); ++i) {
    const image::Frame frame = image::Turned(scene.frames[i], turn);
    capture.frames.push_back(
        {"frame", image::Turned(scene.calibration.color, turn),
         scene.world_from_camera[i] * turned_from_camera.Inverse()});
    pictures.push_back({frame.color, "", frame.depth});
  }
  capture.pictures = std::make_unique<MemoryPictures>(std::move(pictures));
  return capture;
}

class RecordingWriterTest : public testing::Test {
 protected:
  dataset::Dataset Write(Capture capture, WriteOptions options = {}) const {
    options.folder = folder_.Path("out");
    const auto written =
        WriteRecording(std::move(capture), options, {}, std::stop_token());
    EXPECT_TRUE(written.ok()) << written.status();
    return *dataset::Dataset::Open({.uri = "7scenes:" + options.folder});
  }
  const base::TestingFolder folder_;
};

TEST_F(RecordingWriterTest, PicturesOnTheirSideAreTurnedUpright) {
  const TrueScene scene = MakeTrueScene(6);
  const dataset::Dataset dataset =
      Write(CaptureOf(scene, image::QuarterTurn::kCounterclockwise));
  EXPECT_EQ(dataset.calibration().color, scene.calibration.color);
  EXPECT_EQ(dataset.calibration().depth, scene.calibration.depth);
  for (int i = 0; i < dataset.size(); ++i) {
    const auto index = static_cast<size_t>(i);
    const geometry::PoseError error = geometry::ErrorBetween(
        *dataset.frame(i).world_from_camera, scene.world_from_camera[index]);
    EXPECT_LT(error.translation_m, 1e-6);
    EXPECT_LT(error.rotation_rad, 1e-6);
    EXPECT_EQ(dataset.Load(i)->depth->values,
              scene.frames[index].depth->values);
  }
  EXPECT_THAT(*base::ReadFile(folder_.Path("out/recording.txt")),
              HasSubstr("turned clockwise by 90 degrees"));
}

TEST_F(RecordingWriterTest, TheTurnCanBeKept) {
  const TrueScene scene = MakeTrueScene(3);
  const dataset::Dataset dataset = Write(
      CaptureOf(scene, image::QuarterTurn::kClockwise), {.upright = false});
  EXPECT_EQ(dataset.calibration().color.width(), 192);
}

// A phone that focuses: each frame has another focal length. What is written
// is what one camera would have seen.
TEST_F(RecordingWriterTest, FramesOfALensThatFocusesAreSeenByOneCamera) {
  const TrueScene scene = MakeTrueScene(3);
  Capture capture = CaptureOf(scene, image::QuarterTurn::kNone);
  const camera::Camera wider =
      *camera::Camera::Parse("PINHOLE,190,191,127.25,95.75", 256, 192);
  const camera::Camera narrower =
      *camera::Camera::Parse("PINHOLE,210,211,127.25,95.75", 256, 192);
  camera::RgbdCalibration calibration = scene.calibration;
  std::vector<Pictures> pictures;
  const std::vector<geometry::Rigid3> poses = training::BoxRoomPoses(3);
  for (size_t i = 0; i < 3; ++i) {
    calibration.color =
        i == 0 ? wider : (i == 1 ? scene.calibration.color : narrower);
    calibration.depth = *ScaledTo(calibration.color, {64, 48});
    capture.frames[i].color = calibration.color;
    const image::Frame frame = training::RenderBoxRoom(calibration, poses[i]);
    pictures.push_back({frame.color, "", frame.depth});
  }
  capture.pictures = std::make_unique<MemoryPictures>(std::move(pictures));
  const dataset::Dataset dataset = Write(std::move(capture));
  EXPECT_EQ(dataset.calibration().color, scene.calibration.color);
  const auto frame = dataset.Load(2);
  ASSERT_TRUE(frame.ok()) << frame.status();
  // The middle of what both cameras see: colour as rendered with the common
  // camera, up to resampling and JPEG; depth from the nearest pixel.
  double difference = 0;
  int count = 0;
  for (int y = 40; y < 150; ++y) {
    for (int x = 40; x < 210; ++x) {
      const auto at = static_cast<size_t>(3 * (y * 256 + x));
      difference +=
          std::abs(frame->color.rgb[at] - scene.frames[2].color.rgb[at]);
      ++count;
    }
  }
  EXPECT_LT(difference / count, 4);
  const auto& depth = frame->depth->values;
  const auto& true_depth = scene.frames[2].depth->values;
  int near = 0;
  int all = 0;
  for (size_t i = 64 * 12; i < 64 * 36; ++i) {
    if (i % 64 < 12 || i % 64 > 52) continue;
    ++all;
    near += std::abs(depth[i] - true_depth[i]) < 60 ? 1 : 0;
  }
  EXPECT_GT(near, 0.95 * all);
}

TEST_F(RecordingWriterTest, EveryNthFrameAndBothLists) {
  const TrueScene scene = MakeTrueScene(20);
  const WriteOptions options{.every = 2};
  Capture capture = CaptureOf(scene, image::QuarterTurn::kNone);
  EXPECT_EQ(FramesToWrite(capture, options), 10);
  const dataset::Dataset dataset = Write(std::move(capture), options);
  EXPECT_EQ(dataset.size(), 10);
  const auto subset =
      dataset::Dataset::Open({.uri = "7scenes:" + folder_.Path("out"),
                              .frame_list = folder_.Path("out/test.txt")});
  ASSERT_TRUE(subset.ok()) << subset.status();
  EXPECT_EQ(subset->size(), 2);
}

TEST_F(RecordingWriterTest, OptionsAreChecked) {
  for (const WriteOptions& options :
       {WriteOptions{}, WriteOptions{.folder = "x", .every = 0},
        WriteOptions{.folder = "x", .max_side_px = 3}}) {
    EXPECT_FALSE(options.Validate().ok());
  }
}

TEST(ConventionsTest, EachAxisCanBeUp) {
  for (const auto& [name, axis] :
       {std::pair<const char*, geometry::Vec3>{"x", {1, 0, 0}},
        {"-x", {-1, 0, 0}},
        {"y", {0, 1, 0}},
        {"-y", {0, -1, 0}},
        {"z", {0, 0, 1}},
        {"-z", {0, 0, -1}}}) {
    const auto rotation = ZUpFromAxis(name);
    ASSERT_TRUE(rotation.ok());
    EXPECT_LT(geometry::Norm(*rotation * axis - geometry::Vec3{0, 0, 1}), 1e-12)
        << name;
  }
  EXPECT_FALSE(ZUpFromAxis("w").ok());
}

}  // namespace
}  // namespace treeline::capture
