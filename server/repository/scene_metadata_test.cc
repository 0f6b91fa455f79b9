#include "server/repository/scene_metadata.h"

#include <cmath>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::repository {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr char kWhole[] = R"({
  "display_name": "Küche, 2nd floor",
  "geo_anchor": {"latitude_deg": 49.8728, "longitude_deg": 8.6512,
                 "height_m": 191.5, "heading_deg": 90},
  "camera": {"model": "PINHOLE", "width_px": 640, "height_px": 480,
             "parameters": [585, 586, 320, 240.5]}
})";

void ExpectNear(geometry::Vec3 actual, geometry::Vec3 expected) {
  EXPECT_LT(geometry::Norm(actual - expected), 1e-12)
      << actual.x << " " << actual.y << " " << actual.z;
}

TEST(SceneMetadata, EveryFieldIsRead) {
  const auto metadata = ParseSceneMetadata(kWhole);
  ASSERT_TRUE(metadata.ok()) << metadata.status();
  EXPECT_EQ(metadata->display_name, "Küche, 2nd floor");
  ASSERT_TRUE(metadata->geo_anchor);
  EXPECT_EQ(metadata->geo_anchor->latitude_deg, 49.8728);
  EXPECT_EQ(metadata->geo_anchor->longitude_deg, 8.6512);
  EXPECT_EQ(metadata->geo_anchor->height_m, 191.5);
  EXPECT_EQ(metadata->geo_anchor->enu_from_world, EnuFromWorldOfHeading(90));
  ASSERT_TRUE(metadata->camera);
  EXPECT_EQ(metadata->camera->model(), camera::CameraModel::kPinhole);
  EXPECT_EQ(metadata->camera->width(), 640);
  EXPECT_EQ(metadata->camera->height(), 480);
  EXPECT_EQ(metadata->camera->fy(), 586);
  EXPECT_EQ(metadata->camera->cy(), 240.5);
}

TEST(SceneMetadata, EveryFieldMayBeLeftOut) {
  const auto metadata = ParseSceneMetadata("{}");
  ASSERT_TRUE(metadata.ok()) << metadata.status();
  EXPECT_EQ(*metadata, SceneMetadata{});
}

// The worked example of docs/reference/scene-repository.md.
TEST(SceneMetadata, AHeadingOfNinetyTurnsTheYAxisToTheEast) {
  const geometry::Rotation3 enu_from_world = EnuFromWorldOfHeading(90);
  ExpectNear(enu_from_world * geometry::Vec3{0, 1, 0}, {1, 0, 0});
  ExpectNear(enu_from_world * geometry::Vec3{1, 0, 0}, {0, -1, 0});
  ExpectNear(enu_from_world * geometry::Vec3{0, 0, 1}, {0, 0, 1});
  EXPECT_NEAR(enu_from_world.w, std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(enu_from_world.z, -std::sqrt(0.5), 1e-15);
}

TEST(SceneMetadata, HeadingsTurnClockwiseFromNorth) {
  ExpectNear(EnuFromWorldOfHeading(0) * geometry::Vec3{1, 2, 3}, {1, 2, 3});
  ExpectNear(EnuFromWorldOfHeading(30) * geometry::Vec3{0, 1, 0},
             {0.5, std::sqrt(0.75), 0});
  ExpectNear(EnuFromWorldOfHeading(-90) * geometry::Vec3{0, 1, 0}, {-1, 0, 0});
  ExpectNear(EnuFromWorldOfHeading(270) * geometry::Vec3{0, 1, 0}, {-1, 0, 0});
}

TEST(SceneMetadata, AQuaternionMayStandForTheHeading) {
  const auto metadata = ParseSceneMetadata(
      R"({"geo_anchor": {"latitude_deg": 0, "longitude_deg": 180,
          "height_m": 0, "enu_from_world": {"w": 0.707, "x": 0.707,
          "y": 0, "z": 0}}})");
  ASSERT_TRUE(metadata.ok()) << metadata.status();
  // Normalised; y up becomes z up.
  ExpectNear(metadata->geo_anchor->enu_from_world * geometry::Vec3{0, 1, 0},
             {0, 0, 1});
}

struct BadText {
  std::string text;
  std::string key;
  std::string problem;
};

std::string Anchor(const std::string& rest) {
  return R"({"geo_anchor": {"longitude_deg": 1, "height_m": 2, )" + rest + "}}";
}

std::string CameraText(const std::string& rest) {
  return R"({"camera": {"model": "PINHOLE", "height_px": 480, )" + rest + "}}";
}

TEST(SceneMetadata, WhatIsWrongIsNamedWithItsKey) {
  const BadText cases[] = {
      {"", "scene.json: ", "not JSON"},
      {"{", "scene.json: ", "not JSON"},
      {"[]", "scene.json: ", "must be an object"},
      {R"({"name": "x"})", "scene.json: 'name'", "unknown key"},
      {R"({"display_name": 3})", "scene.json: display_name", "string"},
      {R"({"display_name": "a\u0007b"})", "scene.json: display_name",
       "control"},
      {R"({"display_name": "a", "display_name": "b"})",
       "scene.json: 'display_name'", "twice"},
      {"{\"display_name\": \"" + std::string(257, 'x') + "\"}",
       "scene.json: display_name", "257 bytes"},
      {"{\"display_name\": \"\xff\"}", "scene.json: ", "not JSON"},
      {R"({"geo_anchor": []})", "scene.json: geo_anchor", "object"},
      {Anchor(R"("heading_deg": 0)"), "scene.json: geo_anchor.latitude_deg",
       "missing"},
      {Anchor(R"("heading_deg": 0, "latitude_deg": "1")"),
       "scene.json: geo_anchor.latitude_deg", "number"},
      {Anchor(R"("heading_deg": 0, "latitude_deg": 90.1)"),
       "scene.json: geo_anchor.latitude_deg", "between -90 and 90"},
      {Anchor(R"("heading_deg": 0, "latitude_deg": 1e999)"),
       "scene.json: ", "not JSON"},
      {Anchor(R"("heading_deg": 361, "latitude_deg": 1)"),
       "scene.json: geo_anchor.heading_deg", "between"},
      {Anchor(R"("latitude_deg": 1)"), "scene.json: geo_anchor", "either"},
      {Anchor(R"("latitude_deg": 1, "heading_deg": 1, "enu_from_world":
                 {"w": 1, "x": 0, "y": 0, "z": 0})"),
       "scene.json: geo_anchor", "either"},
      {Anchor(R"("latitude_deg": 1, "enu_from_world":
                 {"w": 2, "x": 0, "y": 0, "z": 0})"),
       "scene.json: geo_anchor.enu_from_world", "norm"},
      {Anchor(R"("latitude_deg": 1, "enu_from_world":
                 {"w": 1, "x": 0, "y": 0})"),
       "scene.json: geo_anchor.enu_from_world.z", "missing"},
      {Anchor(R"("latitude_deg": 1, "heading_deg": 1, "lon": 2)"),
       "scene.json: geo_anchor.'lon'", "unknown key"},
      {CameraText(R"("width_px": 0, "parameters": [1, 1, 1, 1])"),
       "scene.json: camera.width_px", "between 1 and 16384"},
      {CameraText(R"("width_px": 6.5, "parameters": [1, 1, 1, 1])"),
       "scene.json: camera.width_px", "whole"},
      {CameraText(R"("width_px": 640, "parameters": [1, 1, 1])"),
       "scene.json: camera", "parameters"},
      {CameraText(R"("width_px": 640, "parameters": [-1, 1, 1, 1])"),
       "scene.json: camera", ""},
      {CameraText(R"("width_px": 640, "parameters": ["1"])"),
       "scene.json: camera.parameters", "numbers"},
      {R"({"camera": {"model": "FISH", "width_px": 1, "height_px": 1,
          "parameters": []}})",
       "scene.json: camera.model", "'FISH'"},
      {std::string(kMaxSceneJsonBytes + 1, ' '), "scene.json: ", "longer"},
  };
  for (const BadText& bad : cases) {
    const auto metadata = ParseSceneMetadata(bad.text);
    ASSERT_FALSE(metadata.ok()) << bad.text;
    EXPECT_EQ(metadata.status().code(), absl::StatusCode::kInvalidArgument);
    const std::string message(metadata.status().message());
    EXPECT_THAT(message, StartsWith(bad.key)) << bad.text;
    EXPECT_THAT(message, HasSubstr(bad.problem)) << bad.text;
  }
}

}  // namespace
}  // namespace treeline::repository
