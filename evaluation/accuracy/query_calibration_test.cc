#include "evaluation/accuracy/query_calibration.h"

#include <fstream>
#include <optional>
#include <string>

#include "common/camera/calibration_json.h"
#include "common/camera/derived_camera.h"
#include "gtest/gtest.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::accuracy {
namespace {

// Of 640 x 480 pixels.
camera::RgbdCalibration EstimatedCalibration() {
  camera::RgbdCalibration calibration;
  calibration.color =
      camera::Camera::Parse("PINHOLE,526,526,320,236", 640, 480).value();
  calibration.depth =
      camera::Camera::Parse("PINHOLE,586,586,320,238", 640, 480).value();
  calibration.color_from_depth.translation = {-0.02, 0, 0};
  calibration.depth_scale = 1.007;
  return calibration;
}

// Of 8 x 6 pixels, as the recordings here.
camera::RgbdCalibration SmallEstimatedCalibration() {
  camera::RgbdCalibration calibration = EstimatedCalibration();
  calibration.color = camera::Camera::Parse("PINHOLE,14,14,4,3", 8, 6).value();
  calibration.depth = camera::Camera::Parse("PINHOLE,15,15,4,3", 8, 6).value();
  return calibration;
}

TEST(QueryCalibration, KeepsTheScenesWhereTheFormatOnlyGuesses) {
  const tools::SmallRecording recording(1, {});
  dataset::DatasetOptions unnamed = recording.options();
  unnamed.color_camera.clear();
  unnamed.depth_camera.clear();
  EXPECT_EQ(
      QueryCalibration(recording.Open(), unnamed, SmallEstimatedCalibration()),
      std::nullopt);
}

TEST(QueryCalibration, TakesANamedCameraAndKeepsOffsetAndScale) {
  const tools::SmallRecording recording(1, {});
  dataset::DatasetOptions only_color = recording.options();
  only_color.depth_camera.clear();
  const camera::RgbdCalibration scene = SmallEstimatedCalibration();
  const std::optional<camera::RgbdCalibration> query =
      QueryCalibration(recording.Open(), only_color, scene);
  ASSERT_TRUE(query.has_value());
  EXPECT_EQ(query->color.fx(), 10);
  EXPECT_EQ(query->depth, scene.depth);
  EXPECT_EQ(query->color_from_depth, scene.color_from_depth);
  EXPECT_EQ(query->depth_scale, scene.depth_scale);
}

TEST(QueryCalibration, KeepsWhatTrainingRefinedOfANamedCamera) {
  const tools::SmallRecording recording(1, {});
  const dataset::Dataset dataset = recording.Open();
  camera::RgbdCalibration refined = dataset.calibration();
  refined.color = camera::WithFocalScaled(refined.color, 1.02).value();
  EXPECT_EQ(QueryCalibration(dataset, recording.options(), refined),
            std::nullopt);
  refined.color = camera::WithFocalScaled(refined.color, 1.02).value();
  EXPECT_TRUE(QueryCalibration(dataset, recording.options(), refined));
}

// The localizer refuses frames whose size is not that of their cameras.
TEST(QueryCalibration, TakesTheCamerasOfPicturesOfAnotherSize) {
  const tools::SmallRecording recording(1, {});
  dataset::DatasetOptions unnamed = recording.options();
  unnamed.color_camera.clear();
  unnamed.depth_camera.clear();
  camera::RgbdCalibration scene = SmallEstimatedCalibration();
  scene.depth = EstimatedCalibration().depth;
  const std::optional<camera::RgbdCalibration> query =
      QueryCalibration(recording.Open(), unnamed, scene);
  ASSERT_TRUE(query.has_value());
  EXPECT_EQ(query->color.fx(), 10);
  EXPECT_EQ(query->depth.fx(), 11);
  EXPECT_EQ(query->color_from_depth, scene.color_from_depth);
  EXPECT_EQ(query->depth_scale, scene.depth_scale);
  // One that says itself what took it knows its own offset, too.
  camera::RgbdCalibration own = recording.Open().calibration();
  own.color_from_depth.translation = {0.01, 0, 0};
  std::ofstream(recording.folder() + "/cameras.json")
      << camera::CalibrationToJson(own);
  const auto stated =
      QueryCalibration(dataset::Dataset::Open(unnamed).value(), unnamed, scene);
  ASSERT_TRUE(stated.has_value());
  EXPECT_EQ(stated->color_from_depth, own.color_from_depth);
}

// A TUM recording of one 8 x 6 frame, whose depth is registered.
class TumRecording {
 public:
  TumRecording() : images_(1, {}) {
    const std::string& folder = images_.folder();
    std::ofstream(folder + "/rgb.txt") << "1.0 seq-01/frame-000000.color.png\n";
    std::ofstream(folder + "/depth.txt")
        << "1.0 seq-01/frame-000000.depth.png\n";
    options.uri = "tum:" + folder;
    options.color_camera = "PINHOLE,12,12,4,3";
  }
  dataset::DatasetOptions options;

 private:
  tools::SmallRecording images_;
};

TEST(QueryCalibration, KeepsTheScenesForARegisteredRecordingOfItsCamera) {
  const TumRecording recording;
  const dataset::Dataset dataset =
      dataset::Dataset::Open(recording.options).value();
  camera::RgbdCalibration scene = dataset.calibration();
  scene.depth_scale = 1.02;
  EXPECT_EQ(QueryCalibration(dataset, recording.options, scene), std::nullopt);
}

TEST(QueryCalibration, TakesTheCamerasOfAnotherRegisteredRecording) {
  const TumRecording recording;
  const dataset::Dataset dataset =
      dataset::Dataset::Open(recording.options).value();
  camera::RgbdCalibration scene = EstimatedCalibration();
  scene.pose_sensor = camera::RgbdSensor::kDepth;
  const std::optional<camera::RgbdCalibration> query =
      QueryCalibration(dataset, recording.options, scene);
  ASSERT_TRUE(query.has_value());
  EXPECT_EQ(query->color.fx(), 12);
  EXPECT_EQ(query->depth, query->color);
  EXPECT_EQ(query->color_from_depth, geometry::Rigid3{});
  EXPECT_EQ(query->depth_scale, scene.depth_scale);
  EXPECT_EQ(query->pose_sensor, camera::RgbdSensor::kDepth);
}

}  // namespace
}  // namespace treeline::accuracy
