#include "evaluation/accuracy/perturbation_table.h"

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::accuracy {
namespace {

using ::testing::ContainsRegex;

FrameResult Answered(double translation_m) {
  FrameResult result;
  result.estimate = tools::LocalizedAt({});
  result.estimate.confidence = 0.9;
  result.true_world_from_camera = geometry::Rigid3{};
  result.error = geometry::PoseError{translation_m, 0};
  result.latency_ms = 12.5;
  return result;
}

FrameResult OfNoPlace() {
  FrameResult result = Answered(0);
  result.true_world_from_camera.reset();
  result.error.reset();
  return result;
}

// Right on all frames as they are, on one of two and on none of the changed.
EvaluatedMethod SomeMethod(const std::string& name) {
  EvaluatedMethod method;
  method.name = name;
  const std::vector<Perturbation> changes =
      ParsePerturbations("gamma:2,blur:9,mirror").value();
  method.perturbed = {{{}, {Answered(0.01), Answered(0.01)}},
                      {changes[0], {Answered(0.01), Answered(0.07)}},
                      {changes[1], {Answered(0.3), Answered(0.07)}},
                      {changes[2], {OfNoPlace(), OfNoPlace()}}};
  return method;
}

TEST(PerturbationRows, CountEachPerturbationApart) {
  const std::vector<PerturbationRow> rows =
      PerturbationRows(SomeMethod("a"), 0.5);
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[0].name, "as it is");
  EXPECT_EQ(rows[0].counts.right, 2);
  EXPECT_EQ(rows[1].counts.right, 1);
  EXPECT_EQ(rows[2].counts.gross, 1);
  EXPECT_TRUE(rows[3].is_foreign);
  EXPECT_EQ(rows[3].counts.wrong, 2);
}

TEST(RightOverRows, LeavesOutTheFramesAsTheyAreAndTheForeign) {
  const auto overall = RightOverRows(PerturbationRows(SomeMethod("a"), 0.5));
  ASSERT_TRUE(overall.has_value());
  EXPECT_DOUBLE_EQ(overall->mean, 0.25);
  EXPECT_DOUBLE_EQ(overall->worst, 0);
  EXPECT_FALSE(RightOverRows({}).has_value());
}

TEST(PerturbationTable, HasALineAPerturbationAndColumnsAMethod) {
  EvaluatedMethod failed;
  failed.status = absl::NotFoundError("gone");
  const std::string table =
      PerturbationTable({SomeMethod("one"), failed, SomeMethod("two")}, {});
  EXPECT_THAT(table, ContainsRegex("\\| one .*\\| two "));
  EXPECT_THAT(table, ContainsRegex("as it is .* 100.0 .* 0 .* 12.50"));
  EXPECT_THAT(table, ContainsRegex("blur:9 .* 0.0 .* 2 \\(1\\)"));
  EXPECT_THAT(table, ContainsRegex("mirror .* - .* 2 \\(2\\)"));
  EXPECT_THAT(table, ContainsRegex("mean of the changed .* 25.0"));
  EXPECT_THAT(table, ContainsRegex("worst .* 0.0"));
}

TEST(PerturbationTable, IsEmptyWhereNothingWasPerturbed) {
  EXPECT_EQ(PerturbationTable({EvaluatedMethod()}, {}), "");
}

}  // namespace
}  // namespace treeline::accuracy
