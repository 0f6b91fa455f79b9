#include "nav_agent/behavior/travel_meter.h"

#include "gtest/gtest.h"

namespace treeline::behavior {
namespace {

TEST(TravelMeter, MeasuresFromStepToStep) {
  TravelMeter travel;
  EXPECT_EQ(travel.Step_m({1, 2}), 0);
  EXPECT_NEAR(travel.Step_m({1.03, 2.04}), 0.05, 1e-12);
  EXPECT_EQ(travel.Step_m({1.03, 2.04}), 0);
}

TEST(TravelMeter, AJumpOfTheEstimateIsNoWay) {
  TravelMeter travel;
  travel.Step_m({0, 0});
  EXPECT_EQ(travel.Step_m({kMaxStepMove_m, 0}), 0);
  EXPECT_DOUBLE_EQ(travel.Step_m({kMaxStepMove_m + 0.25, 0}), 0.25);
}

TEST(TravelMeter, BeginsAnew) {
  TravelMeter travel;
  travel.Step_m({0, 0});
  travel.Restart();
  EXPECT_EQ(travel.Step_m({0.1, 0}), 0);
}

}  // namespace
}  // namespace treeline::behavior
