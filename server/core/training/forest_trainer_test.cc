#include "server/core/training/forest_trainer.h"

#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <numeric>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/training/box_room_recording.h"

namespace treeline::training {
namespace {

class ForestTrainerTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new std::string(testing::TempDir() + "/forest_trainer_test_" +
                              std::to_string(getpid()));
    camera::RgbdCalibration calibration = BoxRoomCalibration();
    calibration.pose_sensor = camera::RgbdSensor::kDepth;
    WriteBoxRoomRecording(*folder_, calibration, BoxRoomPoses(12));
  }
  static void TearDownTestSuite() {
    std::filesystem::remove_all(*folder_);
    delete folder_;
  }

  static dataset::DatasetOptions Recording() {
    dataset::DatasetOptions options;
    options.uri = "7scenes:" + *folder_;
    options.color_camera = "PINHOLE,145,145,100,75";
    options.depth_camera = options.color_camera;
    return options;
  }
  static TrainingOptions Small() {
    TrainingOptions options;
    options.trees = 3;
    options.samples_per_frame = 200;
    options.threads = 2;
    return options;
  }
  static absl::StatusOr<TrainedForest> Train(const TrainingOptions& options) {
    const auto dataset = dataset::Dataset::Open(Recording());
    if (!dataset.ok()) return dataset.status();
    return TrainForest(*dataset, dataset->calibration(), options, true, {});
  }

  // Of the recording's first frames; kFirst of them before the others.
  static absl::StatusOr<TrainedForests> TrainInRounds(
      const TrainingOptions& options, int frames);

  static std::string* folder_;
};
std::string* ForestTrainerTest::folder_ = nullptr;

bool SameBytes(const forest::Forest& a, const forest::Forest& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() &&
           std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0;
  };
  return same(a.nodes, b.nodes) && same(a.tree_offsets, b.tree_offsets) &&
         same(a.descriptors, b.descriptors) && same(a.payloads, b.payloads) &&
         a.bounds_min_in_world == b.bounds_min_in_world &&
         a.bounds_max_in_world == b.bounds_max_in_world;
}

TEST_F(ForestTrainerTest, SmallLeavesAreLeftOut) {
  TrainingOptions options = Small();
  options.min_kept_samples = 3;
  const auto trained = Train(options);
  ASSERT_TRUE(trained.ok()) << trained.status();
  const forest::ForestView forest = trained->forest.View();
  EXPECT_TRUE(forest.Validate().ok()) << forest.Validate();
  options.min_kept_samples = 1;
  EXPECT_LT(forest.payloads.size(), Train(options)->forest.payloads.size());
  for (const forest::LeafPayload& leaf : forest.payloads) {
    EXPECT_GE(leaf.count, 3);
  }
}

TEST_F(ForestTrainerTest, GrowsASoundForestWithinTheRoom) {
  TrainingOptions options = Small();
  options.min_kept_samples = 1;
  const auto trained = Train(options);
  ASSERT_TRUE(trained.ok()) << trained.status();
  EXPECT_EQ(trained->frames, 12);
  EXPECT_EQ(trained->samples, 3 * 12 * 200);
  const forest::ForestView forest = trained->forest.View();
  EXPECT_TRUE(forest.Validate().ok()) << forest.Validate();
  EXPECT_EQ(forest.trees(), 3);
  // All samples lie on walls of the 4 x 2.5 x 3 m room, and so within a
  // millimetre (of depth) of its bounds.
  EXPECT_GE(forest.bounds_min_in_world.x, -2.002);
  EXPECT_LE(forest.bounds_max_in_world.x, 2.002);
  EXPECT_GE(forest.bounds_min_in_world.z, -1.502);
  EXPECT_LE(forest.bounds_max_in_world.z, 1.502);
  int64_t counted = 0;
  for (const forest::LeafPayload& leaf : forest.payloads) {
    EXPECT_GE(leaf.count, 1);
    counted += leaf.count;
  }
  EXPECT_EQ(counted, trained->samples) << "every sample is in one leaf a tree";
}

TEST_F(ForestTrainerTest, DoesNotDependOnTheNumberOfThreads) {
  TrainingOptions options = Small();
  options.threads = 1;
  const auto one = Train(options);
  ASSERT_TRUE(one.ok()) << one.status();
  for (int threads : {2, 8}) {
    options.threads = threads;
    const auto many = Train(options);
    ASSERT_TRUE(many.ok());
    EXPECT_TRUE(SameBytes(one->forest, many->forest)) << threads;
  }
}

TEST_F(ForestTrainerTest, DoesNotDependOnHowManyTreesFitIntoMemory) {
  TrainingOptions options = Small();
  const auto together = Train(options);
  options.image_memory_bytes = 1;  // one tree at a time
  const auto apart = Train(options);
  ASSERT_TRUE(together.ok() && apart.ok());
  EXPECT_TRUE(SameBytes(together->forest, apart->forest));
}

constexpr int kFirst[] = {0, 1, 2, 6, 7, 8};

absl::StatusOr<TrainedForests> ForestTrainerTest::TrainInRounds(
    const TrainingOptions& options, int frames) {
  const auto dataset = dataset::Dataset::Open(Recording());
  if (!dataset.ok()) return dataset.status();
  std::vector<int> all(static_cast<size_t>(frames));
  std::iota(all.begin(), all.end(), 0);
  return TrainForests(dataset->Subset(all), dataset->calibration(), options,
                      kFirst, true, {});
}

TEST_F(ForestTrainerTest, FramesJoinTreesThatAreGrownWithoutThem) {
  const auto trained = TrainInRounds(Small(), 12);
  ASSERT_TRUE(trained.ok()) << trained.status();
  for (const forest::ForestView& forest :
       {trained->first.View(), trained->all.forest.View()}) {
    EXPECT_TRUE(forest.Validate().ok()) << forest.Validate();
    EXPECT_EQ(forest.trees(), 3);
  }
  const auto count = [](const forest::Forest& forest) {
    int64_t samples = 0;
    for (const forest::LeafPayload& leaf : forest.payloads) {
      EXPECT_GE(leaf.count, 1);
      samples += leaf.count;
    }
    return samples;
  };
  EXPECT_EQ(count(trained->first), 3 * 6 * 200);
  EXPECT_EQ(count(trained->all.forest), 3 * 12 * 200);
  EXPECT_EQ(trained->all.samples, 3 * 12 * 200);
  EXPECT_EQ(trained->all.frames, 12);
}

// Else what the others show of its answers would promise too much.
TEST_F(ForestTrainerTest, TheFirstForestKnowsNothingOfTheFramesThatJoin) {
  const auto trained = TrainInRounds(Small(), 12);
  const auto with_fewer = TrainInRounds(Small(), 9);
  ASSERT_TRUE(trained.ok() && with_fewer.ok());
  EXPECT_TRUE(SameBytes(trained->first, with_fewer->first));
  EXPECT_FALSE(SameBytes(trained->all.forest, with_fewer->all.forest));
}

// A leaf is worth a split as long as its samples lie apart, whether they were
// there first or joined.
TEST_F(ForestTrainerTest, LeavesAreSplitFurtherForFramesThatJoin) {
  TrainingOptions options = Small();
  options.max_depth = 40;
  options.min_spread_m = 0.2;
  const auto trained = TrainInRounds(options, 12);
  const auto at_once = Train(options);
  ASSERT_TRUE(trained.ok() && at_once.ok());
  const auto spread = [](const forest::Forest& forest) {
    double sum = 0;
    for (const forest::LeafPayload& leaf : forest.payloads) {
      for (const size_t k : {0u, 3u, 5u}) {
        sum += leaf.count *
               static_cast<double>(forest::FromBfloat16(leaf.covariance[k]));
      }
    }
    return sum / (3 * 12 * 200);
  };
  EXPECT_LT(spread(trained->all.forest), 1.5 * spread(at_once->forest));
}

TEST_F(ForestTrainerTest, RoundsDependOnNeitherThreadsNorMemory) {
  TrainingOptions options = Small();
  options.threads = 1;
  const auto one = TrainInRounds(options, 12);
  ASSERT_TRUE(one.ok()) << one.status();
  options.threads = 8;
  options.image_memory_bytes = 1;  // one tree at a time
  const auto many = TrainInRounds(options, 12);
  ASSERT_TRUE(many.ok());
  EXPECT_TRUE(SameBytes(one->first, many->first));
  EXPECT_TRUE(SameBytes(one->all.forest, many->all.forest));
}

TEST_F(ForestTrainerTest, EveryTreeHasFirstFrames) {
  TrainingOptions options = Small();
  options.frames_per_tree = 2;
  const auto trained = TrainInRounds(options, 12);
  ASSERT_TRUE(trained.ok()) << trained.status();
  int64_t samples = 0;
  for (const forest::LeafPayload& leaf : trained->first.payloads) {
    samples += leaf.count;
  }
  EXPECT_EQ(samples, 3 * 1 * 200);
  EXPECT_EQ(trained->all.samples, 3 * 2 * 200);
}

TEST_F(ForestTrainerTest, TheSeedDecides) {
  TrainingOptions options = Small();
  const auto a = Train(options);
  options.seed = 1;
  const auto b = Train(options);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_FALSE(SameBytes(a->forest, b->forest));
}

TEST_F(ForestTrainerTest, DrawsASubsetOfFramesForEachTree) {
  TrainingOptions options = Small();
  options.frames_per_tree = 2;
  const auto trained = Train(options);
  ASSERT_TRUE(trained.ok());
  EXPECT_EQ(trained->samples, 3 * 2 * 200);
  EXPECT_GT(trained->frames, 2) << "all trees drew the same frames";
  EXPECT_LE(trained->frames, 6);
}

TEST_F(ForestTrainerTest, BalancedLevelsSplitEvenly) {
  TrainingOptions options = Small();
  options.trees = 1;
  options.balanced_levels = 3;
  options.max_depth = 3;
  options.split_candidates = 200;
  const auto trained = Train(options);
  ASSERT_TRUE(trained.ok());
  // 2400 samples over 8 leaves: with 200 candidates a node each split is
  // within a few per cent of even.
  ASSERT_EQ(trained->forest.payloads.size(), 8u);
  for (const forest::LeafPayload& leaf : trained->forest.payloads) {
    EXPECT_NEAR(leaf.count, 300, 60);
  }
}

TEST_F(ForestTrainerTest, LeavesHaveModesOfSamplesThatLieTogether) {
  TrainingOptions options = Small();
  options.objective = SplitObjective::kEntropy;
  options.mode_bandwidth_m = 0.1;
  options.min_leaf_samples = 10;
  options.max_depth = 6;
  options.threads = 1;
  const auto trained = Train(options);
  ASSERT_TRUE(trained.ok()) << trained.status();
  const forest::ForestView forest = trained->forest.View();
  EXPECT_TRUE(forest.Validate().ok()) << forest.Validate();
  uint32_t most = 0;
  size_t modes = 0;
  for (const forest::Node& node : forest.nodes) {
    if (!node.is_leaf()) continue;
    EXPECT_EQ(node.leaf(), modes) << "modes stand in the order of the leaves";
    modes += node.modes();
    most = std::max(most, node.modes());
  }
  EXPECT_EQ(modes, forest.payloads.size());
  EXPECT_GT(most, 3u);
  for (const forest::LeafPayload& mode : forest.payloads) {
    // Samples of a mode lie within about the bandwidth of its mean.
    EXPECT_LT(forest::FromBfloat16(mode.covariance[0]) +
                  forest::FromBfloat16(mode.covariance[3]) +
                  forest::FromBfloat16(mode.covariance[5]),
              0.2f * 0.2f);
  }
  options.threads = 8;
  const auto again = Train(options);
  ASSERT_TRUE(again.ok());
  EXPECT_TRUE(SameBytes(trained->forest, again->forest));
}

TEST_F(ForestTrainerTest, StopsWhenAsked) {
  const auto dataset = dataset::Dataset::Open(Recording());
  ASSERT_TRUE(dataset.ok());
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(TrainForest(*dataset, dataset->calibration(), Small(), true,
                        stop.get_token())
                .status()
                .code(),
            absl::StatusCode::kCancelled);
}

TEST_F(ForestTrainerTest, SaysWhatIsWrong) {
  TrainingOptions options = Small();
  options.trees = 0;
  EXPECT_THAT(Train(options).status().ToString(),
              testing::HasSubstr("trees is 0"));
  // A frame that vanishes after the index was read.
  const auto dataset = dataset::Dataset::Open(Recording());
  ASSERT_TRUE(dataset.ok());
  const std::string path = dataset->frame(5).color_path;
  std::filesystem::rename(path, path + ".away");
  const absl::Status status =
      TrainForest(*dataset, dataset->calibration(), Small(), true, {}).status();
  std::filesystem::rename(path + ".away", path);
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(status.ToString(), testing::HasSubstr(path));
  // A calibration for images of another size.
  camera::RgbdCalibration other = dataset->calibration();
  other.color = *camera::Camera::Parse("PINHOLE,525,525,320,240", 640, 480);
  EXPECT_EQ(TrainForest(*dataset, other, Small(), true, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace treeline::training
