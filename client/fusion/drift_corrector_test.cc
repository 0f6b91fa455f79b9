#include "client/fusion/drift_corrector.h"

#include <vector>

#include "client/fusion/testing_device.h"
#include "gmock/gmock.h"

namespace treeline::drift {
namespace {

using ::testing::ElementsAre;

constexpr double kExact_m = 1e-9;

double DistanceOf(const geometry::Rigid3& a, const geometry::Rigid3& b) {
  return Norm(a.translation - b.translation);
}

TEST(DriftCorrectorTest, OneFixIsNoWorldTwoThatAgreeAre) {
  TestingDevice device;
  EXPECT_EQ(device.Step().state, DriftState::kSearching);
  EXPECT_EQ(device.Add(), FixVerdict::kHeld);
  const DriftEstimate alone = device.Step();
  EXPECT_EQ(alone.state, DriftState::kTentative);
  EXPECT_FALSE(alone.world_from_device.has_value());
  EXPECT_FALSE(alone.since_good_fix_s.has_value());
  EXPECT_EQ(device.Add(), FixVerdict::kLocked);
  const DriftEstimate locked = device.Step();
  EXPECT_EQ(locked.state, DriftState::kLocked);
  EXPECT_TRUE(locked.snapped);
  EXPECT_LE(DistanceOf(*locked.world_from_device, TestingDevice::World()),
            kExact_m);
  EXPECT_LE(DistanceOf(*locked.world_from_camera,
                       TestingDevice::World() * At(device.x_m)),
            kExact_m);
  EXPECT_EQ(device.corrector.world_from_device(), locked.world_from_device);
  EXPECT_NEAR(*locked.since_good_fix_s, 0.1, 1e-9);
  EXPECT_FALSE(device.Step().snapped);
}

TEST(DriftCorrectorTest, FixesOfOneViewCountAsOneUntilThereAreFour) {
  TestingDevice device;
  std::vector<FixVerdict> verdicts;
  for (int i = 0; i < 4; ++i) {
    verdicts.push_back(device.Add());
    device.Step(0);
  }
  EXPECT_THAT(verdicts, ElementsAre(FixVerdict::kHeld, FixVerdict::kHeld,
                                    FixVerdict::kHeld, FixVerdict::kLocked));
}

TEST(DriftCorrectorTest, OneWrongFixMovesNothingHoweverSureItIs) {
  TestingDevice device;
  device.Lock();
  Fix lie = device.FixOf(At(13));
  lie.confidence = 1;
  lie.covariance = Diagonal(1e-8, 1e-8);
  EXPECT_EQ(device.corrector.AddFix(lie).value(), FixVerdict::kHeld);
  const DriftEstimate after = device.Walk(20);
  EXPECT_LE(DistanceOf(*after.world_from_device, TestingDevice::World()),
            kExact_m);
  EXPECT_EQ(after.contradicting_views, 1);
  EXPECT_EQ(device.Add(), FixVerdict::kApplied);
  EXPECT_EQ(device.Step().contradicting_views, 0);
}

TEST(DriftCorrectorTest, AWorldIsGivenUpForThreeViewsAndSmoothly) {
  TestingDevice device;
  device.Lock();
  const geometry::Rigid3 other = At(10.6);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(device.Add(other), FixVerdict::kHeld);
    device.Walk(4);
  }
  EXPECT_EQ(device.Add(other), FixVerdict::kJumped);
  geometry::Rigid3 last = *device.Step().world_from_device;
  for (int i = 0; i < 60; ++i) {
    const DriftEstimate estimate = device.Step();
    EXPECT_FALSE(estimate.snapped);
    // 5 cm a second.
    EXPECT_LE(DistanceOf(*estimate.world_from_device, last), 0.005 + kExact_m);
    last = *estimate.world_from_device;
  }
  EXPECT_LE(DistanceOf(*device.Walk(80).world_from_device, other), 0.02);
}

TEST(DriftCorrectorTest, WithoutGoodFixesTheWorldIsLostAndFoundElsewhere) {
  TestingDevice device({.lost_after_s = 2});
  device.Lock();
  EXPECT_EQ(device.Walk(21).state, DriftState::kLost);
  EXPECT_EQ(device.Add(At(10.5)), FixVerdict::kHeld);
  device.Step();
  EXPECT_EQ(device.Add(At(10.5)), FixVerdict::kJumped);
  const DriftEstimate found = device.Step();
  EXPECT_EQ(found.state, DriftState::kLocked);
  EXPECT_TRUE(found.snapped);
}

TEST(DriftCorrectorTest, OnlySoManyGuessesAreKeptTheNewest) {
  TestingDevice device({.max_hypotheses = 2});
  for (const double x : {0, 20, 40}) {
    device.Add(At(x));
    device.Step();
  }
  // The first was forgotten, the last was not.
  EXPECT_EQ(device.Add(At(0)), FixVerdict::kHeld);
  device.Step();
  EXPECT_EQ(device.Add(At(40)), FixVerdict::kLocked);
}

TEST(DriftCorrectorTest, OfTwoThatAgreeAsOftenNoneIsTheWorld) {
  TestingDevice device;
  device.Add();
  device.Step();
  for (int i = 0; i < 2; ++i) {
    device.Add(At(-10), 0.75);
    device.Step();
  }
  EXPECT_EQ(device.Add(), FixVerdict::kHeld);
  device.Step();
  EXPECT_EQ(device.Add(), FixVerdict::kLocked);
}

TEST(DriftCorrectorTest, WhatNobodySupportsIsForgotten) {
  TestingDevice device({.hypothesis_lifetime_s = 1});
  device.Add();
  EXPECT_EQ(device.Walk(10).state, DriftState::kTentative);
  EXPECT_EQ(device.Step().state, DriftState::kSearching);
}

TEST(DriftCorrectorTest, ContradictingViewsAreCountedNoFurtherThanNeeded) {
  // Odds of 1: no number of them is ever enough.
  TestingDevice device;
  device.Lock();
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(device.Add(At(20), 0.5), FixVerdict::kHeld);
    device.Walk(4);
  }
  EXPECT_EQ(device.Step().contradicting_views, 3);
}

TEST(DriftCorrectorTest, AResetForgetsTheWorldButNotWhenItLastWasGood) {
  TestingDevice device;
  device.Lock();
  device.corrector.Reset();
  EXPECT_EQ(device.corrector.state(), DriftState::kSearching);
  EXPECT_FALSE(device.corrector.world_from_device().has_value());
  const DriftEstimate estimate = device.Step();
  EXPECT_FALSE(estimate.tracking_broke);
  EXPECT_GT(*estimate.since_good_fix_s, 0);
}

TEST(DriftCorrectorTest, AMovedCorrectorGoesOn) {
  TestingDevice device;
  device.Lock();
  DriftCorrector moved = std::move(device.corrector);
  EXPECT_EQ(moved.state(), DriftState::kLocked);
  device.corrector = std::move(moved);
  EXPECT_EQ(device.Add(), FixVerdict::kApplied);
}

}  // namespace
}  // namespace treeline::drift
