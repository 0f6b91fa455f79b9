#include "client/cli/answer_text.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"

namespace treeline::client_cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

relocalizer::LocalizeAnswer Localized() {
  relocalizer::LocalizeAnswer answer;
  answer.localized = true;
  answer.reason = "NONE";
  answer.world_from_camera = {
      geometry::Normalized(
          geometry::Rotation3::FromAxisAngle({0.3, -1.1, 0.7})),
      {1.0 / 3, 0.1, -3}};
  // Standard deviations: 2 mm along y, 0.01 rad about z.
  answer.covariance[7] = 4e-6;
  answer.covariance[35] = 1e-4;
  answer.pose_sensor = camera::RgbdSensor::kDepth;
  answer.inliers = 432;
  answer.samples = 500;
  answer.inlier_ratio = 0.864;
  answer.focal_scale = 1.052;
  answer.depth_scale = 0.955;
  answer.camera = *camera::Camera::Parse("SIMPLE_PINHOLE,31,19.5,14.5", 40, 30);
  answer.scene = "kitchen";
  answer.model_version = "7";
  answer.server = {.queue_ms = 1,
                   .decode_ms = 2,
                   .sample_ms = 3,
                   .forest_ms = 4,
                   .pose_ms = 5,
                   .localize_ms = 12.5,
                   .total_ms = 16};
  answer.round_trip_ms = 17.25;
  return answer;
}

relocalizer::LocalizeAnswer Lost() {
  relocalizer::LocalizeAnswer answer = Localized();
  answer.localized = false;
  answer.reason = "TOO_FEW_INLIERS";
  return answer;
}

const relocalizer::FrameFiles kFiles{
    .stem = "seq-01/a", .color = "r/seq-01/a.color.jpg", .depth = ""};

TEST(AnswerJson, KeepsEveryFieldBitForBit) {
  const relocalizer::LocalizeAnswer answer = Localized();
  const std::string line = AnswerJson(kFiles, answer);
  EXPECT_THAT(line, Not(HasSubstr("\n")));
  const Json json = Json::parse(line);
  EXPECT_EQ(json["stem"], "seq-01/a");
  EXPECT_EQ(json["color"], "r/seq-01/a.color.jpg");
  EXPECT_EQ(json["outcome"], "LOCALIZED");
  EXPECT_TRUE(json["reason"].is_null());
  const Json& pose = json["world_from_camera"];
  const geometry::Rigid3 back{{pose["qw"], pose["qx"], pose["qy"], pose["qz"]},
                              {pose["tx"], pose["ty"], pose["tz"]}};
  EXPECT_EQ(back, answer.world_from_camera);
  EXPECT_EQ(json["covariance"].get<geometry::PoseCovariance>(),
            answer.covariance);
  EXPECT_EQ(json["pose_sensor"], "DEPTH");
  EXPECT_EQ(json["inliers"], 432);
  EXPECT_EQ(json["samples"], 500);
  EXPECT_EQ(json["inlier_ratio"], 0.864);
  EXPECT_EQ(json["focal_scale"], 1.052);
  EXPECT_EQ(json["depth_scale"], 0.955);
  EXPECT_EQ(json["camera"], "SIMPLE_PINHOLE,31,19.5,14.5");
  EXPECT_EQ(json["round_trip_ms"], 17.25);
  EXPECT_EQ(json["server"]["queue_ms"], 1);
  EXPECT_EQ(json["server"]["decode_ms"], 2);
  EXPECT_EQ(json["server"]["sample_ms"], 3);
  EXPECT_EQ(json["server"]["forest_ms"], 4);
  EXPECT_EQ(json["server"]["pose_ms"], 5);
  EXPECT_EQ(json["server"]["localize_ms"], 12.5);
  EXPECT_EQ(json["server"]["total_ms"], 16);
  EXPECT_EQ(json["scene"], "kitchen");
  EXPECT_EQ(json["version"], "7");
}

TEST(AnswerJson, WhatIsNotLocalizedHasNoPose) {
  const Json json = Json::parse(AnswerJson(kFiles, Lost()));
  EXPECT_EQ(json["outcome"], "NOT_LOCALIZED");
  EXPECT_EQ(json["reason"], "TOO_FEW_INLIERS");
  EXPECT_TRUE(json["world_from_camera"].is_null());
  EXPECT_TRUE(json["covariance"].is_null());
  EXPECT_EQ(json["inliers"], 432);
}

TEST(AnswerJson, FailuresCarryTheirCode) {
  const Json json = Json::parse(
      AnswerJson(kFiles, absl::InvalidArgumentError("frame.color: \xff\n")));
  EXPECT_EQ(json["outcome"], "ERROR");
  EXPECT_EQ(json["code"], "INVALID_ARGUMENT");
  EXPECT_THAT(json["reason"].get<std::string>(), HasSubstr("frame.color"));
}

TEST(AnswerText, TellsPoseEvidenceAndTime) {
  const std::string text = AnswerText(Localized());
  EXPECT_THAT(text, HasSubstr("LOCALIZED in kitchen, version 7: depth camera"));
  EXPECT_THAT(text, HasSubstr("0.3333 0.1000 -3.0000 m"));
  EXPECT_THAT(text, HasSubstr("sigma 2.0 mm"));
  EXPECT_THAT(text, HasSubstr("sigma 0.57 deg"));
  EXPECT_THAT(text, HasSubstr("432 of 500 samples (86.4 %)"));
  EXPECT_THAT(text, HasSubstr("round trip       17.2 ms; server 16.0 ms"));
}

TEST(AnswerText, TellsWhyNot) {
  const std::string text = AnswerText(Lost());
  EXPECT_THAT(text, HasSubstr("NOT LOCALIZED in kitchen"));
  EXPECT_THAT(text, HasSubstr("TOO_FEW_INLIERS"));
  EXPECT_THAT(text, Not(HasSubstr("0.3333")));
}

TEST(AnswerLine, IsOneLinePerFrame) {
  EXPECT_THAT(AnswerLine(kFiles, Localized()),
              HasSubstr("seq-01/a  0.3333 0.1000 -3.0000 m"));
  EXPECT_THAT(AnswerLine(kFiles, Lost()),
              HasSubstr("seq-01/a  NOT_LOCALIZED TOO_FEW_INLIERS  432/500"));
  EXPECT_THAT(AnswerLine(kFiles, absl::NotFoundError("no scene 'x'")),
              HasSubstr("seq-01/a  ERROR NOT_FOUND: no scene 'x'"));
}

TEST(AnswerSummary, CountsAndRanksByNearestRank) {
  AnswerSummary summary;
  for (int i = 1; i <= 98; ++i) {
    relocalizer::LocalizeAnswer answer = i <= 90 ? Localized() : Lost();
    answer.round_trip_ms = i;
    summary.Add(answer);
  }
  summary.Add(absl::InternalError("x"));
  EXPECT_EQ(summary.localized(), 90);
  EXPECT_EQ(summary.failed(), 1);
  EXPECT_EQ(summary.Text(),
            "99 frames: 90 localized, 8 not, 1 failed; round trip p50 49.0 ms, "
            "p95 94.0 ms, p99 98.0 ms");
}

std::vector<relocalizer::SceneDescription> SomeScenes() {
  relocalizer::SceneDescription ready;
  ready.name = "kitchen";
  ready.state = "READY";
  ready.model_version = "2";
  ready.versions = {"2", "1"};
  ready.model.emplace();
  ready.model->method = "rgbd";
  ready.model->created_utc = "2026-11-21T09:30:00Z";
  ready.model->file_bytes = 12'345'678;
  ready.model->bounds_min_in_world = {-1, -2, -3.5};
  relocalizer::SceneDescription failed;
  failed.name = "a-scene-with-a-long-name";
  failed.state = "FAILED";
  failed.failure = "DATA_LOSS: checksum differs";
  failed.versions = {"1"};
  return {failed, ready};
}

TEST(ScenesText, ShowsStateAndReasons) {
  const std::string text = ScenesText(SomeScenes());
  EXPECT_THAT(text, HasSubstr("kitchen                   READY     2 "));
  EXPECT_THAT(text, HasSubstr("12.3  2026-11-21T09:30:00Z"));
  EXPECT_THAT(
      text,
      HasSubstr("a-scene-with-a-long-name: DATA_LOSS: checksum differs\n"));
  EXPECT_EQ(ScenesText({}), "no scenes\n");
}

TEST(ScenesJson, KeepsStateAndModel) {
  const Json scenes = Json::parse(ScenesJson(SomeScenes()))["scenes"];
  ASSERT_EQ(scenes.size(), 2u);
  EXPECT_EQ(scenes[0]["state"], "FAILED");
  EXPECT_EQ(scenes[0]["failure"], "DATA_LOSS: checksum differs");
  EXPECT_TRUE(scenes[0]["version"].is_null());
  EXPECT_TRUE(scenes[0]["model"].is_null());
  EXPECT_EQ(scenes[1]["scene"], "kitchen");
  EXPECT_EQ(scenes[1]["version"], "2");
  EXPECT_EQ(scenes[1]["versions"], Json({"2", "1"}));
  EXPECT_EQ(scenes[1]["model"]["file_bytes"], 12'345'678);
  EXPECT_EQ(scenes[1]["model"]["bounds_min_in_world_m"], Json({-1, -2, -3.5}));
  EXPECT_EQ(Json::parse(ScenesJson({}))["scenes"], Json::array());
}

}  // namespace
}  // namespace treeline::client_cli
