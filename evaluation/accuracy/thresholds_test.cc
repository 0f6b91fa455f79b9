#include "evaluation/accuracy/thresholds.h"

#include <vector>

#include "gtest/gtest.h"

namespace treeline::accuracy {
namespace {

FrameResult TrueAt(geometry::Vec3 position) {
  FrameResult result;
  result.true_world_from_camera = geometry::Rigid3{{}, position};
  return result;
}

TEST(ParseThreshold, TakesCentimetresOrPerCent) {
  EXPECT_EQ(*ParseThreshold("7.5,3"),
            (ThresholdRequest{.translation = 7.5, .rotation_deg = 3}));
  EXPECT_EQ(*ParseThreshold("0.5%,2"),
            (ThresholdRequest{
                .translation = 0.5, .relative = true, .rotation_deg = 2}));
}

TEST(ParseThreshold, RefusesWhatIsNoPairOfPositiveNumbers) {
  for (const char* text : {"", "5", "5,", ",5", "5,5,5", "a,b", "-1,5", "0,5",
                           "nan,5", "inf,1", "%,5", "5,5%"}) {
    EXPECT_EQ(ParseThreshold(text).status().code(),
              absl::StatusCode::kInvalidArgument)
        << text;
  }
}

TEST(Resolve, ScalesARelativeThresholdWithTheScene) {
  const std::vector<FrameResult> results{TrueAt({1, 1, 1}), FrameResult{},
                                         TrueAt({4, 5, 1})};
  EXPECT_EQ(SceneSize_m(results), 5);
  const auto relative = Resolve(*ParseThreshold("2%,3"), SceneSize_m(results));
  EXPECT_EQ(relative, (PoseThreshold{0.1, 3}));
  EXPECT_EQ(Resolve(*ParseThreshold("2,3"), std::nullopt),
            (PoseThreshold{0.02, 3}));
  EXPECT_FALSE(Resolve(*ParseThreshold("2%,3"), std::nullopt).has_value());
}

TEST(SceneSize, IsUnknownForCamerasThatStandStill) {
  EXPECT_FALSE(SceneSize_m({}).has_value());
  EXPECT_FALSE(SceneSize_m({TrueAt({1, 2, 3}), TrueAt({1, 2, 3})}).has_value());
}

TEST(ThresholdText, SaysBothBounds) {
  EXPECT_EQ(ThresholdText(*ParseThreshold("5,5")), "5 cm / 5°");
  EXPECT_EQ(ThresholdText(*ParseThreshold("0.5%,2")), "0.5 % / 2°");
}

}  // namespace
}  // namespace treeline::accuracy
