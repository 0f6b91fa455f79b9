#include <unistd.h>

#include <filesystem>

#include "common/base/parallel_for.h"
#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/forest/model_file.h"
#include "server/core/localizer/localizer.h"
#include "server/core/training/box_room_recording.h"
#include "server/core/training/forest_trainer.h"
#include "server/core/training/keyframe_builder.h"
#include "tests/pipeline/same_answers.h"

namespace treeline {
namespace {

template <typename T>
absl::string_view BytesOf(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()),
          values.size() * sizeof(T)};
}

// Models of the box room: with its forest, and with one that knows another
// place.
class HybridLocalizerTest : public testing::Test {
 protected:
  static constexpr int kFrames = 30;

  static void SetUpTestSuite() {
    folder_ = new std::string(testing::TempDir() + "/hybrid_localizer_test_" +
                              std::to_string(getpid()));
    training::WriteBoxRoomRecording(*folder_, training::BoxRoomCalibration(),
                                    training::BoxRoomPoses(kFrames));
    dataset::DatasetOptions recording;
    recording.uri = "7scenes:" + *folder_;
    recording.color_camera = "PINHOLE,145,145,100,75";
    recording.depth_camera = recording.color_camera;
    const auto dataset = dataset::Dataset::Open(recording);
    ASSERT_TRUE(dataset.ok()) << dataset.status();
    training::TrainingOptions options;
    options.depth_adaptive = false;
    options.samples_per_frame = 300;
    options.trees = 3;
    camera::RgbdCalibration calibration = training::BoxRoomCalibration();
    calibration.pose_sensor = dataset->calibration().pose_sensor;
    auto trained =
        training::TrainForest(*dataset, calibration, options, true, {});
    ASSERT_TRUE(trained.ok()) << trained.status();
    training::KeyframeOptions keyframe_options;
    keyframe_options.features = 300;
    const auto keyframes = training::BuildKeyframes(*dataset, calibration,
                                                    keyframe_options, true, {});
    ASSERT_TRUE(keyframes.ok()) << keyframes.status();
    ASSERT_FALSE(keyframes->features.empty());
    forest::ModelInfo info;
    info.method = "hybrid";
    info.keyframe_sift = keyframe_options.sift;
    info.calibration = calibration;
    info.calibration.pose_sensor = camera::RgbdSensor::kColor;
    const std::vector<forest::ModelExtraBytes> extras = {
        {forest::ModelExtra::kKeyframes, BytesOf(keyframes->records)},
        {forest::ModelExtra::kKeyframePoints, BytesOf(keyframes->points)},
        {forest::ModelExtra::kKeyframeFeatures, BytesOf(keyframes->features)}};
    const std::string path = *folder_ + "/model.treeline";
    ASSERT_TRUE(
        forest::WriteModel(path, info, {trained->forest.View()}, extras).ok());
    localizer_ = localizer::OpenLocalizer(path)->release();
    // The forest of a room ten metres away.
    trained->forest.bounds_min_in_world.x += 10;
    trained->forest.bounds_max_in_world.x += 10;
    ASSERT_TRUE(
        forest::WriteModel(path, info, {trained->forest.View()}, extras).ok());
    misled_ = localizer::OpenLocalizer(path)->release();
  }
  static void TearDownTestSuite() {
    delete localizer_;
    delete misled_;
    std::filesystem::remove_all(*folder_);
    delete folder_;
  }

  // A pose between those of training.
  static geometry::Rigid3 HeldOutPose(int i) {
    const geometry::Rigid3 a =
        training::BoxRoomPoses(2 * kFrames)[static_cast<size_t>(2 * i + 1)];
    return {a.rotation, a.translation + geometry::Vec3{0.02, -0.01, 0.03}};
  }
  static image::Frame ColorAt(const geometry::Rigid3& pose) {
    image::Frame frame =
        training::RenderBoxRoom(training::BoxRoomCalibration(), pose);
    frame.depth.reset();
    return frame;
  }
  static int CorrectOf10(const localizer::Localizer& localizer) {
    int correct = 0;
    for (int i = 0; i < 10; ++i) {
      const geometry::Rigid3 truth = HeldOutPose(2 * i);
      const auto estimate = localizer.Localize(ColorAt(truth), {});
      EXPECT_TRUE(estimate.ok()) << estimate.status();
      if (estimate->outcome != localizer::Outcome::kLocalized) continue;
      const geometry::PoseError error =
          geometry::ErrorBetween(estimate->world_from_camera, truth);
      EXPECT_LT(error.translation_m, 0.1) << "a wrong pose passed for right";
      correct += error.translation_m < 0.05 && error.rotation_rad < 0.087;
    }
    return correct;
  }

  static std::string* folder_;
  static localizer::Localizer* localizer_;
  static localizer::Localizer* misled_;
};
std::string* HybridLocalizerTest::folder_ = nullptr;
localizer::Localizer* HybridLocalizerTest::localizer_ = nullptr;
localizer::Localizer* HybridLocalizerTest::misled_ = nullptr;

TEST_F(HybridLocalizerTest, FindsHeldOutViewsWithoutDepth) {
  EXPECT_GE(CorrectOf10(*localizer_), 9);
}

TEST_F(HybridLocalizerTest, FindsThemThoughTheForestIsWrong) {
  EXPECT_GE(CorrectOf10(*misled_), 8);
}

TEST_F(HybridLocalizerTest, KeyframesWhereThePoseIsExpectedAnswerAlone) {
  const geometry::Rigid3 truth = HeldOutPose(7);
  localizer::LocalizeOptions options;
  options.priors.position = geometry::PositionPrior{truth.translation, 0.5};
  const auto estimate = localizer_->Localize(ColorAt(truth), options);
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  ASSERT_EQ(estimate->outcome, localizer::Outcome::kLocalized);
  EXPECT_LT(
      geometry::ErrorBetween(estimate->world_from_camera, truth).translation_m,
      0.05);
  // The forest was not asked.
  EXPECT_EQ(estimate->timings.forest_ms, 0);
  EXPECT_GT(localizer_->Localize(ColorAt(truth), {})->timings.forest_ms, 0);
}

TEST_F(HybridLocalizerTest, AWrongPriorForgesNoPose) {
  const geometry::Rigid3 truth = HeldOutPose(7);
  localizer::LocalizeOptions options;
  options.priors.position = geometry::PositionPrior{
      truth.translation + geometry::Vec3{1.5, 0, 0}, 0.5};
  const auto estimate = localizer_->Localize(ColorAt(truth), options);
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  EXPECT_EQ(estimate->outcome, localizer::Outcome::kNotLocalized);
  EXPECT_EQ(estimate->reason, localizer::NotLocalizedReason::kContradictsPrior);
}

TEST_F(HybridLocalizerTest, TheSameSeedGivesTheSameBitsFromAnyThread) {
  const image::Frame frame = ColorAt(HeldOutPose(7));
  localizer::LocalizeOptions options;
  options.seed = 5;
  const auto first = localizer_->Localize(frame, options);
  ASSERT_TRUE(first.ok());
  std::vector<geometry::Rigid3> poses(4);
  base::ParallelFor(4, 4, [&](int64_t i) {
    poses[static_cast<size_t>(i)] =
        localizer_->Localize(frame, options)->world_from_camera;
  });
  for (const geometry::Rigid3& pose : poses) {
    EXPECT_EQ(pose, first->world_from_camera);
  }
}

TEST_F(HybridLocalizerTest, AllVectorInstructionsGiveTheSameAnswers) {
  std::vector<image::Frame> frames;
  for (int i = 0; i < 10; ++i) frames.push_back(ColorAt(HeldOutPose(2 * i)));
  ExpectSameAnswers(*localizer_, frames);
}

TEST_F(HybridLocalizerTest, ExplainsItselfOnRequest) {
  const image::Frame frame = ColorAt(HeldOutPose(7));
  localizer::LocalizeOptions options;
  options.keep_correspondences = true;
  const auto estimate = localizer_->Localize(frame, options);
  ASSERT_TRUE(estimate.ok());
  ASSERT_EQ(estimate->correspondences.size(),
            static_cast<size_t>(estimate->samples));
  int inliers = 0;
  for (const localizer::Correspondence& c : estimate->correspondences) {
    inliers += c.inlier;
  }
  EXPECT_EQ(inliers, estimate->inliers);
}

TEST_F(HybridLocalizerTest, DoesNotLocalizeNoise) {
  base::Random random(1, 0);
  image::Frame noise = ColorAt(HeldOutPose(0));
  for (uint8_t& value : noise.color.rgb) {
    value = static_cast<uint8_t>(random.NextBelow(256));
  }
  const auto estimate = localizer_->Localize(noise, {});
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  EXPECT_EQ(estimate->outcome, localizer::Outcome::kNotLocalized);
}

}  // namespace
}  // namespace treeline
