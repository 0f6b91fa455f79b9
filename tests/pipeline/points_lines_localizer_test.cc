#include "server/core/localizer/points_lines_localizer.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "common/base/parallel_for.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/training/box_room_recording.h"
#include "server/core/training/scene_trainer.h"

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
    WriteBoxRoomRecording(*folder_, Calibration(), BoxRoomPoses(kFrames),
                          BoxRoomWalls::kTiled);
    const absl::StatusOr<TrainedScene> trained = Train(ModelPath(), 2);
    ASSERT_TRUE(trained.ok()) << trained.status();
    info_ = new ModelInfo(trained->info);
    localizer_ = OpenLocalizer(ModelPath())->release();
  }
  static void TearDownTestSuite() {
    delete localizer_;
    delete info_;
    std::filesystem::remove_all(*folder_);
    delete folder_;
  }

  static std::string ModelPath() { return *folder_ + "/model.treeline"; }

  static absl::StatusOr<TrainedScene> Train(const std::string& path,
                                            int threads) {
    DatasetOptions recording;
    recording.uri = "7scenes:" + *folder_;
    recording.color_camera = "PINHOLE,145,145,100,75";
    recording.depth_camera = recording.color_camera;
    const auto dataset = Dataset::Open(recording);
    if (!dataset.ok()) return dataset.status();
    SceneTrainingOptions options;
    options.method = "points-lines";
    options.calibration = Calibration();
    options.forest.trees = 3;
    options.forest.samples_per_frame = 300;
    options.forest.threads = threads;
    return TrainScene(*dataset, options, path, true, {});
  }

  // Depth and colour sit apart, poses are the depth camera's.
  static RgbdCalibration Calibration() {
    RgbdCalibration calibration = BoxRoomCalibration();
    calibration.color_from_depth.translation = {-0.025, 0, 0};
    calibration.pose_sensor = RgbdSensor::kDepth;
    return calibration;
  }

  // A pose between those of training.
  static Rigid3 HeldOutPose(int i) {
    const Rigid3 a = BoxRoomPoses(2 * kFrames)[static_cast<size_t>(2 * i + 1)];
    return {a.rotation, a.translation + Vec3{0.02, -0.01, 0.03}};
  }
  static Frame HeldOutFrame(int i) {
    return RenderBoxRoom(Calibration(), HeldOutPose(i), BoxRoomWalls::kTiled);
  }

  static std::string* folder_;
  static ModelInfo* info_;
  static Localizer* localizer_;
};
std::string* PointsLinesLocalizerTest::folder_ = nullptr;
ModelInfo* PointsLinesLocalizerTest::info_ = nullptr;
Localizer* PointsLinesLocalizerTest::localizer_ = nullptr;

TEST_F(PointsLinesLocalizerTest, TheModelHasAForestForEachKindOfPoint) {
  const auto model = ModelFile::Open(ModelPath());
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
    if (estimate->outcome != Outcome::kLocalized) continue;
    const PoseError error =
        ErrorBetween(estimate->world_from_camera, HeldOutPose(3 * i));
    EXPECT_LT(error.translation_m, 0.1) << "a wrong pose passed for right";
    correct += error.translation_m < 0.05 && error.rotation_rad < 0.087;
  }
  EXPECT_GE(correct, 9);
}

TEST_F(PointsLinesLocalizerTest, TheSameSeedGivesTheSameBitsFromAnyThread) {
  const Frame frame = HeldOutFrame(7);
  LocalizeOptions options;
  options.seed = 5;
  const auto first = localizer_->Localize(frame, options);
  ASSERT_TRUE(first.ok());
  std::vector<Rigid3> poses(8);
  ParallelFor(8, 4, [&](int64_t i) {
    poses[static_cast<size_t>(i)] =
        localizer_->Localize(frame, options)->world_from_camera;
  });
  for (const Rigid3& pose : poses) {
    EXPECT_EQ(pose, first->world_from_camera);
  }
}

TEST_F(PointsLinesLocalizerTest, TheModelDoesNotDependOnTheNumberOfThreads) {
  const std::string path = *folder_ + "/again.treeline";
  const auto again = Train(path, 1);
  ASSERT_TRUE(again.ok());
  const auto a = ModelFile::Open(ModelPath());
  const auto b = ModelFile::Open(path);
  ASSERT_TRUE(a.ok() && b.ok());
  for (const size_t f : {0u, 1u}) {
    EXPECT_TRUE(std::ranges::equal((*a)->forest(f).nodes, (*b)->forest(f).nodes,
                                   [](const Node& x, const Node& y) {
                                     return x.lo == y.lo && x.hi == y.hi;
                                   }));
  }
}

TEST_F(PointsLinesLocalizerTest, UsesPointsOfBothKinds) {
  LocalizeOptions options;
  options.keep_correspondences = true;
  const auto estimate = localizer_->Localize(HeldOutFrame(7), options);
  ASSERT_TRUE(estimate.ok());
  EXPECT_EQ(estimate->samples, QueryOptions().samples);
  EXPECT_EQ(estimate->correspondences.size(),
            static_cast<size_t>(estimate->samples));
  // General points are as far off as a depth pixel says, in whole millimetres;
  // points on lines are anywhere.
  int on_lines = 0;
  for (const Correspondence& c : estimate->correspondences) {
    const double z_mm = 1000 * c.point_in_camera.z;
    on_lines += c.inlier && std::abs(z_mm - std::round(z_mm)) > 1e-3;
  }
  EXPECT_GT(on_lines, 20);
  EXPECT_LE(on_lines, QueryOptions().samples / 2);
}

TEST_F(PointsLinesLocalizerTest, WithoutLinesPointsAloneAnswer) {
  // The room without its tiles has no straight edges, and is another room.
  const auto estimate = localizer_->Localize(
      RenderBoxRoom(Calibration(), HeldOutPose(7), BoxRoomWalls::kSmooth), {});
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  EXPECT_EQ(estimate->samples, QueryOptions().samples);
}

TEST_F(PointsLinesLocalizerTest, DoesNotLocalizeWhatItHasNotSeen) {
  Random random(1, 0);
  Frame noise = HeldOutFrame(0);
  for (uint8_t& value : noise.color.rgb) {
    value = static_cast<uint8_t>(random.NextBelow(256));
  }
  EXPECT_EQ(localizer_->Localize(noise, {})->outcome, Outcome::kNotLocalized);
  Frame black = noise;
  std::fill(black.color.rgb.begin(), black.color.rgb.end(), uint8_t{0});
  EXPECT_EQ(localizer_->Localize(black, {})->outcome, Outcome::kNotLocalized);
  Frame blind = noise;
  std::fill(blind.depth->values.begin(), blind.depth->values.end(),
            uint16_t{0});
  EXPECT_EQ(localizer_->Localize(blind, {})->reason,
            NotLocalizedReason::kTooFewSamples);
}

TEST_F(PointsLinesLocalizerTest, RefusesFramesAndModelsItCannotUse) {
  Frame without_depth = HeldOutFrame(0);
  without_depth.depth.reset();
  EXPECT_THAT(localizer_->Localize(without_depth, {}).status().ToString(),
              HasSubstr("needs a depth image"));
  const auto model = ModelFile::Open(ModelPath());
  ASSERT_TRUE(model.ok());
  const std::string path = *folder_ + "/one.treeline";
  ASSERT_TRUE(WriteModel(path, (*model)->info(), {(*model)->forest()}).ok());
  const absl::Status status = OpenLocalizer(path).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(status.ToString(), HasSubstr("two forests"));
}

TEST_F(PointsLinesLocalizerTest, StopsWhenAsked) {
  std::stop_source stop;
  stop.request_stop();
  LocalizeOptions options;
  options.stop = stop.get_token();
  EXPECT_EQ(localizer_->Localize(HeldOutFrame(0), options).status().code(),
            absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace treeline
