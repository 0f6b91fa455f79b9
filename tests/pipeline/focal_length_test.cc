// Queries whose focal length is wrong, or that nobody states, in a scene of
// method `universal`.
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <string>

#include "common/camera/derived_camera.h"
#include "gtest/gtest.h"
#include "server/core/localizer/localizer.h"
#include "server/core/training/box_room_recording.h"
#include "server/core/training/scene_trainer.h"

namespace treeline {
namespace {

constexpr int kFrames = 80;
constexpr int kAsked = 16;

camera::RgbdCalibration Calibration() {
  camera::RgbdCalibration calibration = training::BoxRoomCalibration();
  calibration.pose_sensor = camera::RgbdSensor::kDepth;
  return calibration;
}

// Between the poses of training, spread over the room.
geometry::Rigid3 AskedPose(int i) {
  return training::BoxRoomPoses(2 * kFrames)[static_cast<size_t>(10 * i + 1)];
}

// The lower right part of a frame, a share of its width and height.
image::Frame WindowOf(const image::Frame& frame,
                      camera::RgbdCalibration calibration, double share = 0.5) {
  const int width = static_cast<int>(share * frame.color.width);
  const int height = static_cast<int>(share * frame.color.height);
  const int left = frame.color.width - width;
  const int top = frame.color.height - height;
  image::Frame window;
  calibration.color =
      camera::Cropped(calibration.color, left, top, width, height).value();
  window.calibration = calibration;
  window.color = {width, height, {}};
  for (int y = top; y < frame.color.height; ++y) {
    const auto row =
        frame.color.rgb.begin() + 3 * (y * frame.color.width + left);
    window.color.rgb.insert(window.color.rgb.end(), row, row + 3 * width);
  }
  return window;
}

class FocalLengthTest : public testing::Test {
 protected:
  struct Count {
    int right = 0;        // within 5 cm
    int gross = 0;        // beyond 10 cm
    int other_focal = 0;  // answered with another focal length
    int found_focal = 0;  // right, and the focal length to within 2 %
    int told = 0;         // features want another one
  };

  static void SetUpTestSuite() {
    folder_ = new std::string(testing::TempDir() + "/focal_length_test_" +
                              std::to_string(getpid()));
    training::WriteBoxRoomRecording(*folder_, Calibration(),
                                    training::BoxRoomPoses(kFrames));
    dataset::DatasetOptions recording;
    recording.uri = "7scenes:" + *folder_;
    recording.color_camera = "PINHOLE,145,145,100,75";
    recording.depth_camera = recording.color_camera;
    training::SceneTrainingOptions options;
    options.method = "universal";
    options.calibration = Calibration();
    options.forest.samples_per_frame = 300;
    options.forest.trees = 3;
    ASSERT_TRUE(training::TrainScene(*dataset::Dataset::Open(recording),
                                     options, Model(), true, {})
                    .ok());
  }
  static void TearDownTestSuite() {
    std::filesystem::remove_all(*folder_);
    delete folder_;
  }
  static std::string Model() { return *folder_ + "/model.treeline"; }

  // `change` makes a query of a frame without calibration; its stated focal
  // length is `stated` times the true one.
  template <typename Change>
  static Count Ask(Change change, double stated,
                   const localizer::QueryOptions& options = {}) {
    const auto localizer = localizer::OpenLocalizer(Model(), options).value();
    Count count;
    for (int i = 0; i < kAsked; ++i) {
      image::Frame frame = training::RenderBoxRoom(Calibration(), AskedPose(i));
      change(localizer->info().calibration, frame);
      const auto estimate = localizer->Localize(frame, {}).value();
      count.told += estimate.focal_error_sigmas > 4;
      if (estimate.outcome != localizer::Outcome::kLocalized) continue;
      const double error_m =
          geometry::ErrorBetween(estimate.world_from_camera, AskedPose(i))
              .translation_m;
      count.right += error_m < 0.05;
      count.gross += error_m > 0.1;
      count.other_focal += estimate.focal_scale != 1;
      count.found_focal +=
          error_m < 0.05 && std::abs(estimate.focal_scale * stated - 1) < 0.02;
    }
    return count;
  }

  // Without depth, with the focal length times `scale`.
  static auto WithFocal(double scale, bool is_assumed) {
    return [=](camera::RgbdCalibration calibration, image::Frame& frame) {
      calibration.color =
          camera::WithFocalScaled(calibration.color, scale).value();
      frame.calibration = calibration;
      frame.depth.reset();
      frame.is_camera_assumed = is_assumed;
    };
  }

 private:
  static inline std::string* folder_ = nullptr;
};

TEST_F(FocalLengthTest, AWrongOneIsCorrected) {
  EXPECT_GE(Ask(WithFocal(1.08, /*is_assumed=*/false), 1.08).found_focal, 12);
}

TEST_F(FocalLengthTest, OneThatIsKnownIsNotAndThatItDoesNotFitIsTold) {
  const Count count = Ask(WithFocal(1.08, /*is_assumed=*/false), 1.08,
                          {.corrects_focal = false});
  EXPECT_EQ(count.other_focal, 0);
  EXPECT_GE(count.told, 8);
}

TEST_F(FocalLengthTest, OneThatNobodyStatesIsFound) {
  const Count count = Ask(WithFocal(0.8, /*is_assumed=*/true), 0.8);
  EXPECT_GE(count.found_focal, 8);
  EXPECT_EQ(count.gross, 0);
}

// Taken for whole pictures, windows off the middle give poses that are 10 cm
// wrong and more.
TEST_F(FocalLengthTest, OfAWindowThatNobodyStatesThePrincipalPointIsFound) {
  const auto windows = [](bool is_stated) {
    return
        [=](const camera::RgbdCalibration& calibration, image::Frame& frame) {
          frame = WindowOf(frame, calibration, 0.8);
          frame.is_camera_assumed = !is_stated;
          if (is_stated) return;
          camera::Camera& color = frame.calibration->color;
          color = *camera::WithPrincipalPointMoved(
              color, 0.5 * (color.width() - 1) - color.cx(),
              0.5 * (color.height() - 1) - color.cy());
        };
  };
  const Count count = Ask(windows(/*is_stated=*/false), 1);
  EXPECT_EQ(count.gross, 0);
  EXPECT_GE(count.right, 2);
  EXPECT_GE(Ask(windows(/*is_stated=*/true), 1).right, count.right);
}

// Nothing tells it where it may not be looked for.
TEST_F(FocalLengthTest, OneThatNobodyStatesIsNotBelievedUnconfirmed) {
  const Count count =
      Ask(WithFocal(0.8, /*is_assumed=*/true), 0.8, {.corrects_focal = false});
  EXPECT_EQ(count.right + count.gross, 0);
}

TEST_F(FocalLengthTest, AWindowOfTheScenesPicturesHasTheirs) {
  const Count count =
      Ask([](const camera::RgbdCalibration&,
             image::Frame& frame) { frame = WindowOf(frame, Calibration()); },
          1);
  EXPECT_EQ(count.other_focal, 0);
  EXPECT_EQ(count.gross, 0);
  EXPECT_GE(count.right, 8);
}

// Features fit them, too, metres away.
TEST_F(FocalLengthTest, IntrinsicsOfPicturesOfHalfTheSizeAreRecognised) {
  const Count count = Ask(
      [](camera::RgbdCalibration calibration, image::Frame& frame) {
        const camera::Camera c = calibration.color;
        const double half[] = {c.fx() / 2, c.fy() / 2, c.cx() / 2, c.cy() / 2};
        calibration.color =
            camera::Camera::Create(camera::CameraModel::kPinhole, c.width(),
                                   c.height(), half, 4)
                .value();
        frame.calibration = calibration;
      },
      0.5);
  EXPECT_GE(count.right, 11);
}

}  // namespace
}  // namespace treeline
