#include "evaluation/accuracy/evaluation_csv.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_split.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::accuracy {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::vector<std::string> Lines(const std::vector<FrameResult>& results) {
  EvaluatedMethod method;
  method.name = "rgbd";
  method.results = results;
  std::vector<std::string> lines =
      absl::StrSplit(EvaluationCsv({method}), '\n');
  EXPECT_EQ(lines.back(), "");
  lines.pop_back();
  return lines;
}

FrameResult Localized() {
  FrameResult result;
  result.stem = "f0";
  result.estimate = tools::LocalizedAt({{}, {1, 2, 3}});
  result.estimate.confidence = 0.75;
  result.true_world_from_camera = geometry::Rigid3{};
  result.error = geometry::PoseError{0.25, 0};
  result.latency_ms = 3.5;
  return result;
}

TEST(EvaluationCsv, HasALineAFrameWithTheColumnsOfTheHeader) {
  FrameResult lost;
  lost.stem = "f1";
  lost.estimate.reason = localizer::NotLocalizedReason::kTooFewInliers;
  FrameResult failed;
  failed.stem = "f2";
  failed.status = absl::NotFoundError("no such file");
  const std::vector<std::string> lines = Lines({Localized(), lost, failed});
  ASSERT_EQ(lines.size(), 4u);
  const auto commas = std::ranges::count(lines[0], ',');
  for (const std::string& line : lines) {
    EXPECT_EQ(std::ranges::count(line, ','), commas) << line;
  }
  EXPECT_THAT(lines[1], StartsWith("rgbd,f0,LOCALIZED,,0.75,40,50,0.8,0.25,0,"
                                   "3.5,,,"));
  EXPECT_THAT(lines[1], HasSubstr(",1,0,0,0,1,2,3,1,0,0,0,0,0,0"));
  EXPECT_THAT(lines[2], StartsWith("rgbd,f1,NOT_LOCALIZED,TOO_FEW_INLIERS,"));
  EXPECT_THAT(lines[3], StartsWith("rgbd,f2,ERROR,no such file,,,,,,,"));
}

TEST(EvaluationCsv, HasPerturbedFramesAfterThoseAsTheyAre) {
  EvaluatedMethod method;
  method.name = "rgbd";
  method.results = {Localized()};
  method.perturbed = {
      {ParsePerturbations("gamma:2").value().front(), {Localized()}}};
  const std::vector<std::string> lines =
      absl::StrSplit(EvaluationCsv({method}), '\n');
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_THAT(lines[0], EndsWith(",perturbation"));
  EXPECT_THAT(lines[1], EndsWith(",0,0,0,"));
  EXPECT_THAT(lines[2], EndsWith(",0,0,0,gamma:2"));
}

TEST(EvaluationCsv, QuotesWhatWouldBreakALine) {
  FrameResult failed;
  failed.stem = "a,b";
  failed.status = absl::NotFoundError("no \"file\"\nhere");
  EvaluatedMethod method;
  method.results = {failed};
  EXPECT_THAT(EvaluationCsv({method}),
              HasSubstr("\"a,b\",ERROR,\"no \"\"file\"\"\nhere\""));
}

TEST(EvaluationCsv, IsEmptyWhereNothingIsFinite) {
  FrameResult result = Localized();
  result.estimate.world_from_camera.translation.x = std::nan("");
  EXPECT_THAT(Lines({result})[1], HasSubstr(",1,0,0,0,,2,3,"));
}

}  // namespace
}  // namespace treeline::accuracy
