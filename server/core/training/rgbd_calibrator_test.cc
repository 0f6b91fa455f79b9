#include "server/core/training/rgbd_calibrator.h"

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/training/box_room_recording.h"

namespace treeline::training {
namespace {

class RgbdCalibratorTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + "/rgbd_calibrator_test_" +
              std::to_string(getpid());
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  absl::StatusOr<dataset::Dataset> Record(const camera::RgbdCalibration& truth,
                                          int frames) {
    WriteBoxRoomRecording(folder_, truth, BoxRoomPoses(frames));
    return Open(truth.pose_sensor);
  }

  dataset::DatasetOptions Options(camera::RgbdSensor pose_sensor) {
    dataset::DatasetOptions options;
    options.uri = "7scenes:" + folder_;
    options.color_camera = "PINHOLE,145,145,100,75";
    options.depth_camera = "PINHOLE,145,145,100,75";
    if (pose_sensor == camera::RgbdSensor::kColor) {
      options.pose_file = folder_ + "/poses.txt";
    }
    return options;
  }

  absl::StatusOr<dataset::Dataset> Open(camera::RgbdSensor pose_sensor) {
    return dataset::Dataset::Open(Options(pose_sensor));
  }

  std::string folder_;
};

// The box room has no occlusions, so surfaces alone decide here. Depth is
// exact but for rounding to a millimetre (0.3 mm rms): with thousands of
// points the offset comes out within a millimetre or two, unless the fit
// trades it for one of its other unknowns.
TEST_F(RgbdCalibratorTest, FindsOffsetAndScaleFromColorPoses) {
  camera::RgbdCalibration truth = BoxRoomCalibration();
  truth.color_from_depth = {
      geometry::Rotation3::FromAxisAngle({0.01, -0.015, 0.005}),
      {-0.03, 0.01, 0.005}};
  truth.depth_scale = 0.99;
  const auto dataset = Record(truth, 24);
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  const auto report = CalibrateRgbd(*dataset, {.frames = 24}, true, {});
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_GT(report->surface_rms_before_m, 0.015);
  EXPECT_LT(report->surface_rms_after_m, 0.005);
  EXPECT_NEAR(report->calibration.depth_scale, 0.99, 0.003);
  const geometry::Vec3 t = report->calibration.color_from_depth.translation;
  EXPECT_NEAR(t.x, -0.03, 0.006);
  EXPECT_NEAR(t.y, 0.01, 0.006);
  EXPECT_NEAR(t.z, 0.005, 0.006);
}

TEST_F(RgbdCalibratorTest, LeavesATrueCalibrationAlone) {
  const camera::RgbdCalibration truth = BoxRoomCalibration();
  const auto dataset = Record(truth, 24);
  ASSERT_TRUE(dataset.ok());
  const auto report = CalibrateRgbd(*dataset, {.frames = 24}, true, {});
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_NEAR(report->calibration.depth_scale, 1, 0.002);
  EXPECT_LT(geometry::Norm(report->calibration.color_from_depth.translation),
            0.004);
}

// A camera held on its side has its lenses one above the other, five standard
// deviations from what is expected beforehand: exact poses tell.
TEST_F(RgbdCalibratorTest, FindsAnOffsetThatIsNotExpected) {
  camera::RgbdCalibration truth = BoxRoomCalibration();
  truth.pose_sensor = camera::RgbdSensor::kColor;
  truth.color_from_depth.translation = {0, 0.05, 0};
  const auto dataset = Record(truth, 24);
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  const auto report = CalibrateRgbd(*dataset, {.frames = 24}, true, {});
  ASSERT_TRUE(report.ok()) << report.status();
  const geometry::Vec3 t = report->calibration.color_from_depth.translation;
  EXPECT_NEAR(t.x, 0, 0.003);
  EXPECT_NEAR(t.y, 0.05, 0.003);
  EXPECT_NEAR(t.z, 0, 0.003);
}

// Poses off by 1 cm, as structure from motion and phones have them, must not be
// explained by cameras that nobody builds.
TEST_F(RgbdCalibratorTest, ErrorsOfPosesDoNotMoveTheCameras) {
  constexpr size_t kFrames = 12;
  camera::RgbdCalibration truth = BoxRoomCalibration();
  truth.pose_sensor = camera::RgbdSensor::kColor;
  std::vector<geometry::Rigid3> poses = BoxRoomPoses(5 * kFrames);
  poses.resize(kFrames);  // a part of the way round looks one way
  WriteBoxRoomRecording(folder_, truth, poses);
  std::ifstream exact(folder_ + "/poses.txt");
  std::ostringstream noisy;
  base::Random random(/*seed=*/1, /*stream=*/0);
  for (std::string stem; exact >> stem;) {
    noisy << stem;
    for (int i = 0; i < 7; ++i) {
      double value = 0;
      exact >> value;
      const bool is_position = i >= 4;
      noisy << ' ' << value + (is_position ? 0.01 * random.NextGaussian() : 0);
    }
    noisy << '\n';
  }
  std::ofstream(folder_ + "/poses.txt") << noisy.str();
  const auto dataset = Open(camera::RgbdSensor::kColor);
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  const auto report = CalibrateRgbd(*dataset, {.frames = kFrames}, true, {});
  ASSERT_TRUE(report.ok()) << report.status();
  // Two standard deviations of what is known of such cameras beforehand.
  const geometry::Vec3 t = report->calibration.color_from_depth.translation;
  EXPECT_LT(std::abs(t.y), 0.02);
  EXPECT_LT(std::abs(t.z), 0.02);
  EXPECT_EQ(report->calibration.color, dataset->calibration().color);
}

TEST_F(RgbdCalibratorTest, DoesNotDependOnTheNumberOfThreads) {
  camera::RgbdCalibration truth = BoxRoomCalibration();
  truth.color_from_depth.translation = {-0.03, 0, 0};
  const auto dataset = Record(truth, 12);
  ASSERT_TRUE(dataset.ok());
  CalibratorOptions options{.frames = 12, .threads = 1};
  const auto one = CalibrateRgbd(*dataset, options, true, {});
  options.threads = 4;
  const auto four = CalibrateRgbd(*dataset, options, true, {});
  ASSERT_TRUE(one.ok() && four.ok());
  EXPECT_EQ(one->calibration, four->calibration);
}

TEST_F(RgbdCalibratorTest, PosesThatFitWhenMeantOtherwiseAreRefused) {
  const auto right = Record(BoxRoomCalibration(), 40);
  ASSERT_TRUE(right.ok()) << right.status();
  EXPECT_TRUE(CheckPoses(*right, {}, true, {}).ok());
  dataset::DatasetOptions options = Options(camera::RgbdSensor::kDepth);
  options.depth_unit_m = 0.005;  // of a recording in millimetres
  const auto wrong = dataset::Dataset::Open(options);
  ASSERT_TRUE(wrong.ok()) << wrong.status();
  for (const absl::Status& status :
       {CheckPoses(*wrong, {}, true, {}),
        CalibrateRgbd(*wrong, {}, true, {}).status()}) {
    EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
    EXPECT_THAT(std::string(status.message()),
                testing::HasSubstr("a --depth-unit a fifth as large"));
  }
}

TEST_F(RgbdCalibratorTest, SaysWhenThereIsTooLittleToGoBy) {
  const auto dataset = Record(BoxRoomCalibration(), 2);  // back to back
  ASSERT_TRUE(dataset.ok());
  EXPECT_EQ(CalibrateRgbd(*dataset, {}, true, {}).status().code(),
            absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(CalibrateRgbd(*dataset, {.frames = 1}, true, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(CalibrateRgbd(*dataset, {}, true, stop.get_token()).status().code(),
            absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace treeline::training
