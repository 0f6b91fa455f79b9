// Scenes trained by every way there is, and what their localizers answer.
#include "server/core/training/scene_trainer.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/forest/model_file.h"
#include "server/core/keyframes/direct_alignment.h"
#include "server/core/localizer/localizer.h"
#include "server/core/recognition/scene_index.h"
#include "server/core/training/appearance_builder.h"
#include "server/core/training/box_room_recording.h"
#include "server/core/training/tree_part.h"
#include "server/core/training/trial_views.h"

namespace treeline {
namespace {

using testing::HasSubstr;

class SceneTrainerTest : public testing::Test {
 protected:
  static constexpr int kFrames = 80;

  static void SetUpTestSuite() {
    folder_ = new std::string(testing::TempDir() + "/scene_trainer_test_" +
                              std::to_string(getpid()));
    training::WriteBoxRoomRecording(*folder_, Calibration(),
                                    training::BoxRoomPoses(kFrames));
    dataset::DatasetOptions recording;
    recording.uri = "7scenes:" + *folder_;
    recording.color_camera = "PINHOLE,145,145,100,75";
    recording.depth_camera = recording.color_camera;
    dataset_ = new dataset::Dataset(*dataset::Dataset::Open(recording));
  }
  static void TearDownTestSuite() {
    delete dataset_;
    std::filesystem::remove_all(*folder_);
    delete folder_;
  }

  static camera::RgbdCalibration Calibration() {
    camera::RgbdCalibration calibration = training::BoxRoomCalibration();
    calibration.pose_sensor = camera::RgbdSensor::kDepth;
    return calibration;
  }
  static training::SceneTrainingOptions Options(const std::string& method) {
    training::SceneTrainingOptions options;
    options.method = method;
    options.calibration = Calibration();
    options.forest.samples_per_frame = 300;
    options.forest.trees = 3;
    return options;
  }
  static std::string Path(const std::string& name) {
    return *folder_ + "/" + name + ".treeline";
  }
  static absl::StatusOr<training::TrainedScene> Train(
      const dataset::Dataset& dataset,
      const training::SceneTrainingOptions& options, const std::string& name) {
    return training::TrainScene(dataset, options, Path(name), true, {});
  }
  // A pose between those of training.
  static geometry::Rigid3 HeldOutPose(int i) {
    return training::BoxRoomPoses(2 * kFrames)[static_cast<size_t>(2 * i + 1)];
  }

  // Depth that is off by one factor is corrected, and that which is right is
  // not.
  static void ExpectCorrectsDepth(const localizer::Localizer& localizer) {
    for (const double factor : {0.94, 1.05}) {
      int right = 0;
      for (int i = 0; i < 12; ++i) {
        const geometry::Rigid3 truth = HeldOutPose(7 * i);
        image::Frame frame = training::RenderBoxRoom(Calibration(), truth);
        for (uint16_t& depth : frame.depth->values) {
          depth = static_cast<uint16_t>(std::lround(factor * depth));
        }
        const auto estimate = localizer.Localize(frame, {});
        ASSERT_TRUE(estimate.ok()) << estimate.status();
        if (estimate->outcome != localizer::Outcome::kLocalized) continue;
        const geometry::PoseError error =
            geometry::ErrorBetween(estimate->world_from_camera, truth);
        EXPECT_LT(error.translation_m, 0.1) << "a wrong pose passed for right";
        right += error.translation_m < 0.05 &&
                 std::abs(estimate->depth_scale * factor - 1) < 0.02;
      }
      EXPECT_GE(right, 9) << factor;
    }
    const image::Frame frame =
        training::RenderBoxRoom(Calibration(), HeldOutPose(0));
    const auto estimate = localizer.Localize(frame, {});
    ASSERT_TRUE(estimate.ok()) << estimate.status();
    EXPECT_EQ(estimate->depth_scale, 1);
  }
  // Of 16 views spread over the room, those placed within 5 cm and 5 degrees.
  static int CountRight(const localizer::Localizer& localizer,
                        bool with_depth) {
    int right = 0;
    for (int i = 0; i < 16; ++i) {
      const geometry::Rigid3 truth = HeldOutPose(5 * i);
      image::Frame frame = training::RenderBoxRoom(Calibration(), truth);
      if (!with_depth) frame.depth.reset();
      const auto estimate = localizer.Localize(frame, {});
      EXPECT_TRUE(estimate.ok()) << estimate.status();
      if (estimate->outcome != localizer::Outcome::kLocalized) continue;
      EXPECT_GE(estimate->confidence, 0.5);
      const geometry::PoseError error =
          geometry::ErrorBetween(estimate->world_from_camera, truth);
      right += error.translation_m < 0.05 && error.rotation_rad < 0.087;
    }
    return right;
  }

  static std::string* folder_;
  static dataset::Dataset* dataset_;
};
std::string* SceneTrainerTest::folder_ = nullptr;
dataset::Dataset* SceneTrainerTest::dataset_ = nullptr;

TEST_F(SceneTrainerTest, RgbNeedsNoDepthInQueries) {
  const auto scene = Train(*dataset_, Options("rgb"), "rgb");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(scene->info.method, "rgb");
  EXPECT_EQ(scene->info.calibration.pose_sensor, camera::RgbdSensor::kColor);
  EXPECT_TRUE(scene->info.confidence.has_value());
  const auto localizer = localizer::OpenLocalizer(Path("rgb"));
  ASSERT_TRUE(localizer.ok()) << localizer.status();
  EXPECT_GE(CountRight(**localizer, false), 13);
}

TEST_F(SceneTrainerTest, UniversalAnswersWithDepthAndWithout) {
  const auto scene = Train(*dataset_, Options("universal"), "universal");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(scene->info.calibration.pose_sensor, camera::RgbdSensor::kColor);
  const auto localizer = localizer::OpenLocalizer(Path("universal"));
  ASSERT_TRUE(localizer.ok()) << localizer.status();
  EXPECT_EQ((*localizer)->depth_use(), localizer::DepthUse::kWhereGiven);
  EXPECT_GE(CountRight(**localizer, true), 14);
  EXPECT_GE(CountRight(**localizer, false), 14);
  ExpectCorrectsDepth(**localizer);
}

TEST_F(SceneTrainerTest, UniversalAnswersInAnotherLight) {
  ASSERT_TRUE(Train(*dataset_, Options("universal"), "universal").ok());
  const auto localizer = localizer::OpenLocalizer(Path("universal"));
  ASSERT_TRUE(localizer.ok());
  int right = 0;
  for (int i = 0; i < 16; ++i) {
    const geometry::Rigid3 truth = HeldOutPose(5 * i);
    const image::Frame dim =
        training::Relit(training::RenderBoxRoom(Calibration(), truth),
                        {.gain = {0.45, 0.4, 0.35}});
    const auto estimate = (*localizer)->Localize(dim, {});
    ASSERT_TRUE(estimate.ok());
    if (estimate->outcome != localizer::Outcome::kLocalized) continue;
    const geometry::PoseError error =
        geometry::ErrorBetween(estimate->world_from_camera, truth);
    EXPECT_LT(error.translation_m, 0.1) << "a wrong pose passed for right";
    right += error.translation_m < 0.05 && error.rotation_rad < 0.087;
  }
  EXPECT_GE(right, 12);
}

TEST_F(SceneTrainerTest, UniversalRefusesAPhotographOfTheScene) {
  ASSERT_TRUE(Train(*dataset_, Options("universal"), "universal").ok());
  const auto localizer = localizer::OpenLocalizer(Path("universal"));
  ASSERT_TRUE(localizer.ok());
  int contradicted = 0;
  for (int i = 0; i < 16; ++i) {
    image::Frame frame =
        training::RenderBoxRoom(Calibration(), HeldOutPose(5 * i));
    // It hangs half a metre away.
    std::ranges::fill(frame.depth->values, uint16_t{500});
    const auto estimate = (*localizer)->Localize(frame, {});
    ASSERT_TRUE(estimate.ok());
    EXPECT_EQ(estimate->outcome, localizer::Outcome::kNotLocalized);
    contradicted +=
        estimate->reason == localizer::NotLocalizedReason::kContradictsDepth;
  }
  // Where colour alone finds the pose.
  EXPECT_GE(contradicted, 8);
}

TEST_F(SceneTrainerTest, AnswersNothingThatItHasNotSeen) {
  for (const std::string method : {"rgb", "rgbd", "universal"}) {
    ASSERT_TRUE(Train(*dataset_, Options(method), method).ok());
    const auto localizer = localizer::OpenLocalizer(Path(method));
    ASSERT_TRUE(localizer.ok());
    image::Frame frame = training::RenderBoxRoom(Calibration(), HeldOutPose(3));
    std::ranges::fill(frame.color.rgb, uint8_t{90});
    EXPECT_EQ((*localizer)->Localize(frame, {})->outcome,
              localizer::Outcome::kNotLocalized);
    base::Random random(1, 2);
    for (uint8_t& value : frame.color.rgb) {
      value = static_cast<uint8_t>(random.NextBelow(256));
    }
    EXPECT_EQ((*localizer)->Localize(frame, {})->outcome,
              localizer::Outcome::kNotLocalized);
  }
}

TEST_F(SceneTrainerTest, AForestOfOneSceneServesAnother) {
  // The base knows another room: this one's frames with channels exchanged
  // would do, but any trees will; these were grown on a few frames.
  const std::vector<int> few = {0, 5, 10, 15, 20};
  training::SceneTrainingOptions base = Options("rgbd");
  base.splits_only = true;
  base.forest.max_depth = 10;
  const auto splits = Train(dataset_->Subset(few), base, "base");
  ASSERT_TRUE(splits.ok()) << splits.status();
  EXPECT_EQ(splits->info.leaves, 1);
  EXPECT_EQ(recognition::ReadSceneDescriptor(Path("base")).status().code(),
            absl::StatusCode::kNotFound);

  training::SceneTrainingOptions adapt = Options("rgbd");
  adapt.base_model = Path("base");
  adapt.refill = training::Refill::kAdapt;
  const auto adapted = Train(*dataset_, adapt, "adapted");
  ASSERT_TRUE(adapted.ok()) << adapted.status();
  const auto localizer = localizer::OpenLocalizer(Path("adapted"));
  ASSERT_TRUE(localizer.ok());
  EXPECT_GE(CountRight(**localizer, true), 13);
  const auto descriptor = recognition::ReadSceneDescriptor(Path("adapted"));
  ASSERT_TRUE(descriptor.ok()) << descriptor.status();
  EXPECT_EQ(descriptor->images(), static_cast<uint32_t>(kFrames));

  adapt.method = "rgb";
  EXPECT_THAT(Train(*dataset_, adapt, "x").status().message(),
              HasSubstr("no base for method rgb"));
}

TEST_F(SceneTrainerTest, AModelIsExtendedByMoreFrames) {
  std::vector<int> first;
  std::vector<int> rest;
  for (int i = 0; i < kFrames; ++i) {
    (i < kFrames / 2 ? first : rest).push_back(i);
  }
  ASSERT_TRUE(Train(dataset_->Subset(first), Options("rgbd"), "half").ok());
  training::SceneTrainingOptions extend = Options("rgbd");
  extend.base_model = Path("half");
  extend.refill = training::Refill::kExtend;
  ASSERT_TRUE(Train(dataset_->Subset(rest), extend, "whole").ok());
  const auto half = localizer::OpenLocalizer(Path("half"));
  const auto whole = localizer::OpenLocalizer(Path("whole"));
  ASSERT_TRUE(half.ok() && whole.ok());
  EXPECT_EQ((*half)->info().confidence, (*whole)->info().confidence);
  const int right_before = CountRight(**half, true);
  const int right_after = CountRight(**whole, true);
  EXPECT_LE(right_before, 10);
  EXPECT_GE(right_after, 13);
  // What the scene looks like is what both looked like.
  const auto all = training::BuildSceneDescriptor(*dataset_, {}, true, {});
  const auto extended = recognition::ReadSceneDescriptor(Path("whole"));
  ASSERT_TRUE(all.ok() && extended.ok());
  EXPECT_EQ(*extended, *all);
}

TEST_F(SceneTrainerTest, WhatASceneLooksLikeDoesNotDependOnThreads) {
  const auto one =
      training::BuildSceneDescriptor(*dataset_, {.threads = 1}, true, {});
  const auto eight =
      training::BuildSceneDescriptor(*dataset_, {.threads = 8}, true, {});
  ASSERT_TRUE(one.ok() && eight.ok());
  EXPECT_EQ(*one, *eight);
  EXPECT_GT(one->Fill(), 0.001);
  const auto few =
      training::BuildSceneDescriptor(*dataset_, {.max_images = 10}, true, {});
  EXPECT_EQ(few->images(), 10u);
  EXPECT_LT(few->Fill(), one->Fill());
}

TEST_F(SceneTrainerTest, ASceneIsToldByWhatItLooksLike) {
  const auto room = training::BuildSceneDescriptor(*dataset_, {}, true, {});
  ASSERT_TRUE(room.ok());
  recognition::SceneIndex index;
  index.Set("room", *room);
  // The same words with others' numbers: a scene as rich that is another.
  recognition::SceneDescriptor other;
  std::vector<uint32_t> words;
  for (uint32_t entry = 0; entry < room->bits().size(); ++entry) {
    for (uint32_t bit = 0; bit < 64; ++bit) {
      if ((room->bits()[entry] >> bit & 1) != 0) {
        words.push_back((64 * entry + bit) ^ 0x1555);
      }
    }
  }
  other.Add(words);
  index.Set("other", other);
  for (int i = 0; i < 16; ++i) {
    const image::Frame frame =
        training::RenderBoxRoom(Calibration(), HeldOutPose(5 * i));
    EXPECT_EQ(index.Rank(frame)[0].scene, "room") << i;
  }
}

TEST_F(SceneTrainerTest, AlignmentPullsAPoseIn) {
  ASSERT_TRUE(Train(*dataset_, Options("rgbd"), "align").ok());
  const auto model = forest::ModelFile::Open(Path("align"));
  ASSERT_TRUE(model.ok());
  const auto map = keyframes::KeyframeMap::Read(**model);
  ASSERT_TRUE(map.ok());
  ASSERT_GT(map->size(), 3u);
  int pulled_in = 0;
  for (int i = 0; i < 8; ++i) {
    const geometry::Rigid3 truth = HeldOutPose(10 * i);
    const image::Frame frame = training::RenderBoxRoom(Calibration(), truth);
    features::GrayPyramid pyramid;
    pyramid.Assign(features::PlanarImage(frame.color));
    const geometry::Rigid3 guess{
        truth.rotation *
            geometry::Rotation3::FromAxisAngle({0.01, -0.01, 0.01}),
        truth.translation + geometry::Vec3{0.02, -0.015, 0.01}};
    for (const bool with_depth : {false, true}) {
      const auto aligned = keyframes::AlignToKeyframes(
          *map, pyramid, with_depth ? &*frame.depth : nullptr, Calibration(),
          guess, {});
      ASSERT_TRUE(aligned);
      EXPECT_EQ(aligned->measured > 0, with_depth);
      const geometry::PoseError before = geometry::ErrorBetween(guess, truth);
      const geometry::PoseError after =
          geometry::ErrorBetween(aligned->world_from_camera, truth);
      pulled_in += after.translation_m < 0.5 * before.translation_m &&
                   aligned->correlation > 0.8;
    }
  }
  EXPECT_GE(pulled_in, 13);
}

TEST_F(SceneTrainerTest, ExplainsBadRequests) {
  EXPECT_EQ(Train(*dataset_, Options("magic"), "x").status().code(),
            absl::StatusCode::kInvalidArgument);
  training::SceneTrainingOptions options = Options("rgbd");
  options.base_model = Path("nowhere");
  EXPECT_EQ(Train(*dataset_, options, "x").status().code(),
            absl::StatusCode::kNotFound);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(training::TrainScene(*dataset_, Options("rgbd"), Path("x"), true,
                                 stop.get_token())
                .status()
                .code(),
            absl::StatusCode::kCancelled);
  EXPECT_FALSE(std::filesystem::exists(Path("x")));
}

// The bytes of all forests and extra sections of a model, one after the other.
std::string ContentOf(const std::string& path) {
  const auto model = forest::ModelFile::Open(path);
  EXPECT_TRUE(model.ok()) << model.status();
  std::string content;
  const auto add = [&](const auto& values) {
    content.append(reinterpret_cast<const char*>(values.data()),
                   values.size_bytes());
    content += '|';
  };
  for (size_t f = 0; f < (*model)->forests(); ++f) {
    const forest::ForestView& forest = (*model)->forest(f);
    add(forest.nodes);
    add(forest.tree_offsets);
    add(forest.descriptors);
    add(forest.payloads);
    add(std::span(&forest.bounds_min_in_world, 1));
    add(std::span(&forest.bounds_max_in_world, 1));
  }
  for (uint32_t kind = 8; kind < 32; ++kind) {
    add(*(*model)->Extra<char>(static_cast<forest::ModelExtra>(kind)));
  }
  return content;
}

class PartsTest : public SceneTrainerTest {
 protected:
  // Grows each tree by itself; the files, last tree first.
  static std::vector<std::string> GrowParts(
      const training::SceneTrainingOptions& options) {
    std::vector<std::string> paths;
    for (int tree = options.forest.trees - 1; tree >= 0; --tree) {
      paths.push_back(Path(absl::StrCat("part-", options.method, "-", tree)));
      const auto part =
          training::TrainTree(*dataset_, options, tree, paths.back(), true, {});
      EXPECT_TRUE(part.ok()) << part.status();
    }
    return paths;
  }
  static absl::StatusOr<training::TrainedScene> Merge(
      const dataset::Dataset& dataset, const std::vector<std::string>& parts,
      const std::string& version = "") {
    training::SceneTrainingOptions options;
    options.software_version = version;
    return training::MergeScene(dataset, parts, options, Path("merged"), true,
                                {});
  }
  static void ExpectSameAsAlone(const std::string& method) {
    const training::SceneTrainingOptions options = Options(method);
    const auto alone = Train(*dataset_, options, "alone");
    ASSERT_TRUE(alone.ok()) << alone.status();
    const auto merged = Merge(*dataset_, GrowParts(options));
    ASSERT_TRUE(merged.ok()) << merged.status();
    EXPECT_TRUE(ContentOf(Path("merged")) == ContentOf(Path("alone")));
    EXPECT_EQ(merged->info.training_frames, alone->info.training_frames);
    EXPECT_EQ(merged->info.training_samples, alone->info.training_samples);
    EXPECT_FALSE(merged->info.part.has_value());
    ASSERT_TRUE(merged->info.confidence && alone->info.confidence);
    EXPECT_EQ(merged->info.confidence->threshold,
              alone->info.confidence->threshold);
    EXPECT_EQ(merged->info.confidence->weights,
              alone->info.confidence->weights);
  }
};

TEST_F(PartsTest, ManyMachinesMakeTheSceneOfOne) {
  ExpectSameAsAlone("universal");
}

TEST_F(PartsTest, ManyMachinesMakeTheSceneOfOneWithTwoForests) {
  ExpectSameAsAlone("points-lines");
}

TEST_F(PartsTest, APartAnswersNoQueriesAndSaysWhatToDo) {
  const std::string part = GrowParts(Options("rgbd")).front();
  const auto localizer = localizer::OpenLocalizer(part);
  EXPECT_EQ(localizer.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(localizer.status().message(), HasSubstr("treeline merge"));
}

TEST_F(PartsTest, PartsThatMakeNoSceneAreRefusedByName) {
  const std::vector<std::string> parts = GrowParts(Options("rgbd"));
  EXPECT_THAT(Merge(*dataset_, {}).status().message(), HasSubstr("no parts"));
  EXPECT_THAT(Merge(*dataset_, {parts[0], parts[2]}).status().message(),
              HasSubstr("tree 1 of 3 is missing"));
  EXPECT_THAT(Merge(*dataset_, {parts[0], parts[1], parts[1], parts[2]})
                  .status()
                  .message(),
              HasSubstr("are both tree 1"));
  EXPECT_THAT(Merge(*dataset_, parts, "9.9").status().message(),
              HasSubstr("this is 9.9"));

  const std::vector<int> fewer = {0, 1, 2, 3};
  EXPECT_THAT(Merge(dataset_->Subset(fewer), parts).status().message(),
              HasSubstr("not the frames and poses"));

  training::SceneTrainingOptions other = Options("rgbd");
  other.forest.seed = 7;
  ASSERT_TRUE(
      training::TrainTree(*dataset_, other, 1, Path("seed"), true, {}).ok());
  EXPECT_THAT(
      Merge(*dataset_, {parts[0], Path("seed"), parts[2]}).status().message(),
      HasSubstr("differ in seed: 0 and 7"));

  other = Options("rgbd");
  other.calibration->depth_scale = 1.001;
  ASSERT_TRUE(
      training::TrainTree(*dataset_, other, 1, Path("scaled"), true, {}).ok());
  EXPECT_THAT(
      Merge(*dataset_, {parts[0], Path("scaled"), parts[2]}).status().message(),
      HasSubstr("differ in calibration"));

  ASSERT_TRUE(Train(*dataset_, Options("rgbd"), "whole").ok());
  EXPECT_THAT(Merge(*dataset_, {Path("whole")}).status().message(),
              HasSubstr("a whole scene"));
}

TEST_F(PartsTest, ATreeIsGrownAloneOnlyWhereThatIsPossible) {
  const auto grow = [](const training::SceneTrainingOptions& options,
                       int tree) {
    return training::TrainTree(*dataset_, options, tree, Path("no"), true, {})
        .status();
  };
  EXPECT_THAT(grow(Options("rgbd"), 3).message(),
              HasSubstr("no tree 3 among 3"));
  EXPECT_EQ(grow(Options("rgbd"), -1).code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(grow(Options("sift"), 0).code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_FALSE(std::filesystem::exists(Path("no")));
}

TEST_F(PartsTest, PartsThatContradictThemselvesAreRefused) {
  const std::string path = GrowParts(Options("rgbd")).front();
  const auto part = training::ReadTreePart(path);
  ASSERT_TRUE(part.ok()) << part.status();

  training::TreePart nowhere = *part;
  nowhere.trees.front().leaves.front().mean_in_world.x = 1e300;
  ASSERT_TRUE(training::WriteTreePart(Path("nowhere"), nowhere).ok());
  EXPECT_EQ(training::ReadTreePart(Path("nowhere")).status().code(),
            absl::StatusCode::kDataLoss);

  // A forest too few for what the method learns.
  training::TreePart lone = *part;
  lone.info.part->trees = 1;
  lone.info.part->tree = 0;
  lone.trees.resize(1);
  ASSERT_TRUE(training::WriteTreePart(Path("lone"), lone).ok());
  EXPECT_THAT(Merge(*dataset_, {Path("lone")}).status().message(),
              HasSubstr("has 2 forests to learn"));
}

}  // namespace
}  // namespace treeline
