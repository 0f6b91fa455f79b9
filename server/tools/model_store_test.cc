#include "server/tools/model_store.h"

#include <filesystem>
#include <fstream>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/forest/model_file.h"
#include "server/core/training/box_room_recording.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::tools {
namespace {

using ::testing::HasSubstr;

class ModelStoreTest : public ::testing::Test {
 protected:
  ModelStoreTest() {
    training::WriteBoxRoomRecording(folder_ / "room",
                                    training::BoxRoomCalibration(),
                                    training::BoxRoomPoses(6));
    options_.dataset = BoxRoomOptions(folder_ / "room");
    options_.calibration_name = "given";
    options_.calibration = training::BoxRoomCalibration();
    options_.quiet = true;
    training_.trees = 1;
    training_.samples_per_frame = 50;
  }

  dataset::Dataset Recording() const {
    return dataset::Dataset::Open(options_.dataset).value();
  }
  std::string Checksum(const std::string& path) const {
    return (*forest::ModelFile::Open(path))->info().checksum;
  }

  const TestFolder folder_;
  ModelStoreOptions options_;
  training::TrainingOptions training_;
};

TEST_F(ModelStoreTest, TakesAModelThatIsThereAndFits) {
  const ModelStore store = *ModelStore::Open(folder_ / "models", options_);
  const dataset::Dataset recording = Recording();
  const auto path = store.Train(recording, "rgbd", training_);
  ASSERT_TRUE(path.ok()) << path.status();
  const auto written = std::filesystem::last_write_time(*path);
  const auto again = store.Train(recording, "rgbd", training_);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(*again, *path);
  EXPECT_EQ(std::filesystem::last_write_time(*path), written);
}

TEST_F(ModelStoreTest, TrainsAgainForOtherOptionsAndForDamagedFiles) {
  const ModelStore store = *ModelStore::Open(folder_ / "models", options_);
  const dataset::Dataset recording = Recording();
  const std::string path = *store.Train(recording, "rgbd", training_);
  const std::string checksum = Checksum(path);
  // Not part of the name.
  training_.samples_per_frame = 60;
  EXPECT_EQ(*store.Train(recording, "rgbd", training_), path);
  EXPECT_NE(Checksum(path), checksum);
  std::ofstream(path) << "no model";
  ASSERT_TRUE(store.Train(recording, "rgbd", training_).ok());
  EXPECT_TRUE(forest::ModelFile::Open(path).ok());
}

TEST_F(ModelStoreTest, KeepsModelsOfAnAblationApart) {
  const ModelStore store = *ModelStore::Open(folder_ / "models", options_);
  const dataset::Dataset recording = Recording();
  const std::string balanced = *store.Train(recording, "rgbd", training_);
  training_.balanced_levels = 0;
  const std::string unbalanced = *store.Train(recording, "rgbd", training_);
  EXPECT_NE(balanced, unbalanced);
  EXPECT_THAT(unbalanced, HasSubstr("balanced-levels-0"));
}

TEST_F(ModelStoreTest, ATemporaryFolderGoesWithIt) {
  std::string path;
  {
    const ModelStore store = *ModelStore::Open("", options_);
    path = *store.Train(Recording(), "rgbd", training_);
    EXPECT_TRUE(std::filesystem::exists(path));
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST_F(ModelStoreTest, LeavesNothingWhenInterrupted) {
  std::stop_source source;
  source.request_stop();
  options_.stop = source.get_token();
  const ModelStore store = *ModelStore::Open(folder_ / "models", options_);
  EXPECT_EQ(store.Train(Recording(), "rgbd", training_).status().code(),
            absl::StatusCode::kCancelled);
  EXPECT_TRUE(std::filesystem::is_empty(folder_ / "models"));
}

}  // namespace
}  // namespace treeline::tools
