#include "evaluation/report/report.h"

#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/ascii.h"
#include "evaluation/report/report_charts.h"
#include "evaluation/report/report_distance.h"
#include "evaluation/report/report_line_charts.h"
#include "evaluation/report/report_svg.h"
#include "evaluation/report/report_trajectory.h"
#include "evaluation/report/report_turntable.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/model_description.h"
#include "server/tools/run_info.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::report {
namespace {

using ::testing::DoubleEq;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// A page is too long to be printed where it lacks something.
bool Has(const std::string& html, const std::string& text) {
  return html.find(text) != std::string::npos;
}

constexpr double kDegree = 3.14159265358979323846 / 180;

accuracy::FrameResult Localized(const std::string& stem, double translation_m) {
  accuracy::FrameResult result;
  result.stem = stem;
  result.estimate = tools::LocalizedAt({{}, {translation_m, 0, 0}});
  result.true_world_from_camera = geometry::Rigid3{};
  result.error = geometry::PoseError{translation_m, 0.5 * kDegree};
  result.latency_ms = 3;
  result.decode_ms = 4;
  return result;
}

accuracy::FrameResult Lost(const std::string& stem) {
  accuracy::FrameResult result;
  result.stem = stem;
  result.estimate.reason = localizer::NotLocalizedReason::kTooFewInliers;
  result.true_world_from_camera = geometry::Rigid3{};
  result.latency_ms = 3;
  return result;
}

accuracy::FrameResult Failed(const std::string& stem) {
  accuracy::FrameResult result;
  result.stem = stem;
  result.status = absl::NotFoundError("no such file");
  return result;
}

ReportContents SomeContents() {
  ReportContents contents;
  contents.run.dataset_uri = "7scenes:/data/kitchen";
  contents.run.command = "treeline evaluate --model 'a b'";
  contents.run.cpu = "a processor";
  accuracy::EvaluatedMethod& method = contents.methods.emplace_back();
  method.name = "rgbd";
  method.model.method = "rgbd";
  method.model.file_bytes = 2000000;
  method.results = {Localized("f0", 0.01), Localized("f1", 0.03),
                    Localized("f2", 0.30), Lost("f3"), Failed("f4")};
  method.training_poses = {geometry::Rigid3{{}, {0.2, 0, 0}}};
  method.pictures = {{{2, accuracy::PictureKind::kWorst},
                      "\xff\xd8jpeg",
                      640,
                      480,
                      {{{10, 20}, {}, {}, true}, {{30, 40}, {}, {}, false}}}};
  return contents;
}

// A page must not say "nan" or "inf" where a number belongs.
void ExpectNoBadNumbers(const std::string& html) {
  const std::string lower = absl::AsciiStrToLower(html);
  for (const char* bad : {">nan", ">-nan", ">inf", "\"nan", "\"inf", " nan",
                          " inf ", "mnan", "-nan"}) {
    EXPECT_FALSE(Has(lower, bad)) << bad;
  }
}

TEST(ReportHtml, NeedsNothingFromElsewhere) {
  const std::string html = ReportHtml(SomeContents());
  EXPECT_FALSE(Has(html, "http:"));
  EXPECT_FALSE(Has(html, "https:"));
  EXPECT_FALSE(Has(html, "<script"));
  EXPECT_FALSE(Has(html, "<link"));
  EXPECT_FALSE(Has(html, "@import"));
  EXPECT_TRUE(Has(html, "data:image/jpeg;base64,/9hqcGVn"));
}

TEST(ReportHtml, LeadsWithTheFigures) {
  const std::string html = ReportHtml(SomeContents());
  EXPECT_TRUE(Has(html, "<h1>kitchen</h1>"));
  EXPECT_TRUE(Has(html, "2 of 4 frames were placed within 5 cm"));
  EXPECT_TRUE(Has(html, "One was given up as not localized."));
  EXPECT_TRUE(Has(html, "1 could not be read or used."));
  EXPECT_TRUE(Has(html, "<b>50.0 %</b><span>within 5 cm and 5°"));
  EXPECT_TRUE(Has(html, "<b>25.0 %</b><span>within 2 cm and 2°"));
  EXPECT_TRUE(Has(html, "<b>3.00 <small>cm</small></b>"));
}

TEST(ReportHtml, NeverRoundsALostFrameAway) {
  ReportContents contents = SomeContents();
  contents.methods[0].results.assign(4000, Localized("f", 0.01));
  contents.methods[0].results.push_back(Lost("lost"));
  const std::string html = ReportHtml(contents);
  EXPECT_TRUE(Has(html, "<b>99.9 %</b><span>within 5 cm and 5°"));
}

TEST(ReportHtml, DrawsInliersAndOutliersWhereTheyWere) {
  const std::string html = ReportHtml(SomeContents());
  EXPECT_TRUE(Has(html, "<path d=\"M10 20h0\" class=\"inlier\"/>"));
  EXPECT_TRUE(Has(html, "<path d=\"M30 40h0\" class=\"outlier\"/>"));
  EXPECT_TRUE(Has(html, "Off by 30.0 cm and 0.50°"));
  EXPECT_TRUE(Has(html, "The nearest training camera is 20 cm and 0° away."));
}

TEST(ReportHtml, SaysInWordsWhyAFrameWasNotLocalized) {
  ReportContents contents = SomeContents();
  contents.methods[0].pictures[0].choice.frame = 3;
  const std::string html = ReportHtml(contents);
  EXPECT_TRUE(Has(html, "Not localized: too few inliers."));
  EXPECT_FALSE(Has(html, "TOO_FEW_INLIERS"));
}

TEST(ReportHtml, EscapesNamesAndCommands) {
  ReportContents contents = SomeContents();
  contents.methods[0].results[3].stem = "<b>&\"'";
  contents.run.command = "treeline <evil>";
  const std::string html = ReportHtml(contents);
  EXPECT_FALSE(Has(html, "<evil>"));
  EXPECT_TRUE(Has(html, "treeline &lt;evil&gt;"));
  EXPECT_TRUE(Has(html, "&lt;b&gt;&amp;&quot;&#39;"));
}

TEST(ReportHtml, ListsErrorsAndLostFramesBeforeLargeErrors) {
  const std::string html = ReportHtml(SomeContents());
  const size_t table = html.find("The hardest frames");
  ASSERT_NE(table, std::string::npos);
  const size_t failed = html.find("<td>f4</td>", table);
  const size_t lost = html.find("<td>f3</td>", table);
  const size_t far = html.find("<td>f2</td>", table);
  ASSERT_NE(far, std::string::npos);
  EXPECT_LT(failed, lost);
  EXPECT_LT(lost, far);
}

TEST(ReportHtml, IsWholeForEveryKindOfRun) {
  accuracy::FrameResult unknown = Localized("u", 0.01);
  unknown.true_world_from_camera.reset();
  unknown.error.reset();
  const std::vector<std::vector<accuracy::FrameResult>> runs = {
      {},
      {Localized("one", 0)},
      {Lost("lost")},
      {Failed("failed")},
      {unknown, unknown},
      {Localized("wild", 1e6), Localized("fine", 0.01)},
  };
  for (const std::vector<accuracy::FrameResult>& results : runs) {
    ReportContents contents;
    contents.methods.emplace_back().results = results;
    const std::string html = ReportHtml(contents);
    EXPECT_TRUE(Has(html, "</html>"));
    ExpectNoBadNumbers(html);
  }
}

TEST(ReportHtml, SaysSoWhereThereIsNoGroundTruth) {
  ReportContents contents = SomeContents();
  for (accuracy::FrameResult& result : contents.methods[0].results) {
    result.true_world_from_camera.reset();
    result.error.reset();
  }
  EXPECT_TRUE(Has(ReportHtml(contents), "no ground truth to score"));
}

ReportContents ThreeMethods() {
  ReportContents contents = SomeContents();
  accuracy::EvaluatedMethod other = contents.methods[0];
  other.name = "<other>";
  other.results = {Localized("f0", 0.01), Localized("f1", 0.01),
                   Localized("f2", 0.01), Localized("f3", 0.01),
                   Localized("f4", 0.01)};
  contents.methods.push_back(other);
  accuracy::EvaluatedMethod& failed = contents.methods.emplace_back();
  failed.name = "failed";
  failed.status = absl::NotFoundError("no <model>");
  return contents;
}

TEST(ReportHtml, PutsSeveralMethodsSideBySide) {
  const std::string html = ReportHtml(ThreeMethods());
  EXPECT_TRUE(Has(html,
                  "3 methods side by side. Most accurate: "
                  "&lt;other&gt;, with 100 % of 5 frames"));
  EXPECT_TRUE(Has(html, "1 could not be evaluated."));
  EXPECT_TRUE(Has(html, "no &lt;model&gt;</td>"));
  EXPECT_TRUE(Has(html, "<td class=\"n best\">100 %</td>"));
  EXPECT_TRUE(Has(html, "<td class=\"n\">50.0 %</td>"));
  EXPECT_TRUE(Has(html, "<summary><b>rgbd</b>"));
  EXPECT_FALSE(Has(html, "<summary><b>failed</b>"));
  EXPECT_FALSE(Has(html, "<script"));
  ExpectNoBadNumbers(html);
}

TEST(ReportHtml, IsWholeWhereEveryMethodFailed) {
  ReportContents contents;
  contents.methods.resize(2);
  for (accuracy::EvaluatedMethod& method : contents.methods) {
    method.status = absl::NotFoundError("gone");
  }
  const std::string html = ReportHtml(contents);
  EXPECT_TRUE(Has(html, "</html>"));
  ExpectNoBadNumbers(html);
}

TEST(ReportHtml, SetsPublishedFiguresApart) {
  ReportContents contents = SomeContents();
  contents.run.dataset_uri = "7scenes:/data/redkitchen";
  const std::string html = ReportHtml(contents);
  EXPECT_TRUE(Has(html, "published: thesis, Table 5.2"));
  EXPECT_TRUE(Has(html, "published, Red Kitchen"));
  EXPECT_TRUE(Has(html, "measured here"));
  EXPECT_TRUE(Has(html, "cannot be ranked against the others"));
  contents.run.dataset_uri = "elsewhere:/data";
  EXPECT_FALSE(Has(ReportHtml(contents), "What others published"));
}

TEST(ReportHtml, ShowsConfidenceWhereItIsStated) {
  ReportContents contents = SomeContents();
  EXPECT_FALSE(Has(ReportHtml(contents), "Can it be believed"));
  contents.methods[0].results[0].estimate.confidence = 0.95;
  contents.methods[0].results[2].estimate.confidence = 0.15;
  const std::string html = ReportHtml(contents);
  EXPECT_TRUE(Has(html, "Can it be believed"));
  EXPECT_TRUE(Has(html, "At 0.50 and above: 1 answer, 100 % of them correct"));
  EXPECT_TRUE(Has(html, "stated 95 %, correct 100 % of 1 frames"));
}

TEST(ReportHtml, CountsFalseAccepts) {
  ReportContents contents = SomeContents();
  accuracy::ForeignTally with{.source = "tum:/data/desk",
                              .with_depth = true,
                              .images = 9,
                              .accepted = 2,
                              .not_localized = 7,
                              .accepted_names = {"a<b"}};
  accuracy::ForeignTally without{
      .source = "tum:/data/desk", .images = 9, .refused = 9};
  contents.methods[0].foreign = {with, without};
  const std::string html = ReportHtml(contents);
  EXPECT_TRUE(Has(html, "<td class=\"n bad\">2 of 9</td>"));
  EXPECT_TRUE(Has(html, "0 of 9 (9 refused)"));
  EXPECT_TRUE(Has(html, "a&lt;b"));
}

TEST(ReportHtml, ShowsSceneCoordinateErrorsAndHeatMaps) {
  ReportContents contents = SomeContents();
  EXPECT_FALSE(Has(ReportHtml(contents), "Before the pose"));
  contents.methods[0].scene_errors_m = {0.01, 0.02, 0.5};
  contents.methods[0].heat_maps = {{.stem = "f<2",
                                    .width = 8,
                                    .height = 6,
                                    .photo_jpeg = "photo",
                                    .map_jpeg = "map",
                                    .predictions = 3,
                                    .median_error_m = 0.02}};
  const std::string html = ReportHtml(contents);
  EXPECT_TRUE(Has(html, "Predictions within a distance of the truth"));
  EXPECT_TRUE(Has(html, "median 2.0 cm of 3 predictions"));
  EXPECT_TRUE(Has(html, "f&lt;2"));
}

TEST(DistanceSection, GroupsFramesByTheirDistanceFromTraining) {
  accuracy::EvaluatedMethod method;
  method.name = "rgbd";
  method.training_poses = {geometry::Rigid3{}};
  for (int i = 0; i < 10; ++i) {
    // The nearer half is right.
    accuracy::FrameResult result = Localized("f", i < 5 ? 0.01 : 0.2);
    result.true_world_from_camera->translation = {0.1 * i, 0, 0};
    method.results.push_back(result);
  }
  const std::string html = DistanceSection({method});
  EXPECT_TRUE(Has(html, "rgbd: 100.0 % of 2 frames about 5 cm away"));
  EXPECT_TRUE(Has(html, "rgbd: 50.0 % of 2 frames about 45 cm away"));
  EXPECT_TRUE(Has(html, "rgbd: 0.0 % of 2 frames about 85 cm away"));
  EXPECT_TRUE(Has(html, "rgbd: median 1.00 cm about 25 cm away"));
  method.training_poses.clear();
  EXPECT_EQ(DistanceSection({method}), "");
}

TEST(TurntableChart, HasAButtonForEveryView) {
  const std::string html =
      TurntableChart({Localized("f", 0.01)}, {geometry::Rigid3{}}, "m7");
  const auto count = [&](const std::string& text) {
    int found = 0;
    for (size_t at = html.find(text); at != std::string::npos;
         at = html.find(text, at + 1)) {
      ++found;
    }
    return found;
  };
  EXPECT_EQ(count("<input type=\"radio\" name=\"turn-m7\""), 12);
  EXPECT_EQ(count("<svg"), 12);
  EXPECT_EQ(count(" checked"), 1);
  EXPECT_EQ(TurntableChart({Failed("f")}, {}, "m"), "");
}

TEST(CumulativeCurves, CountWhatHasNoValueInTheTotal) {
  const std::string svg = CumulativeCurves({{"a", {1.0, 2.0}, 4}, {"b", {}, 0}},
                                           10, "cm", {{5, "5 cm"}});
  // Half of the height of 214 px above the base at 230.
  EXPECT_THAT(svg, HasSubstr("V123.0"));
  EXPECT_THAT(svg, HasSubstr("class=\"series s1\""));
  ExpectNoBadNumbers(svg);
}

TEST(LineChart, KeepsItsLimitAndSurvivesASinglePoint) {
  const std::string svg =
      LineChart({{"a", {{1, 100, "at one"}}}}, "x", "%", 100);
  EXPECT_THAT(svg, HasSubstr("at one"));
  EXPECT_THAT(svg, HasSubstr(">100</text>"));
  EXPECT_THAT(svg, Not(HasSubstr(">102</text>")));
  ExpectNoBadNumbers(svg);
  ExpectNoBadNumbers(LineChart({}, "x", "y"));
  ExpectNoBadNumbers(LineChart({{"a", {{0, 0, ""}}}}, "x", "y"));
}

TEST(SplitRatioMap, SaysHowManySplitsHaveWhichShare) {
  accuracy::LevelSplits level;
  level.splits = 4;
  level.by_left_share[10] = 3;
  level.by_left_share[19] = 1;
  EXPECT_THAT(SplitRatioMap({level}),
              HasSubstr("level 0: 75.0 % of 4 splits send 50 to 55 % to the "
                        "left"));
  EXPECT_EQ(SplitRatioMap({}), "");
}

TEST(ChoosePictures, TakesWorstMedianAndBestOfFramesThatCanBeShown) {
  // Errors grow with the index; neighbours look alike and are not taken
  // together while others remain.
  std::vector<accuracy::FrameResult> results;
  for (int i = 0; i < 40; ++i) {
    results.push_back(Localized("f", 0.001 * (i + 1)));
  }
  results.push_back(Failed("failed"));
  const std::vector<accuracy::PictureChoice> choices =
      accuracy::ChoosePictures(results, 2, 1, 1);
  std::vector<int> frames;
  for (const accuracy::PictureChoice& choice : choices)
    frames.push_back(choice.frame);
  EXPECT_THAT(frames, ElementsAre(39, 35, 19, 0));
}

TEST(ChoosePictures, PutsLostFramesFirst) {
  const std::vector<accuracy::PictureChoice> choices =
      accuracy::ChoosePictures({Localized("far", 9), Lost("lost")}, 1, 0, 0);
  EXPECT_THAT(choices, ElementsAre(Field(&accuracy::PictureChoice::frame, 1)));
}

TEST(ChoosePictures, NeverShowsAFrameTwice) {
  EXPECT_THAT(accuracy::ChoosePictures({Localized("only", 0.01)}, 3, 3, 3),
              ElementsAre(Field(&accuracy::PictureChoice::kind,
                                accuracy::PictureKind::kWorst)));
  EXPECT_THAT(accuracy::ChoosePictures({}, 3, 3, 3), IsEmpty());
}

TEST(TakePictures, AsksForCorrespondencesWithTheSeedOfTheEvaluation) {
  const tools::SmallRecording recording(2, {});
  accuracy::EvaluationOptions options;
  options.seed = 5;
  const tools::FunctionLocalizer localizer(
      {},
      [](const image::Frame& frame, const localizer::LocalizeOptions& query) {
        localizer::PoseEstimate estimate = tools::LocalizedAt({});
        if (query.keep_correspondences) {
          estimate.correspondences.push_back(
              {{static_cast<double>(tools::FrameNumber(frame)),
                static_cast<double>(query.seed)},
               {},
               {},
               true});
        }
        return estimate;
      });
  const std::vector<accuracy::ReportPicture> pictures =
      accuracy::TakePictures(localizer, recording.Open(),
                             {{1, accuracy::PictureKind::kBest}}, options);
  ASSERT_EQ(pictures.size(), 1u);
  EXPECT_EQ(pictures[0].width, 8);
  EXPECT_EQ(pictures[0].height, 6);
  ASSERT_EQ(pictures[0].correspondences.size(), 1u);
  EXPECT_EQ(pictures[0].correspondences[0].color_pixel.x, 1);
  EXPECT_EQ(pictures[0].correspondences[0].color_pixel.y, 5);
  EXPECT_EQ(pictures[0].jpeg.substr(0, 2), "\xff\xd8");
}

TEST(DistanceToTraining, WeighsATurnLikeTheMoveOfWhatIsSeen) {
  // 10 cm away, or turned by 4 degrees: 1.5 m * 0.0698 rad = 10.5 cm.
  const geometry::Rigid3 moved{{}, {0.1, 0, 0}};
  const geometry::Rigid3 turned{
      geometry::Rotation3::FromAxisAngle({0, 4 * kDegree, 0}), {}};
  const auto nearest = accuracy::DistanceToTraining({}, {turned, moved});
  ASSERT_TRUE(nearest.has_value());
  EXPECT_NEAR(nearest->translation_m, 0.1, 1e-12);
  EXPECT_NEAR(nearest->rotation_deg, 0, 1e-12);
  EXPECT_NEAR(nearest->combined_m, 0.1, 1e-12);
  EXPECT_NEAR(accuracy::DistanceToTraining({}, {turned})->combined_m, 0.10472,
              1e-5);
  EXPECT_FALSE(accuracy::DistanceToTraining({}, {}).has_value());
}

TEST(AxesOfCameras, FindsUpAndForwardOfACameraInAZUpWorld) {
  // Camera looking along world y, its y axis down along -z.
  geometry::Mat3 rotation;
  rotation(0, 0) = 1;   // camera x -> world x
  rotation(2, 1) = -1;  // camera y -> world -z
  rotation(1, 2) = 1;   // camera z -> world y
  const ViewAxes axes = AxesOfCameras(
      {geometry::Rigid3{geometry::Rotation3::FromMatrix(rotation), {5, 6, 7}}});
  EXPECT_NEAR(axes.up_in_world.z, 1, 1e-12);
  EXPECT_NEAR(axes.forward_in_world.y, 1, 1e-12);
  EXPECT_NEAR(axes.right_in_world.x, 1, 1e-12);
}

TEST(AxesOfCameras, StaysOrthonormalWhereDirectionsVanish) {
  // Looking straight down and, in the second pair, in opposite directions.
  const geometry::Rotation3 down =
      geometry::Rotation3::FromAxisAngle({90 * kDegree, 0, 0});
  const geometry::Rotation3 flipped =
      geometry::Rotation3::FromAxisAngle({180 * kDegree, 0, 0});
  for (const std::vector<geometry::Rigid3>& cameras :
       {std::vector<geometry::Rigid3>{{down, {}}},
        std::vector<geometry::Rigid3>{{{}, {}}, {flipped, {}}},
        std::vector<geometry::Rigid3>{}}) {
    const ViewAxes axes = AxesOfCameras(cameras);
    EXPECT_NEAR(geometry::Norm(axes.up_in_world), 1, 1e-12);
    EXPECT_NEAR(geometry::Norm(axes.forward_in_world), 1, 1e-12);
    EXPECT_NEAR(geometry::Dot(axes.up_in_world, axes.forward_in_world), 0,
                1e-12);
    EXPECT_NEAR(geometry::Norm(geometry::Cross(axes.right_in_world,
                                               axes.forward_in_world) -
                               axes.up_in_world),
                0, 1e-12);
  }
}

TEST(TrajectoryChart, CountsEstimatesThatLieOutside) {
  std::vector<accuracy::FrameResult> results;
  for (int i = 0; i < 5; ++i) {
    accuracy::FrameResult result = Localized("f", 0);
    result.true_world_from_camera->translation = {0.1 * i, 0, 0};
    result.estimate.world_from_camera = *result.true_world_from_camera;
    results.push_back(result);
  }
  EXPECT_THAT(TrajectoryChart(results, {}), Not(HasSubstr("outside")));
  results[2].estimate.world_from_camera.translation.y = 50;
  results[2].error->translation_m = 50;
  EXPECT_THAT(TrajectoryChart(results, {}),
              HasSubstr("1 estimate lies outside"));
}

TEST(CumulativeChart, CountsFramesWithoutAValueInTheTotal) {
  // Two of four frames have errors below 2 cm.
  const std::string svg =
      CumulativeChart({1.0, 1.5, 7.0}, 4, 10, "cm", {{2, "2 cm"}});
  EXPECT_THAT(svg, HasSubstr(">50.0 %</text>"));
}

TEST(HistogramChart, CountsWhatLiesBeyondItsLastBin) {
  std::vector<double> values(1000, 1.0);
  values.push_back(500);
  const std::string svg = HistogramChart(values, "ms", {});
  EXPECT_THAT(svg, HasSubstr(">1 beyond</text>"));
  EXPECT_THAT(svg, HasSubstr("1000 frames"));
  EXPECT_EQ(HistogramChart({}, "ms", {}), "");
}

TEST(RoundTicks, StepsByOneTwoOrFive) {
  EXPECT_THAT(RoundTicks(10, 5), ElementsAre(0, 2, 4, 6, 8, 10));
  EXPECT_THAT(RoundTicks(0.3, 3), ElementsAre(DoubleEq(0), DoubleEq(0.1),
                                              DoubleEq(0.2), DoubleEq(0.3)));
  EXPECT_THAT(RoundTicks(180, 6), ElementsAre(0, 50, 100, 150));
}

TEST(DescribeModel, ShowsWhatAPersonAsksFor) {
  forest::ModelInfo model;
  model.method = "rgbd";
  model.format_version = 1;
  model.trees = 5;
  model.leaves = 482025;
  model.file_bytes = 48200000;
  model.options = {{"trees", "5"}, {"poses", ""}};
  model.calibration.color_from_depth.translation = {-0.0235, 0.005, 0};
  const std::string text = tools::DescriptionText(tools::DescribeModel(model));
  EXPECT_THAT(text, HasSubstr("482,025"));
  EXPECT_THAT(text, HasSubstr("48.2 MB"));
  EXPECT_THAT(text, HasSubstr("-2.350  0.500  0.000 cm"));
  EXPECT_THAT(text, HasSubstr("PINHOLE 585 585 320 240, 640 x 480"));
}

TEST(Format, WritesCountsBytesAndOddNumbers) {
  EXPECT_EQ(tools::FormatCount(0), "0");
  EXPECT_EQ(tools::FormatCount(999), "999");
  EXPECT_EQ(tools::FormatCount(1000), "1,000");
  EXPECT_EQ(tools::FormatCount(-1234567), "-1,234,567");
  EXPECT_EQ(tools::FormatBytes(999), "999 B");
  EXPECT_EQ(tools::FormatBytes(1000), "1.0 kB");
  EXPECT_EQ(tools::FormatBytes(34200000), "34.2 MB");
  EXPECT_EQ(tools::FormatNumber("%.1f", std::nan("")), "-");
}

TEST(ShellQuoted, QuotesOnlyWhatAShellWouldChange) {
  EXPECT_EQ(tools::ShellQuoted("--model=a/b_c-1.treeline"),
            "--model=a/b_c-1.treeline");
  EXPECT_EQ(tools::ShellQuoted("7scenes:dir"), "7scenes:dir");
  EXPECT_EQ(tools::ShellQuoted("a b"), "'a b'");
  EXPECT_EQ(tools::ShellQuoted("it's"), "'it'\\''s'");
  EXPECT_EQ(tools::ShellQuoted("$HOME"), "'$HOME'");
  EXPECT_EQ(tools::ShellQuoted(""), "''");
}

TEST(RunInfo, TellsAboutThisProcess) {
  EXPECT_THAT(tools::CommandLine(), HasSubstr("report_test"));
  EXPECT_GT(tools::PeakMemoryBytes(), 1u << 20);
  EXPECT_THAT(tools::CpuDescription(), HasSubstr("processor"));
  EXPECT_EQ(tools::UtcNow().size(), std::string("2026-11-21T09:30:00Z").size());
}

}  // namespace
}  // namespace treeline::report
