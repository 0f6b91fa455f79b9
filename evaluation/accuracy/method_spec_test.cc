#include "evaluation/accuracy/method_spec.h"

#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::accuracy {
namespace {

using ::testing::HasSubstr;

TEST(ParseMethod, KnowsMethodsBaselinesAblationsAndFiles) {
  const MethodSpec rgbd = *ParseMethod("rgbd");
  EXPECT_EQ(rgbd.trained_method, "rgbd");
  EXPECT_TRUE(rgbd.NeedsTraining());
  EXPECT_EQ(ParseMethod("orb-pnp")->baseline, FeatureKind::kOrb);
  EXPECT_FALSE(ParseMethod("orb-pnp")->NeedsTraining());
  const MethodSpec file = *ParseMethod("old=/m/a=b.treeline");
  EXPECT_EQ(file.name, "old");
  EXPECT_EQ(file.model_path, "/m/a=b.treeline");
  EXPECT_FALSE(file.NeedsTraining());
}

TEST(ParseMethod, TurnsBalanceAndBacktrackingOffForAblations) {
  const MethodSpec ubrf = *ParseMethod("ubrf");
  EXPECT_EQ(ubrf.trained_method, "rgbd");
  EXPECT_EQ(TrainingFor(ubrf, {}).balanced_levels, 0);
  EXPECT_EQ(QueriesFor(ubrf, {}).backtracking_leaves, 1);
  const MethodSpec brf = *ParseMethod("brf");
  EXPECT_EQ(TrainingFor(brf, {}).balanced_levels,
            training::TrainingOptions().balanced_levels);
  EXPECT_EQ(QueriesFor(brf, {}).backtracking_leaves, 1);
}

TEST(ParseMethod, NamesWhatCanBeComparedWhereItIsNotKnown) {
  const absl::Status status = ParseMethod("magic").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("sift-pnp, orb-pnp, fast-sift-pnp"));
  EXPECT_FALSE(ParseMethod("=file").ok());
  EXPECT_FALSE(ParseMethod("name=").ok());
}

TEST(ParseMethods, KeepsTheOrderAndRefusesRepetition) {
  const std::vector<MethodSpec> specs = *ParseMethods("brf,rgbd,sift-pnp");
  ASSERT_EQ(specs.size(), 3u);
  EXPECT_EQ(specs[0].name, "brf");
  EXPECT_EQ(specs[2].name, "sift-pnp");
  EXPECT_FALSE(ParseMethods("rgbd,rgbd").ok());
  EXPECT_FALSE(ParseMethods("").ok());
  EXPECT_FALSE(ParseMethods("rgbd,").ok());
}

TEST(InputsOfMethod, SaysWhatAQueryNeeds) {
  EXPECT_EQ(InputsOfMethod("rgbd").query, "RGB-D");
  EXPECT_EQ(InputsOfMethod("sift-pnp").query, "RGB");
  EXPECT_EQ(InputsOfMethod("unheard-of").query, "");
}

}  // namespace
}  // namespace treeline::accuracy
