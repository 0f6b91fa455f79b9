#include "evaluation/accuracy/scene_recognition.h"

#include <filesystem>

#include "evaluation/accuracy/scene_recognition_output.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "server/core/forest/model_file.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::accuracy {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(ParseRecognitionQuery, TakesASceneAndARecording) {
  const auto query = ParseRecognitionQuery("kitchen=7scenes:/a,/b.txt");
  ASSERT_TRUE(query.ok()) << query.status();
  EXPECT_EQ(query->scene, "kitchen");
  EXPECT_EQ(query->source.dataset.uri, "7scenes:/a");
  EXPECT_EQ(query->source.dataset.frame_list, "/b.txt");
  for (const char* text : {"", "kitchen", "=7scenes:/a", "kitchen=nothing"}) {
    EXPECT_FALSE(ParseRecognitionQuery(text).ok()) << text;
  }
}

// Of a scene "a": found, found without a pose, another's, and unreadable.
std::vector<RecognitionTally> SomeTallies() {
  RecognitionTally tally{"a", "7scenes:a", {}};
  tally.frames = {{.stem = "0",
                   .status = {},
                   .rank = 1,
                   .first = "a",
                   .answer = "a",
                   .localized = true,
                   .tried = 1},
                  {.stem = "1",
                   .status = {},
                   .rank = 2,
                   .first = "b",
                   .answer = "a",
                   .localized = false,
                   .tried = 3},
                  {.stem = "2",
                   .status = {},
                   .rank = 4,
                   .first = "b",
                   .answer = "b",
                   .localized = true,
                   .tried = 3},
                  {.stem = "3",
                   .status = absl::DataLossError("<bad>"),
                   .rank = 0,
                   .first = "",
                   .answer = ""}};
  RecognitionTally foreign{"", "builtin", {}};
  foreign.frames = {{.stem = "0",
                     .status = {},
                     .first = "b",
                     .answer = "b",
                     .localized = true,
                     .tried = 1},
                    {.stem = "1",
                     .status = {},
                     .first = "b",
                     .answer = "b",
                     .localized = false,
                     .tried = 1}};
  return {tally, foreign};
}

RecognitionRun SomeRun() {
  RecognitionRun run;
  run.command = "treeline recognize";
  run.scenes = {"a", "b"};
  return run;
}

TEST(RecognitionTally, CountsFramesThatFailedAsWrong) {
  const RecognitionTally tally = SomeTallies()[0];
  EXPECT_EQ(tally.first_in_ranking(), 1);
  EXPECT_EQ(tally.among_first(3), 2);
  EXPECT_EQ(tally.right_scene(), 2);
  EXPECT_EQ(tally.right_localized(), 1);
  EXPECT_EQ(tally.wrong_localized(), 1);
  EXPECT_EQ(tally.errors(), 1);
}

TEST(RecognitionTally, OfForeignFramesEveryPoseIsWrong) {
  const RecognitionTally tally = SomeTallies()[1];
  EXPECT_EQ(tally.first_in_ranking(), 0);
  EXPECT_EQ(tally.right_scene(), 0);
  EXPECT_EQ(tally.wrong_localized(), 1);
}

TEST(RecognitionOutput, TheTableSumsUpScenesAndNotForeignFrames) {
  const std::string table = RecognitionTable(SomeTallies(), SomeRun());
  EXPECT_THAT(table, HasSubstr("all                     4    25.0%    50.0%"));
}

TEST(RecognitionOutput, TheJsonHasEveryFrame) {
  const auto json =
      nlohmann::json::parse(RecognitionJson(SomeTallies(), SomeRun()));
  ASSERT_EQ(json["queries"].size(), 2u);
  EXPECT_EQ(json["queries"][0]["right_scene"], 2);
  EXPECT_EQ(json["queries"][0]["results"][3]["error"], "<bad>");
  EXPECT_EQ(json["queries"][1]["scene"], nullptr);
}

// A model of one leaf, which localizes nothing.
void WriteSmallModel(const std::string& path, bool with_descriptor) {
  std::filesystem::create_directories(
      std::filesystem::path(path).parent_path());
  forest::Forest forest;
  forest.nodes = {forest::Node::Leaf(0)};
  forest.tree_offsets = {0, 1};
  forest.descriptors.resize(1);
  forest.payloads.resize(1);
  forest::ModelInfo info;
  info.method = "rgbd";
  info.calibration.color =
      camera::Camera::Parse("PINHOLE,8,8,4,3", 8, 6).value();
  info.calibration.depth = info.calibration.color;
  const std::string bytes = recognition::SceneDescriptor().Serialize();
  std::vector<forest::ModelExtraBytes> extras;
  if (with_descriptor) extras = {{forest::ModelExtra::kSceneDescriptor, bytes}};
  ASSERT_TRUE(forest::WriteModel(path, info, {forest.View()}, extras).ok());
}

TEST(SceneModelsTest, FindsTheScenesOfAFolder) {
  const tools::TestFolder folder;
  WriteSmallModel(folder / "b/1/model.treeline", false);
  WriteSmallModel(folder / "b/9/model.treeline", false);
  WriteSmallModel(folder / "b/10/model.treeline", true);
  WriteSmallModel(folder / "a/1/model.treeline", true);
  const auto models = SceneModels::Open(folder / "");
  ASSERT_TRUE(models.ok()) << models.status();
  EXPECT_THAT((*models)->scenes(), ElementsAre("a", "b"));
  EXPECT_EQ((*models)->index().size(), 2u);
  EXPECT_TRUE((*models)->Acquire("a").ok());
  EXPECT_FALSE((*models)->Acquire("c").ok());
}

TEST(SceneModelsTest, ModelsWithoutADescriptorAreNamed) {
  const tools::TestFolder folder;
  EXPECT_EQ(SceneModels::Open(folder / "").status().code(),
            absl::StatusCode::kNotFound);
  WriteSmallModel(folder / "a/1/model.treeline", false);
  const absl::Status status = SceneModels::Open(folder / "").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("a/1/model.treeline"));
}

TEST(Recognize, AsksAboutEveryFrameOfEveryQuery) {
  const tools::TestFolder folder;
  WriteSmallModel(folder / "a/1/model.treeline", true);
  WriteSmallModel(folder / "b/1/model.treeline", true);
  const auto models = SceneModels::Open(folder / "");
  ASSERT_TRUE(models.ok()) << models.status();
  const tools::SmallRecording recording(5, {});
  std::vector<RecognitionQuery> queries(2);
  queries[0].scene = "b";
  queries[0].source.name = "recording";
  queries[0].source.dataset = recording.options();
  queries[1].source = ParseForeignSource("builtin,3").value();
  RecognitionOptions options;
  options.every = 2;
  options.quiet = true;
  const auto tallies =
      Recognize(**models, queries, options, base::SteadyClock());
  ASSERT_TRUE(tallies.ok()) << tallies.status();
  ASSERT_EQ((*tallies)[0].frames.size(), 3u);
  ASSERT_EQ((*tallies)[1].frames.size(), 2u);
  // Pictures without a corner are as much like one as like the other.
  EXPECT_EQ((*tallies)[0].frames[0].first, "a");
  EXPECT_EQ((*tallies)[0].frames[0].rank, 2);
  EXPECT_EQ((*tallies)[0].frames[0].tried, 2);
  EXPECT_EQ((*tallies)[0].right_localized(), 0);
  queries[0].scene = "c";
  EXPECT_EQ(Recognize(**models, queries, options, base::SteadyClock())
                .status()
                .code(),
            absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace treeline::accuracy
