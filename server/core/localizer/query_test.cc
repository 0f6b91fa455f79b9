#include "server/core/localizer/query.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::localizer {
namespace {

using testing::HasSubstr;

constexpr int kWidth = 16;
constexpr int kHeight = 8;

camera::Camera CameraOf(double focal) {
  return camera::Camera::Parse("PINHOLE," + std::to_string(focal) + "," +
                                   std::to_string(focal) + ",8,4",
                               kWidth, kHeight)
      .value();
}

forest::ModelInfo Info() {
  forest::ModelInfo info;
  info.method = "rgbd";
  info.calibration.color = CameraOf(20);
  info.calibration.depth = CameraOf(21);
  info.calibration.pose_sensor = camera::RgbdSensor::kDepth;
  return info;
}

image::Frame GrayFrame(uint8_t brightness) {
  image::Frame frame;
  frame.color = {kWidth, kHeight,
                 std::vector<uint8_t>(3 * kWidth * kHeight, brightness)};
  return frame;
}

TEST(QueryCalibrationTest, IsTheScenesWhereTheFrameHasNone) {
  for (const DepthUse use : {DepthUse::kIgnored, DepthUse::kRequired}) {
    EXPECT_EQ(QueryCalibration(GrayFrame(0), Info(), use), Info().calibration);
  }
}

TEST(QueryCalibrationTest, TakesTheFramesCamerasAndTheScenesPoseSensor) {
  image::Frame frame = GrayFrame(0);
  frame.calibration.emplace();
  frame.calibration->color = CameraOf(30);
  frame.calibration->depth = CameraOf(31);
  const camera::RgbdCalibration both =
      QueryCalibration(frame, Info(), DepthUse::kRequired);
  EXPECT_EQ(both.color, CameraOf(30));
  EXPECT_EQ(both.depth, CameraOf(31));
  EXPECT_EQ(both.pose_sensor, camera::RgbdSensor::kDepth);
  // The frame's depth camera means nothing to who ignores depth, or has none.
  const camera::RgbdCalibration color =
      QueryCalibration(frame, Info(), DepthUse::kIgnored);
  EXPECT_EQ(color.color, CameraOf(30));
  EXPECT_EQ(color.depth, CameraOf(21));
  EXPECT_EQ(color.pose_sensor, camera::RgbdSensor::kDepth);
  EXPECT_EQ(QueryCalibration(frame, Info(), DepthUse::kWhereGiven).depth,
            CameraOf(21));
  frame.depth = image::DepthImage{kWidth, kHeight,
                                  std::vector<uint16_t>(kWidth * kHeight)};
  EXPECT_EQ(QueryCalibration(frame, Info(), DepthUse::kWhereGiven).depth,
            CameraOf(31));
}

TEST(CheckFrameTest, WantsDepthOnlyWhereItIsUsed) {
  const camera::RgbdCalibration& calibration = Info().calibration;
  image::Frame frame = GrayFrame(0);
  EXPECT_TRUE(CheckFrame(frame, calibration, DepthUse::kIgnored, "rgb").ok());
  EXPECT_TRUE(
      CheckFrame(frame, calibration, DepthUse::kWhereGiven, "universal").ok());
  const absl::Status missing =
      CheckFrame(frame, calibration, DepthUse::kRequired, "rgbd");
  EXPECT_EQ(missing.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(missing.ToString(), HasSubstr("(rgbd) needs a depth image"));
  frame.depth = image::DepthImage{kWidth, kHeight,
                                  std::vector<uint16_t>(kWidth * kHeight)};
  EXPECT_TRUE(CheckFrame(frame, calibration, DepthUse::kRequired, "rgbd").ok());
}

TEST(CheckFrameTest, ComparesImagesWithTheirCameras) {
  const camera::RgbdCalibration& calibration = Info().calibration;
  image::Frame frame = GrayFrame(0);
  frame.depth = image::DepthImage{4, 2, std::vector<uint16_t>(8)};
  for (const DepthUse use : {DepthUse::kRequired, DepthUse::kWhereGiven}) {
    EXPECT_THAT(CheckFrame(frame, calibration, use, "rgbd").ToString(),
                HasSubstr("the depth image has 4 x 2"));
  }
  frame.color = {5, 2, std::vector<uint8_t>(30)};
  EXPECT_THAT(
      CheckFrame(frame, calibration, DepthUse::kIgnored, "rgb").ToString(),
      HasSubstr("the colour image has 5 x 2"));
}

TEST(QueryTest, SeesItsOwnFrameWhateverTheMemoryHeld) {
  QueryScratch scratch;
  const camera::RgbdCalibration calibration = Info().calibration;
  for (const uint8_t brightness : {uint8_t{10}, uint8_t{200}}) {
    const image::Frame frame = GrayFrame(brightness);
    Query query(frame, calibration, DepthUse::kIgnored, {}, scratch);
    EXPECT_EQ(query.pyramid().level(0).gray[0], brightness);
    EXPECT_EQ(query.image().data()[0], brightness);
  }
}

TEST(QueryTest, HidesTheDepthOfAMethodThatIgnoresIt) {
  QueryScratch scratch;
  const camera::RgbdCalibration calibration = Info().calibration;
  image::Frame frame = GrayFrame(0);
  frame.depth.emplace();
  const LocalizeOptions options;
  EXPECT_EQ(
      Query(frame, calibration, DepthUse::kIgnored, options, scratch).depth(),
      nullptr);
  EXPECT_EQ(
      Query(frame, calibration, DepthUse::kRequired, options, scratch).depth(),
      &*frame.depth);
}

TEST(QueryTest, IsCancelledOnceItsStopWasRequested) {
  QueryScratch scratch;
  const camera::RgbdCalibration calibration = Info().calibration;
  const image::Frame frame = GrayFrame(0);
  std::stop_source stop;
  const LocalizeOptions options{.stop = stop.get_token()};
  const Query query(frame, calibration, DepthUse::kIgnored, options, scratch);
  EXPECT_TRUE(query.CheckStop().ok());
  stop.request_stop();
  EXPECT_EQ(query.CheckStop().code(), absl::StatusCode::kCancelled);
}

TEST(StageTimerTest, AddsToWhatTheStageTookBefore) {
  double stage_ms = 5;
  { const StageTimer timer(stage_ms); }
  EXPECT_GE(stage_ms, 5);
}

}  // namespace
}  // namespace treeline::localizer
