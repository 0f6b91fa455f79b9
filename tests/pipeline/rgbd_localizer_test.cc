#include <unistd.h>

#include <filesystem>

#include "common/base/parallel_for.h"
#include "common/base/random.h"
#include "common/image/quarter_turn.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/forest/model_file.h"
#include "server/core/localizer/localizer.h"
#include "server/core/training/box_room_recording.h"
#include "server/core/training/forest_trainer.h"
#include "tests/pipeline/same_answers.h"

namespace treeline {
namespace {

using testing::HasSubstr;

// A model of the box room, trained once for all tests.
class RgbdLocalizerTest : public testing::Test {
 protected:
  static constexpr int kFrames = 60;

  static void SetUpTestSuite() {
    folder_ = new std::string(testing::TempDir() + "/rgbd_localizer_test_" +
                              std::to_string(getpid()));
    training::WriteBoxRoomRecording(*folder_, Calibration(),
                                    training::BoxRoomPoses(kFrames));
    dataset::DatasetOptions recording;
    recording.uri = "7scenes:" + *folder_;
    recording.color_camera = "PINHOLE,145,145,100,75";
    recording.depth_camera = recording.color_camera;
    const auto dataset = dataset::Dataset::Open(recording);
    training::TrainingOptions options;
    options.samples_per_frame = 500;
    auto trained =
        training::TrainForest(*dataset, Calibration(), options, true, {});
    forest::ModelInfo info;
    info.method = "rgbd";
    info.calibration = Calibration();
    const absl::Status written =
        forest::WriteModel(ModelPath(), info, {trained->forest.View()});
    ASSERT_TRUE(written.ok()) << written;
    localizer_ = localizer::OpenLocalizer(ModelPath())->release();
  }
  static void TearDownTestSuite() {
    delete localizer_;
    std::filesystem::remove_all(*folder_);
    delete folder_;
  }

  static std::string ModelPath() { return *folder_ + "/model.treeline"; }

  // Depth and colour sit apart, poses are the depth camera's.
  static camera::RgbdCalibration Calibration() {
    camera::RgbdCalibration calibration = training::BoxRoomCalibration();
    calibration.color_from_depth.translation = {-0.025, 0, 0};
    calibration.pose_sensor = camera::RgbdSensor::kDepth;
    return calibration;
  }

  // A pose between those of training.
  static geometry::Rigid3 HeldOutPose(int i) {
    const geometry::Rigid3 a =
        training::BoxRoomPoses(2 * kFrames)[static_cast<size_t>(2 * i + 1)];
    return {a.rotation, a.translation + geometry::Vec3{0.02, -0.01, 0.03}};
  }

  static std::string* folder_;
  static localizer::Localizer* localizer_;
};
std::string* RgbdLocalizerTest::folder_ = nullptr;
localizer::Localizer* RgbdLocalizerTest::localizer_ = nullptr;

TEST_F(RgbdLocalizerTest, FindsHeldOutViews) {
  int correct = 0;
  for (int i = 0; i < 20; ++i) {
    const geometry::Rigid3 truth = HeldOutPose(3 * i);
    const auto estimate =
        localizer_->Localize(training::RenderBoxRoom(Calibration(), truth), {});
    ASSERT_TRUE(estimate.ok()) << estimate.status();
    if (estimate->outcome != localizer::Outcome::kLocalized) continue;
    const geometry::PoseError error =
        geometry::ErrorBetween(estimate->world_from_camera, truth);
    EXPECT_LT(error.translation_m, 0.1) << "a wrong pose passed for right";
    correct += error.translation_m < 0.05 && error.rotation_rad < 0.087;
    EXPECT_EQ(estimate->reason, localizer::NotLocalizedReason::kNone);
    EXPECT_GT(estimate->inlier_ratio, 0.1);
    EXPECT_NEAR(estimate->inlier_ratio,
                static_cast<double>(estimate->inliers) / estimate->samples,
                1e-12);
  }
  EXPECT_GE(correct, 18);
}

TEST_F(RgbdLocalizerTest, TheSameSeedGivesTheSameBitsFromAnyThread) {
  const image::Frame frame =
      training::RenderBoxRoom(Calibration(), HeldOutPose(7));
  localizer::LocalizeOptions options;
  options.seed = 5;
  const auto first = localizer_->Localize(frame, options);
  ASSERT_TRUE(first.ok());
  std::vector<geometry::Rigid3> poses(8);
  base::ParallelFor(8, 4, [&](int64_t i) {
    poses[static_cast<size_t>(i)] =
        localizer_->Localize(frame, options)->world_from_camera;
  });
  for (const geometry::Rigid3& pose : poses) {
    EXPECT_EQ(pose, first->world_from_camera);
  }
  options.seed = 6;
  EXPECT_NE(localizer_->Localize(frame, options)->world_from_camera,
            first->world_from_camera);
}

TEST_F(RgbdLocalizerTest, AllVectorInstructionsGiveTheSameAnswers) {
  std::vector<image::Frame> frames;
  for (int i = 0; i < 20; ++i) {
    frames.push_back(
        training::RenderBoxRoom(Calibration(), HeldOutPose(3 * i)));
  }
  ExpectSameAnswers(*localizer_, frames);
}

TEST_F(RgbdLocalizerTest, TheQuestionSaysHowSureAnAnswerMustBe) {
  const image::Frame frame =
      training::RenderBoxRoom(Calibration(), HeldOutPose(7));
  const auto usual = localizer_->Localize(frame, {});
  ASSERT_TRUE(usual.ok());
  ASSERT_EQ(usual->outcome, localizer::Outcome::kLocalized);
  ASSERT_LT(usual->confidence, 1);
  const auto asked = [&](double min_confidence) {
    localizer::LocalizeOptions options;
    options.min_confidence = min_confidence;
    return *localizer_->Localize(frame, options);
  };
  EXPECT_EQ(asked(usual->confidence).outcome, localizer::Outcome::kLocalized);
  const localizer::PoseEstimate unsure = asked(1);
  EXPECT_EQ(unsure.outcome, localizer::Outcome::kNotLocalized);
  EXPECT_EQ(unsure.reason, localizer::NotLocalizedReason::kLowConfidence);
  // What was found is the same.
  EXPECT_EQ(unsure.world_from_camera, usual->world_from_camera);
  EXPECT_EQ(unsure.confidence, usual->confidence);
}

TEST_F(RgbdLocalizerTest, ExplainsItselfOnRequest) {
  const image::Frame frame =
      training::RenderBoxRoom(Calibration(), HeldOutPose(7));
  localizer::LocalizeOptions options;
  options.keep_correspondences = true;
  const auto estimate = localizer_->Localize(frame, options);
  ASSERT_TRUE(estimate.ok());
  ASSERT_EQ(estimate->correspondences.size(),
            static_cast<size_t>(estimate->samples));
  int inliers = 0;
  for (const localizer::Correspondence& c : estimate->correspondences) {
    inliers += c.inlier;
    if (!c.inlier) continue;
    EXPECT_LE(geometry::Norm(estimate->world_from_camera * c.point_in_camera -
                             c.point_in_world),
              0.0501);
  }
  EXPECT_EQ(inliers, estimate->inliers);
  EXPECT_TRUE(localizer_->Localize(frame, {})->correspondences.empty());
}

TEST_F(RgbdLocalizerTest, ARequestsOwnCalibrationReplacesTheScenes) {
  // The same view through a camera pair without offset and with a longer lens.
  camera::RgbdCalibration own = training::BoxRoomCalibration();
  own.color = *camera::Camera::Parse("PINHOLE,180,180,100,75", 200, 150);
  own.depth = own.color;
  own.pose_sensor = camera::RgbdSensor::kDepth;
  const geometry::Rigid3 truth = HeldOutPose(7);
  image::Frame frame = training::RenderBoxRoom(own, truth);
  frame.calibration = own;
  const auto estimate = localizer_->Localize(frame, {});
  ASSERT_TRUE(estimate.ok());
  ASSERT_EQ(estimate->outcome, localizer::Outcome::kLocalized);
  EXPECT_LT(
      geometry::ErrorBetween(estimate->world_from_camera, truth).translation_m,
      0.05);
}

TEST_F(RgbdLocalizerTest, ATurnedFrameHasThePoseOfTheFrameAsItIs) {
  for (const image::QuarterTurn turn : image::kQuarterTurns) {
    const geometry::Rigid3 upright_pose = HeldOutPose(7);
    image::Frame frame =
        Turned(training::RenderBoxRoom(Calibration(), upright_pose), turn);
    frame.calibration = Turned(Calibration(), turn);
    // Of the depth camera, turned about its own axis.
    const geometry::Rigid3 truth =
        upright_pose *
        geometry::Rigid3{image::TurnedFromCamera(turn), {}}.Inverse();
    for (const bool is_certain : {false, true}) {
      // Where it is no certainty, nothing is known.
      frame.orientation = {};
      if (is_certain) frame.orientation = {image::Inverse(turn), true};
      const auto estimate = localizer_->Localize(frame, {});
      ASSERT_TRUE(estimate.ok()) << estimate.status();
      ASSERT_EQ(estimate->outcome, localizer::Outcome::kLocalized);
      const geometry::PoseError error =
          geometry::ErrorBetween(estimate->world_from_camera, truth);
      EXPECT_LT(error.translation_m, 0.05);
      EXPECT_LT(error.rotation_rad, 0.087);
    }
    // Another way up than stated, which it is not.
    frame.orientation = {
        image::Remaining(image::Inverse(turn), image::QuarterTurn::kHalf),
        true};
    EXPECT_EQ(localizer_->Localize(frame, {})->outcome,
              localizer::Outcome::kNotLocalized);
  }
}

TEST_F(RgbdLocalizerTest, DoesNotLocalizeWhatItHasNotSeen) {
  base::Random random(1, 0);
  image::Frame noise = training::RenderBoxRoom(Calibration(), HeldOutPose(0));
  for (uint8_t& value : noise.color.rgb) {
    value = static_cast<uint8_t>(random.NextBelow(256));
  }
  EXPECT_EQ(localizer_->Localize(noise, {})->outcome,
            localizer::Outcome::kNotLocalized);
  image::Frame black = noise;
  std::fill(black.color.rgb.begin(), black.color.rgb.end(), uint8_t{0});
  const auto estimate = localizer_->Localize(black, {});
  ASSERT_TRUE(estimate.ok());
  EXPECT_EQ(estimate->outcome, localizer::Outcome::kNotLocalized);
  EXPECT_EQ(estimate->reason, localizer::NotLocalizedReason::kTooFewInliers);
  image::Frame blind = noise;
  std::fill(blind.depth->values.begin(), blind.depth->values.end(),
            uint16_t{0});
  EXPECT_EQ(localizer_->Localize(blind, {})->reason,
            localizer::NotLocalizedReason::kTooFewSamples);
}

TEST_F(RgbdLocalizerTest, RefusesFramesItCannotUse) {
  image::Frame frame = training::RenderBoxRoom(Calibration(), HeldOutPose(0));
  image::Frame without_depth = frame;
  without_depth.depth.reset();
  const absl::Status missing = localizer_->Localize(without_depth, {}).status();
  EXPECT_EQ(missing.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(missing.ToString(), HasSubstr("needs a depth image"));
  image::Frame small = frame;
  small.color = {64, 64, std::vector<uint8_t>(64 * 64 * 3)};
  EXPECT_THAT(localizer_->Localize(small, {}).status().ToString(),
              HasSubstr("64 x 64"));
  image::Frame other_depth = frame;
  other_depth.depth->height = 140;
  other_depth.depth->values.resize(200 * 140);
  EXPECT_THAT(localizer_->Localize(other_depth, {}).status().ToString(),
              HasSubstr("200 x 140"));
}

TEST_F(RgbdLocalizerTest, StopsWhenAsked) {
  std::stop_source stop;
  stop.request_stop();
  localizer::LocalizeOptions options;
  options.stop = stop.get_token();
  EXPECT_EQ(
      localizer_
          ->Localize(training::RenderBoxRoom(Calibration(), HeldOutPose(0)),
                     options)
          .status()
          .code(),
      absl::StatusCode::kCancelled);
}

TEST_F(RgbdLocalizerTest, OpensWithOtherQueryOptionsOrSaysWhyNot) {
  EXPECT_TRUE(localizer::OpenLocalizer(ModelPath(), {.samples = 100}).ok());
  EXPECT_THAT(localizer::OpenLocalizer(ModelPath(), {.backtracking_leaves = 33})
                  .status()
                  .ToString(),
              HasSubstr("between 1 and 32"));
  EXPECT_EQ(localizer::OpenLocalizer(*folder_ + "/none").status().code(),
            absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace treeline
