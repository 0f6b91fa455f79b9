#include "evaluation/accuracy/evaluation_json.h"

#include <limits>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "server/tools/testing_fixtures.h"

namespace treeline::accuracy {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

FrameResult LocalizedFrame() {
  FrameResult result;
  result.stem = "seq-01/frame-000001";
  result.estimate = tools::LocalizedAt({{0.5, 0.5, 0.5, 0.5}, {1, 2, 3}});
  result.estimate.timings = {.sample_ms = 0.25,
                             .forest_ms = 1.5,
                             .pose_ms = 0.75,
                             .total_ms = 2.5,
                             .features_ms = 0.5,
                             .verify_ms = 0.125};
  result.true_world_from_camera = geometry::Rigid3{};
  result.error = geometry::PoseError{0.03, 0.017453292519943295};
  result.latency_ms = 2.625;
  result.cpu_ms = 2.375;
  result.decode_ms = 4.5;
  return result;
}

FrameResult LostFrame() {
  FrameResult result;
  result.stem = "seq-01/frame-000002";
  result.estimate.reason = localizer::NotLocalizedReason::kTooFewInliers;
  result.estimate.inliers = 3;
  result.estimate.samples = 500;
  result.estimate.inlier_ratio = 0.006;
  result.true_world_from_camera = geometry::Rigid3{};
  result.latency_ms = 1;
  result.decode_ms = 4.5;
  return result;
}

FrameResult FailedFrame() {
  FrameResult result;
  result.stem = "seq-01/frame-000003";
  result.status = absl::NotFoundError("opening x.png: no such file");
  return result;
}

EvaluationRun SomeRun() {
  EvaluationRun run;
  run.dataset_uri = "7scenes:kitchen";
  run.frame_list = "test.txt";
  run.seed = 18446744073709551615u;
  run.threads = 2;
  run.command = "treeline evaluate";
  run.cpu = "a processor";
  run.software_version = "1.2.3";
  run.started_utc = "2026-11-21T09:30:00Z";
  run.peak_memory_bytes = 123456789;
  return run;
}

Json Parsed(const std::vector<FrameResult>& results) {
  EvaluatedMethod method;
  method.model_path = "kitchen.treeline";
  method.model.method = "rgbd";
  method.model.file_bytes = 777;
  method.results = results;
  return Json::parse(EvaluationJson(method, {}, SomeRun()));
}

TEST(EvaluationJson, HasTheHeadlineKeys) {
  const Json json = Parsed({LocalizedFrame(), LostFrame()});
  EXPECT_EQ(json["frames"], 2);
  EXPECT_EQ(json["scored"], 2);
  EXPECT_EQ(json["localized"], 1);
  EXPECT_EQ(json["errors"], 0);
  EXPECT_EQ(json["correct_5cm_5deg"], 0.5);
  EXPECT_EQ(json["correct_2cm_2deg"], 0.0);
  EXPECT_EQ(json["median_translation_m"], 0.03);
  EXPECT_NEAR(json["median_rotation_deg"].get<double>(), 1, 1e-12);
  EXPECT_NEAR(json["latency_ms"]["p50"].get<double>(), (2.625 + 1) / 2, 1e-12);
  EXPECT_EQ(json["cpu_ms"]["p50"], 2.375);
  EXPECT_EQ(json["decode_ms"]["p95"], 4.5);
  EXPECT_EQ(json["decode_ms"]["p99"], 4.5);
  EXPECT_EQ(json["model_bytes"], 777);
}

TEST(EvaluationJson, SaysHowTheNumbersCameAbout) {
  const Json json = Parsed({});
  EXPECT_EQ(json["seed"], 18446744073709551615u);
  EXPECT_EQ(json["threads"], 2);
  EXPECT_EQ(json["cpu"], "a processor");
  EXPECT_EQ(json["software_version"], "1.2.3");
  EXPECT_EQ(json["peak_memory_bytes"], 123456789);
  EXPECT_EQ(json["command"], "treeline evaluate");
  EXPECT_EQ(json["dataset"], "7scenes:kitchen");
  EXPECT_EQ(json["frame_list"], "test.txt");
  EXPECT_TRUE(json["pose_file"].is_null());
  EXPECT_EQ(json["method"], "rgbd");
  EXPECT_EQ(json["model"]["method"], "rgbd");
}

TEST(EvaluationJson, HasEveryThresholdAndTheTrajectoryError) {
  const Json json = Parsed({LocalizedFrame(), LostFrame()});
  ASSERT_EQ(json["thresholds"].size(), 3u);
  EXPECT_EQ(json["thresholds"][0]["name"], "5 cm / 5°");
  EXPECT_EQ(json["thresholds"][0]["translation_m"], 0.05);
  EXPECT_EQ(json["thresholds"][0]["correct"], 0.5);
  // The frame's pose is at (1, 2, 3), and its truth at the origin.
  EXPECT_NEAR(json["trajectory"]["rmse_m"].get<double>(), 3.741657, 1e-6);
  EXPECT_TRUE(json["trajectory"]["aligned_rmse_m"].is_null());
  EXPECT_EQ(json["stages_ms"]["forest_ms"]["p50"], 0.75);
  EXPECT_FALSE(json["confidence"]["stated"].get<bool>());
  EXPECT_TRUE(json["confidence"]["precision"].is_null());
}

TEST(ComparisonJson, HasAnEntryAMethodAndWhyOneFailed) {
  EvaluatedMethod good;
  good.name = "brf";
  good.model.method = "rgbd";
  good.results = {LocalizedFrame()};
  good.foreign = {{.source = "builtin", .images = 5, .accepted = 1}};
  good.scene_errors_m = {0.01, 0.03};
  EvaluatedMethod failed;
  failed.name = "rgb";
  failed.status = absl::NotFoundError("no such file");
  SweepPoint point{.value = 4, .summary = {}};
  point.summary.correct_5cm_5deg = 0.75;
  const Json json = Json::parse(ComparisonJson(
      {good, failed},
      {{SweepVariable::kTrees, {{.method = "rgbd", .points = {point}}}}},
      SomeRun()));
  EXPECT_EQ(json["dataset"], "7scenes:kitchen");
  ASSERT_EQ(json["methods"].size(), 2u);
  EXPECT_EQ(json["methods"][0]["name"], "brf");
  EXPECT_EQ(json["methods"][0]["per_frame"].size(), 1u);
  EXPECT_EQ(json["methods"][0]["foreign"][0]["accepted"], 1);
  EXPECT_EQ(
      json["methods"][0]["scene_coordinate_errors"]["cumulative"][0]["share"],
      0.5);
  EXPECT_EQ(json["methods"][1]["error"], "no such file");
  EXPECT_FALSE(json["methods"][1].contains("per_frame"));
  EXPECT_EQ(json["sweeps"][0]["option"], "trees");
  EXPECT_EQ(json["sweeps"][0]["points"][0]["value"], 4);
  EXPECT_EQ(json["sweeps"][0]["points"][0]["correct_5cm_5deg"], 0.75);
}

TEST(EvaluationJson, DescribesALocalizedFrame) {
  const Json frame = Parsed({LocalizedFrame()})["per_frame"][0];
  EXPECT_EQ(frame["stem"], "seq-01/frame-000001");
  EXPECT_EQ(frame["outcome"], "LOCALIZED");
  EXPECT_TRUE(frame["reason"].is_null());
  EXPECT_EQ(frame["inliers"], 40);
  EXPECT_EQ(frame["samples"], 50);
  EXPECT_EQ(frame["inlier_ratio"], 0.8);
  const Json pose = {{"qw", 0.5}, {"qx", 0.5}, {"qy", 0.5}, {"qz", 0.5},
                     {"tx", 1.0}, {"ty", 2.0}, {"tz", 3.0}};
  EXPECT_EQ(frame["world_from_camera"], pose);
  EXPECT_EQ(frame["translation_error_m"], 0.03);
  EXPECT_NEAR(frame["rotation_error_deg"].get<double>(), 1, 1e-12);
  EXPECT_EQ(frame["latency_ms"], 2.625);
  EXPECT_EQ(frame["cpu_ms"], 2.375);
  EXPECT_EQ(frame["decode_ms"], 4.5);
  const Json stages = {{"sample_ms", 0.25},  {"forest_ms", 1.5},
                       {"pose_ms", 0.75},    {"features_ms", 0.5},
                       {"verify_ms", 0.125}, {"total_ms", 2.5}};
  EXPECT_EQ(frame["stages"], stages);
}

TEST(EvaluationJson, GivesNoPoseForAFrameThatWasNotLocalized) {
  const Json frame = Parsed({LostFrame()})["per_frame"][0];
  EXPECT_EQ(frame["outcome"], "NOT_LOCALIZED");
  EXPECT_EQ(frame["reason"], "TOO_FEW_INLIERS");
  EXPECT_EQ(frame["inliers"], 3);
  EXPECT_TRUE(frame["world_from_camera"].is_null());
  EXPECT_TRUE(frame["translation_error_m"].is_null());
  EXPECT_EQ(frame["latency_ms"], 1.0);
}

TEST(EvaluationJson, GivesARefusedPoseBesideWhereAnAnswerWouldStand) {
  FrameResult refused = LostFrame();
  refused.estimate.world_from_camera.translation = {1, 2, 3};
  refused.refused_error = geometry::PoseError{0.25, 0.017453292519943295};
  const Json frame = Parsed({refused})["per_frame"][0];
  EXPECT_TRUE(frame["world_from_camera"].is_null());
  EXPECT_TRUE(frame["translation_error_m"].is_null());
  EXPECT_EQ(frame["refused"]["world_from_camera"]["tx"], 1.0);
  EXPECT_EQ(frame["refused"]["translation_error_m"], 0.25);
  EXPECT_NEAR(frame["refused"]["rotation_error_deg"].get<double>(), 1, 1e-12);
  FrameResult without_pose = LostFrame();
  without_pose.estimate.inliers = 0;
  const Json frames =
      Parsed({LocalizedFrame(), without_pose, FailedFrame()})["per_frame"];
  for (const Json& other : frames) EXPECT_TRUE(other["refused"].is_null());
}

TEST(EvaluationJson, CountsWhatWasAnsweredAndWhatWasFound) {
  FrameResult refused = LostFrame();
  refused.refused_error = geometry::PoseError{0.01, 0};
  const Json answers = Parsed({LocalizedFrame(), refused})["answers"];
  EXPECT_EQ(answers["frames"], 2);
  EXPECT_EQ(answers["answered"], 1);
  EXPECT_EQ(answers["right"], 1);
  EXPECT_EQ(answers["found"], 2);
  EXPECT_EQ(answers["coverage"], 0.5);
  EXPECT_EQ(answers["share_right"], 0.5);
  EXPECT_EQ(answers["wrong"], 0);
  EXPECT_EQ(answers["precision"], 1.0);
}

TEST(EvaluationJson, HasARowAPerturbation) {
  EvaluatedMethod method;
  method.results = {LocalizedFrame()};
  method.perturbed = {
      {{}, {LocalizedFrame()}},
      {ParsePerturbations("mirror").value().front(), {LostFrame()}}};
  const Json rows =
      Json::parse(EvaluationJson(method, {}, SomeRun()))["perturbations"];
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0]["name"], "as it is");
  EXPECT_EQ(rows[0]["share_right"], 1.0);
  EXPECT_EQ(rows[0]["latency_ms"]["p50"], 2.625);
  EXPECT_EQ(rows[1]["name"], "mirror");
  EXPECT_TRUE(rows[1]["is_foreign"].get<bool>());
  EXPECT_EQ(rows[1]["wrong"], 0);
}

TEST(EvaluationJson, GivesTheMessageOfAnErrorAndNothingElse) {
  const Json frame = Parsed({FailedFrame()})["per_frame"][0];
  EXPECT_EQ(frame["outcome"], "ERROR");
  EXPECT_EQ(frame["reason"], "opening x.png: no such file");
  for (const char* key :
       {"inliers", "samples", "inlier_ratio", "world_from_camera",
        "true_world_from_camera", "translation_error_m", "rotation_error_deg",
        "latency_ms", "cpu_ms", "decode_ms", "stages"}) {
    ASSERT_TRUE(frame.contains(key)) << key;
    EXPECT_TRUE(frame[key].is_null()) << key;
  }
}

TEST(EvaluationJson, HasNullsWhereNothingIsDefined) {
  const Json json = Parsed({});
  EXPECT_EQ(json["frames"], 0);
  for (const char* key : {"correct_5cm_5deg", "correct_2cm_2deg",
                          "median_translation_m", "median_rotation_deg"}) {
    EXPECT_TRUE(json[key].is_null()) << key;
  }
  EXPECT_TRUE(json["latency_ms"]["p50"].is_null());
  EXPECT_TRUE(json["decode_ms"]["p99"].is_null());
  EXPECT_EQ(json["per_frame"], Json::array());
}

TEST(EvaluationJson, NeverHoldsNanOrInfinity) {
  FrameResult result = LocalizedFrame();
  result.estimate.world_from_camera.translation.x =
      std::numeric_limits<double>::quiet_NaN();
  result.estimate.inlier_ratio = std::numeric_limits<double>::infinity();
  const Json frame = Parsed({result})["per_frame"][0];
  EXPECT_TRUE(frame["world_from_camera"]["tx"].is_null());
  EXPECT_EQ(frame["world_from_camera"]["ty"], 2.0);
  EXPECT_TRUE(frame["inlier_ratio"].is_null());
}

TEST(EvaluationJson, SurvivesNamesThatAreNotUtf8) {
  FrameResult result = FailedFrame();
  result.stem = "bad-\xff-name";
  EXPECT_THAT(Parsed({result})["per_frame"][0]["stem"].get<std::string>(),
              HasSubstr("-name"));
}

TEST(ModelInfoJson, HoldsProvenanceSizesAndBounds) {
  forest::ModelInfo model;
  model.method = "rgbd";
  model.format_version = 1;
  model.options = {{"trees", "5"}};
  model.trees = 5;
  model.nodes = 9;
  model.leaves = 7;
  model.file_bytes = 4096;
  model.checksum = "0123456789abcdef";
  model.bounds_max_in_world = {1, 2, 3};
  const Json json = Json::parse(ModelInfoJson(model));
  EXPECT_EQ(json["format_version"], 1);
  EXPECT_EQ(json["options"]["trees"], "5");
  EXPECT_EQ(json["trees"], 5);
  EXPECT_EQ(json["nodes"], 9);
  EXPECT_EQ(json["leaves"], 7);
  EXPECT_EQ(json["file_bytes"], 4096);
  EXPECT_EQ(json["checksum"], "0123456789abcdef");
  EXPECT_EQ(json["bounds_max_in_world"], Json({1.0, 2.0, 3.0}));
  EXPECT_EQ(json["calibration"]["depth_scale"], 1.0);
}

}  // namespace
}  // namespace treeline::accuracy
