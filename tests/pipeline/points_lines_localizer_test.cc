#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "common/base/parallel_for.h"
#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/forest/model_file.h"
#include "server/core/localizer/localizer.h"
#include "server/core/training/box_room_recording.h"
#include "server/core/training/scene_trainer.h"
#include "tests/pipeline/same_answers.h"

namespace treeline {
namespace {

using testing::HasSubstr;

// A model of the box room with tiled walls, trained once for all tests.
class PointsLinesLocalizerTest : public testing::Test {
 protected:
  static constexpr int kFrames = 30;

  static void SetUpTestSuite() {
    folder_ =
        new std::string(testing::TempDir() + "/points_lines_localizer_test_" +
                        std::to_string(getpid()));
    training::WriteBoxRoomRecording(*folder_, Calibration(),
                                    training::BoxRoomPoses(kFrames),
                                    training::BoxRoomWalls::kTiled);
    const absl::StatusOr<training::TrainedScene> trained =
        Train(ModelPath(), 2);
    ASSERT_TRUE(trained.ok()) << trained.status();
    info_ = new forest::ModelInfo(trained->info);
    localizer_ = localizer::OpenLocalizer(ModelPath())->release();
  }
  static void TearDownTestSuite() {
    delete localizer_;
    delete info_;
    std::filesystem::remove_all(*folder_);
    delete folder_;
  }

  static std::string ModelPath() { return *folder_ + "/model.treeline"; }

  static absl::StatusOr<training::TrainedScene> Train(const std::string& path,
                                                      int threads) {
    dataset::DatasetOptions recording;
    recording.uri = "7scenes:" + *folder_;
    recording.color_camera = "PINHOLE,145,145,100,75";
    recording.depth_camera = recording.color_camera;
    const auto dataset = dataset::Dataset::Open(recording);
    if (!dataset.ok()) return dataset.status();
    training::SceneTrainingOptions options;
    options.method = "points-lines";
    options.calibration = Calibration();
    options.forest.trees = 3;
    options.forest.samples_per_frame = 300;
    options.forest.threads = threads;
    return training::TrainScene(*dataset, options, path, true, {});
  }

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
  static image::Frame HeldOutFrame(int i) {
    return training::RenderBoxRoom(Calibration(), HeldOutPose(i),
                                   training::BoxRoomWalls::kTiled);
  }

  static std::string* folder_;
  static forest::ModelInfo* info_;
  static localizer::Localizer* localizer_;
};
std::string* PointsLinesLocalizerTest::folder_ = nullptr;
forest::ModelInfo* PointsLinesLocalizerTest::info_ = nullptr;
localizer::Localizer* PointsLinesLocalizerTest::localizer_ = nullptr;

TEST_F(PointsLinesLocalizerTest, TheModelHasAForestForEachKindOfPoint) {
  const auto model = forest::ModelFile::Open(ModelPath());
  ASSERT_TRUE(model.ok()) << model.status();
  ASSERT_EQ((*model)->forests(), 2u);
  EXPECT_EQ((*model)->forest(0).trees(), 3);
  EXPECT_EQ((*model)->forest(1).trees(), 3);
  EXPECT_EQ(info_->method, "points-lines");
  EXPECT_EQ(info_->training_frames, kFrames);
  // General points of all frames, and points on lines.
  EXPECT_GT(info_->training_samples, 3 * kFrames * 300);
}

TEST_F(PointsLinesLocalizerTest, FindsHeldOutViews) {
  int correct = 0;
  for (int i = 0; i < 10; ++i) {
    const auto estimate = localizer_->Localize(HeldOutFrame(3 * i), {});
    ASSERT_TRUE(estimate.ok()) << estimate.status();
    if (estimate->outcome != localizer::Outcome::kLocalized) continue;
    const geometry::PoseError error =
        geometry::ErrorBetween(estimate->world_from_camera, HeldOutPose(3 * i));
    EXPECT_LT(error.translation_m, 0.1) << "a wrong pose passed for right";
    correct += error.translation_m < 0.05 && error.rotation_rad < 0.087;
  }
  EXPECT_GE(correct, 9);
}

TEST_F(PointsLinesLocalizerTest, TheSameSeedGivesTheSameBitsFromAnyThread) {
  const image::Frame frame = HeldOutFrame(7);
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
}

TEST_F(PointsLinesLocalizerTest, AllVectorInstructionsGiveTheSameAnswers) {
  std::vector<image::Frame> frames;
  for (int i = 0; i < 10; ++i) frames.push_back(HeldOutFrame(3 * i));
  ExpectSameAnswers(*localizer_, frames);
}

TEST_F(PointsLinesLocalizerTest, TheModelDoesNotDependOnTheNumberOfThreads) {
  const std::string path = *folder_ + "/again.treeline";
  const auto again = Train(path, 1);
  ASSERT_TRUE(again.ok());
  const auto a = forest::ModelFile::Open(ModelPath());
  const auto b = forest::ModelFile::Open(path);
  ASSERT_TRUE(a.ok() && b.ok());
  for (const size_t f : {0u, 1u}) {
    EXPECT_TRUE(
        std::ranges::equal((*a)->forest(f).nodes, (*b)->forest(f).nodes,
                           [](const forest::Node& x, const forest::Node& y) {
                             return x.lo == y.lo && x.hi == y.hi;
                           }));
  }
}

TEST_F(PointsLinesLocalizerTest, UsesPointsOfBothKinds) {
  localizer::LocalizeOptions options;
  options.keep_correspondences = true;
  const auto estimate = localizer_->Localize(HeldOutFrame(7), options);
  ASSERT_TRUE(estimate.ok());
  EXPECT_EQ(estimate->samples, localizer::QueryOptions().samples);
  EXPECT_EQ(estimate->correspondences.size(),
            static_cast<size_t>(estimate->samples));
  // General points are as far off as a depth pixel says, in whole millimetres;
  // points on lines are anywhere.
  int on_lines = 0;
  for (const localizer::Correspondence& c : estimate->correspondences) {
    const double z_mm = 1000 * c.point_in_camera.z;
    on_lines += c.inlier && std::abs(z_mm - std::round(z_mm)) > 1e-3;
  }
  EXPECT_GT(on_lines, 20);
  EXPECT_LE(on_lines, localizer::QueryOptions().samples / 2);
}

TEST_F(PointsLinesLocalizerTest, WithoutLinesPointsAloneAnswer) {
  // The room without its tiles has no straight edges, and is another room.
  const auto estimate = localizer_->Localize(
      training::RenderBoxRoom(Calibration(), HeldOutPose(7),
                              training::BoxRoomWalls::kSmooth),
      {});
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  EXPECT_EQ(estimate->samples, localizer::QueryOptions().samples);
}

TEST_F(PointsLinesLocalizerTest, DoesNotLocalizeWhatItHasNotSeen) {
  base::Random random(1, 0);
  image::Frame noise = HeldOutFrame(0);
  for (uint8_t& value : noise.color.rgb) {
    value = static_cast<uint8_t>(random.NextBelow(256));
  }
  EXPECT_EQ(localizer_->Localize(noise, {})->outcome,
            localizer::Outcome::kNotLocalized);
  image::Frame black = noise;
  std::fill(black.color.rgb.begin(), black.color.rgb.end(), uint8_t{0});
  EXPECT_EQ(localizer_->Localize(black, {})->outcome,
            localizer::Outcome::kNotLocalized);
  image::Frame blind = noise;
  std::fill(blind.depth->values.begin(), blind.depth->values.end(),
            uint16_t{0});
  EXPECT_EQ(localizer_->Localize(blind, {})->reason,
            localizer::NotLocalizedReason::kTooFewSamples);
}

TEST_F(PointsLinesLocalizerTest, RefusesFramesAndModelsItCannotUse) {
  image::Frame without_depth = HeldOutFrame(0);
  without_depth.depth.reset();
  EXPECT_THAT(localizer_->Localize(without_depth, {}).status().ToString(),
              HasSubstr("needs a depth image"));
  const auto model = forest::ModelFile::Open(ModelPath());
  ASSERT_TRUE(model.ok());
  const std::string path = *folder_ + "/one.treeline";
  ASSERT_TRUE(
      forest::WriteModel(path, (*model)->info(), {(*model)->forest()}).ok());
  const absl::Status status = localizer::OpenLocalizer(path).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(status.ToString(), HasSubstr("two forests"));
}

TEST_F(PointsLinesLocalizerTest, StopsWhenAsked) {
  std::stop_source stop;
  stop.request_stop();
  localizer::LocalizeOptions options;
  options.stop = stop.get_token();
  EXPECT_EQ(localizer_->Localize(HeldOutFrame(0), options).status().code(),
            absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace treeline
