#include "evaluation/report/report.h"

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "evaluation/accuracy/scene_recognition_output.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "server/tools/testing_fixtures.h"

namespace treeline::report {
namespace {

using Json = nlohmann::ordered_json;
using ::testing::ElementsAre;

constexpr double kDegree = 3.14159265358979323846 / 180;

// One white pixel.
constexpr const char* kPixelJpeg =
    "/9j/4AAQSkZJRgABAQEASABIAAD/2wBDAP////////////////////////////////////////"
    "//////////////////////////////////////////////wgALCAABAAEBAREA/8QAFBABAAAA"
    "AAAAAAAAAAAAAAAAAP/aAAgBAQABPxA=";

std::string PixelJpeg() {
  std::string bytes;
  absl::Base64Unescape(kPixelJpeg, &bytes);
  return bytes;
}

accuracy::FrameResult Localized(const std::string& stem,
                                const geometry::Rigid3& truth, double error_m) {
  accuracy::FrameResult result;
  result.stem = stem;
  const geometry::Rigid3 estimate{
      truth.rotation, truth.translation + geometry::Vec3{error_m, 0, 0}};
  result.estimate = tools::LocalizedAt(estimate);
  result.estimate.timings = {.sample_ms = 0.5,
                             .forest_ms = 1,
                             .pose_ms = 1.5,
                             .features_ms = 0.5,
                             .verify_ms = 0.75};
  result.true_world_from_camera = truth;
  result.error = geometry::PoseError{error_m, 10 * error_m * kDegree};
  result.latency_ms = 3 + 10 * error_m;
  result.cpu_ms = 3;
  result.decode_ms = 4;
  return result;
}

accuracy::FrameResult Lost(const std::string& stem,
                           const geometry::Rigid3& truth) {
  accuracy::FrameResult result;
  result.stem = stem;
  result.estimate.reason = localizer::NotLocalizedReason::kTooFewInliers;
  result.true_world_from_camera = truth;
  result.latency_ms = 3;
  return result;
}

accuracy::FrameResult Failed(const std::string& stem) {
  accuracy::FrameResult result;
  result.stem = stem;
  result.status = absl::NotFoundError("no <such> file");
  return result;
}

// A camera on an arc of 2 m about the origin, which it looks at.
geometry::Rigid3 OnArc(double angle_rad) {
  geometry::Mat3 rotation;
  rotation(0, 0) = 1;
  rotation(2, 1) = -1;
  rotation(1, 2) = 1;
  const geometry::Rotation3 turn =
      geometry::Rotation3::FromAxisAngle({0, 0, angle_rad});
  return {turn * geometry::Rotation3::FromMatrix(rotation),
          turn * geometry::Vec3{0, -2, 1 + 0.2 * std::sin(3 * angle_rad)}};
}

accuracy::EvaluatedMethod SomeMethod() {
  accuracy::EvaluatedMethod method;
  method.name = "rgbd";
  method.model_path = "kitchen.treeline";
  method.model.method = "rgbd";
  method.model.trees = 5;
  method.model.file_bytes = 2000000;
  method.model.training_s = 31.5;
  method.model.checksum = "1234";
  for (int i = 0; i < 30; ++i) {
    method.results.push_back(Localized(absl::StrCat("seq-01/frame-", i),
                                       OnArc(0.05 * i), 0.002 * (i + 1)));
    method.results.back().estimate.confidence = i < 25 ? 0.95 : 0.35;
    method.training_poses.push_back(OnArc(0.05 * i + 0.02));
  }
  method.results.push_back(Localized("wild", OnArc(1.6), 50));
  method.results.push_back(Lost("<b>&\"'", OnArc(1.7)));
  method.results.back().estimate.inliers = 7;
  method.results.back().estimate.confidence = 0.3;
  method.results.back().refused_error = geometry::PoseError{0.02, kDegree};
  method.results.push_back(Failed("failed"));
  const auto picture = [&](int frame, accuracy::PictureKind kind) {
    method.pictures.push_back(
        {{frame, kind},
         PixelJpeg(),
         640,
         480,
         {{{10.4, 20}, {}, {}, true}, {{30, 39.6}, {}, {}, false}}});
  };
  picture(31, accuracy::PictureKind::kWorst);
  picture(14, accuracy::PictureKind::kMedian);
  picture(0, accuracy::PictureKind::kBest);
  const auto changes = accuracy::ParsePerturbations("gamma:2,mirror").value();
  method.perturbed = {{{}, method.results},
                      {changes[0], {Lost("0", OnArc(0)), method.results[20]}},
                      {changes[1], {method.results[1]}}};
  method.scene_errors_m = {0.01, 0.02, 0.05, 0.5};
  method.heat_maps = {{.stem = "<i>seq-01/frame-3",
                       .width = 8,
                       .height = 6,
                       .photo_jpeg = PixelJpeg(),
                       .map_jpeg = PixelJpeg(),
                       .predictions = 3,
                       .median_error_m = 0.02}};
  method.splits.resize(3);
  for (accuracy::LevelSplits& level : method.splits) {
    level.splits = 4;
    level.by_left_share[10] = 3;
    level.by_left_share[19] = 1;
  }
  method.foreign = {{.source = "tum:/data/desk",
                     .with_depth = true,
                     .images = 9,
                     .accepted = 2,
                     .not_localized = 7,
                     .accepted_names = {"a<b"}},
                    {.source = "tum:/data/desk", .images = 9, .refused = 9}};
  return method;
}

accuracy::Sweep SomeSweep() {
  accuracy::SweepLine line{.method = "rgbd", .points = {}};
  for (int value : {1, 4, 8}) {
    accuracy::SweepPoint point{.value = value, .summary = {}};
    point.summary.correct_5cm_5deg = 0.6 + 0.04 * value;
    point.summary.correct_2cm_2deg = 0.2 + 0.02 * value;
    point.summary.median_translation_m = 0.03 / value;
    point.summary.cpu_ms =
        accuracy::Percentiles{1.5 * value, 2.0 * value, 3.0 * value};
    line.points.push_back(point);
  }
  return {accuracy::SweepVariable::kBacktracking, {line}};
}

// Something of all that a report may hold, hostile names among it.
ReportContents SomeContents() {
  ReportContents contents;
  contents.run.dataset_uri = "7scenes:/data/redkitchen";
  contents.run.command = "treeline evaluate --model '</script>'";
  contents.run.cpu = "a processor";
  contents.run.software_version = "1.2.3";
  contents.run.started_utc = "2026-11-21T09:30:00Z";
  contents.run.peak_memory_bytes = 123456789;
  contents.methods.push_back(SomeMethod());
  accuracy::EvaluatedMethod other = SomeMethod();
  other.name = "</script><script>alert('x')</script>";
  other.model.method = "orb-pnp";
  other.model_path.clear();
  other.model.file_bytes = 0;
  other.splits.clear();
  other.heat_maps.clear();
  other.results.resize(20);
  other.pictures.resize(2);
  other.pictures[0].choice.frame = 19;
  contents.methods.push_back(std::move(other));
  accuracy::EvaluatedMethod& failed = contents.methods.emplace_back();
  failed.name = "failed";
  failed.status = absl::NotFoundError("no <model>");
  contents.sweeps.push_back(SomeSweep());
  return contents;
}

Json Parsed(const ReportContents& contents) {
  return Json::parse(ReportJson(contents));
}

// The same keys in the same order, and the same values but for the last digits
// of numbers, which compilers differ in.
void ExpectSame(const Json& a, const Json& b, const std::string& where) {
  if (a.is_number() && b.is_number()) {
    EXPECT_NEAR(a.get<double>(), b.get<double>(),
                1e-6 * (1 + std::abs(b.get<double>())))
        << where;
    return;
  }
  ASSERT_EQ(a.type(), b.type()) << where;
  if (!a.is_structured()) {
    EXPECT_EQ(a, b) << where;
    return;
  }
  ASSERT_EQ(a.size(), b.size()) << where;
  auto other = b.begin();
  for (auto it = a.begin(); it != a.end(); ++it, ++other) {
    std::string name = where + "[]";
    if (a.is_object()) {
      ASSERT_EQ(it.key(), other.key()) << where;
      name = absl::StrCat(where, ".", it.key());
    }
    ExpectSame(*it, *other, name);
  }
}

// The template's own tests read these files, so that both sides keep to one
// contract. TREELINE_WRITE_FIXTURES=1 writes them anew.
void ExpectFixture(const std::string& name, const std::string& json) {
  const std::string path =
      absl::StrCat(TREELINE_REPORT_FIXTURES, "/", name, ".json");
  if (std::getenv("TREELINE_WRITE_FIXTURES") != nullptr) {
    ASSERT_TRUE(
        base::WriteFileAtomically(path, Json::parse(json).dump(1) + "\n").ok());
  }
  const auto kept = base::ReadFile(path);
  ASSERT_TRUE(kept.ok()) << kept.status();
  ExpectSame(Json::parse(json), Json::parse(*kept), name);
}

TEST(ReportJson, IsWhatTheTemplateIsTestedWith) {
  ExpectFixture("evaluation", ReportJson(SomeContents()));
}

TEST(RecognitionReportJson, IsWhatTheTemplateIsTestedWith) {
  accuracy::RecognitionRun run;
  run.command = "treeline recognize";
  run.cpu = "a processor";
  run.software_version = "1.2.3";
  run.started_utc = "2026-11-21T09:30:00Z";
  run.scenes = {"kitchen", "<b>desk"};
  accuracy::RecognitionTally tally{"kitchen", "7scenes:kitchen", {}};
  tally.frames = {{.stem = "0",
                   .status = {},
                   .rank = 1,
                   .first = "kitchen",
                   .answer = "kitchen",
                   .localized = true,
                   .tried = 1},
                  {.stem = "1",
                   .status = {},
                   .rank = 2,
                   .first = "<b>desk",
                   .answer = "<b>desk",
                   .localized = true,
                   .tried = 2},
                  {.stem = "2",
                   .status = {},
                   .rank = 1,
                   .first = "kitchen",
                   .answer = "kitchen",
                   .localized = false,
                   .tried = 2},
                  {.stem = "3",
                   .status = absl::DataLossError("<bad>"),
                   .first = "",
                   .answer = ""}};
  accuracy::RecognitionTally foreign{"", "builtin", {}};
  foreign.frames = {
      {.stem = "0", .status = {}, .first = "kitchen", .answer = ""}};
  const std::string json =
      accuracy::RecognitionReportJson({tally, foreign}, run);
  EXPECT_EQ(Json::parse(json)["kind"], "recognition");
  ExpectFixture("recognition", json);
}

TEST(ReportJson, SaysForEachFrameHowFarTrainingIs) {
  const Json frames = Parsed(SomeContents())["methods"][0]["per_frame"];
  // 0.02 rad along an arc of 2 m, turned by as much: hypot(0.04, 1.5 * 0.02).
  const Json& nearest = frames[0]["training_distance"];
  EXPECT_NEAR(nearest["translation_m"].get<double>(), 0.0417, 1e-3);
  EXPECT_NEAR(nearest["rotation_deg"].get<double>(), 0.02 / kDegree, 1e-6);
  EXPECT_NEAR(nearest["combined_m"].get<double>(), 0.0514, 1e-3);
  EXPECT_TRUE(frames[32]["training_distance"].is_null());
}

TEST(ReportJson, PutsPixelsWhereTheyWere) {
  const Json pictures =
      Parsed(SomeContents())["methods"][0]["page"]["pictures"];
  ASSERT_EQ(pictures.size(), 3u);
  EXPECT_EQ(pictures[0]["frame"], 31);
  EXPECT_EQ(pictures[0]["kind"], "worst");
  EXPECT_EQ(pictures[0]["inliers"], Json::array({10, 20}));
  EXPECT_EQ(pictures[0]["outliers"], Json::array({30, 40}));
  EXPECT_EQ(pictures[0]["photo"],
            absl::StrCat("data:image/jpeg;base64,", kPixelJpeg));
}

TEST(ReportJson, SaysInWhichDirectionAnErrorLies) {
  ReportContents contents = SomeContents();
  contents.methods.resize(1);
  accuracy::EvaluatedMethod& method = contents.methods[0];
  // Cameras at the origin, looking along z.
  method.results = {Localized("sideways", {}, 0.1), Localized("depth", {}, 0.1),
                    Localized("both", {}, 0.1), Localized("none", {}, 0),
                    Lost("lost", {})};
  method.results[1].estimate.world_from_camera.translation = {0, 0, 0.1};
  method.results[2].estimate.world_from_camera.translation = {0.1, 0, 0.1};
  method.results[2].estimate.covariance[0] = 0.0009;
  method.pictures.clear();
  for (int i = 0; i < 5; ++i) {
    method.pictures.push_back(
        {{i, accuracy::PictureKind::kWorst}, "", 4, 3, {}});
  }
  const Json pictures = Parsed(contents)["methods"][0]["page"]["pictures"];
  EXPECT_EQ(pictures[0]["error_direction"], "sideways");
  EXPECT_EQ(pictures[1]["error_direction"], "depth");
  EXPECT_TRUE(pictures[2]["error_direction"].is_null());
  EXPECT_TRUE(pictures[3]["error_direction"].is_null());
  EXPECT_TRUE(pictures[4]["error_direction"].is_null());
  EXPECT_NEAR(pictures[2]["claimed_deviation_m"].get<double>(), 0.03, 1e-12);
  EXPECT_TRUE(pictures[0]["claimed_deviation_m"].is_null());
  EXPECT_TRUE(pictures[4]["claimed_deviation_m"].is_null());
}

TEST(ReportJson, HasTheCurveOfSceneCoordinateErrors) {
  const Json curve =
      Parsed(SomeContents())["methods"][0]["page"]["scene_error_curve"];
  ASSERT_EQ(curve.size(), 201u);
  EXPECT_EQ(curve[0], Json::array({0.0, 0.0}));
  EXPECT_EQ(curve[4][1], 0.0);   // 8 mm
  EXPECT_EQ(curve[6][1], 0.25);  // 12 mm
  EXPECT_EQ(curve[200][1], 0.75);
}

TEST(ReportJson, SetsPublishedFiguresApart) {
  ReportContents contents = SomeContents();
  Json published = Parsed(contents)["published"];
  EXPECT_EQ(published["scene"], "Red Kitchen");
  EXPECT_FALSE(published["scene_results"].empty());
  EXPECT_FALSE(published["average_results"].empty());
  contents.run.dataset_uri = "7scenes:/data/my-desk";
  published = Parsed(contents)["published"];
  EXPECT_TRUE(published["scene"].is_null());
  EXPECT_TRUE(published["scene_results"].empty());
  EXPECT_FALSE(published["average_results"].empty());
  contents.run.dataset_uri = "elsewhere:/data";
  EXPECT_TRUE(Parsed(contents)["published"].is_null());
}

TEST(ReportJson, NamesTheMethodsThatFailed) {
  const Json failed = Parsed(SomeContents())["methods"][2];
  std::vector<std::string> keys;
  for (const auto& [key, value] : failed.items()) keys.push_back(key);
  EXPECT_THAT(keys, ElementsAre("name", "error"));
}

TEST(ReportJson, IsWholeForEveryKindOfRun) {
  accuracy::FrameResult unknown = Localized("u", {}, 0.01);
  unknown.true_world_from_camera.reset();
  unknown.error.reset();
  for (const std::vector<accuracy::FrameResult>& results :
       std::vector<std::vector<accuracy::FrameResult>>{
           {},
           {Localized("one", {}, 0)},
           {Lost("lost", {})},
           {Failed("\xff not UTF-8")},
           {unknown, unknown},
           {Localized("wild", {}, 1e6)}}) {
    ReportContents contents;
    contents.methods.emplace_back().results = results;
    const Json json = Parsed(contents);
    EXPECT_EQ(json["methods"][0]["per_frame"].size(), results.size());
    EXPECT_TRUE(json["methods"][0]["page"]["axes"]["up"][2].is_number());
  }
}

}  // namespace
}  // namespace treeline::report
