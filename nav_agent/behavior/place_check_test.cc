#include "nav_agent/behavior/place_check.h"

#include <cmath>
#include <memory>
#include <optional>

#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_relocalization.h"

namespace treeline::behavior {
namespace {

constexpr double kMargin = 0.12;

localization::ScanFit Fits(double score) {
  return {.explained = score, .contradicted = 0, .judged = 100};
}

struct Comparison {
  GatedFix fix;
  localization::TrackedPose pose;
  localization::TrackedMotion motion;
  std::optional<localization::ScanFit> fit_at_pose = Fits(0.9);

  Comparison() {
    fix.fit = Fits(0.9);
    fix.covariance = FixCovariance({});
  }
  CheckVerdict Verdict() const {
    return CompareWithFix(fix, pose, motion, fit_at_pose, kMargin).verdict;
  }
};

TEST(CompareWithFix, NearPlacesAgree) {
  Comparison near;
  EXPECT_EQ(near.Verdict(), CheckVerdict::kStays);
  near.fix.pose.map_from_base = {{0.24, 0}, 0.11};
  EXPECT_EQ(near.Verdict(), CheckVerdict::kStays);
}

TEST(CompareWithFix, PlacesAgreeWithinThreeDeviations) {
  Comparison wide;
  wide.fix.pose.map_from_base = {{0.7, 0}, 0};
  wide.fix.fit = Fits(0.95);
  EXPECT_EQ(wide.Verdict(), CheckVerdict::kCorrected);
  wide.pose.covariance[0] = 0.25 * 0.25;
  EXPECT_EQ(wide.Verdict(), CheckVerdict::kStays);
}

TEST(CompareWithFix, ADriftIsCorrectedIfScansFitBetter) {
  Comparison drift;
  drift.fix.pose.map_from_base = {{0.5, 0}, 0.2};
  drift.fix.fit = Fits(0.94);
  EXPECT_EQ(drift.Verdict(), CheckVerdict::kCorrected);
  drift.fix.fit = Fits(0.92);
  EXPECT_EQ(drift.Verdict(), CheckVerdict::kStays);
  drift.fit_at_pose.reset();
  EXPECT_EQ(drift.Verdict(), CheckVerdict::kCorrected);
}

TEST(CompareWithFix, FarAwayItIsElsewhere) {
  Comparison far;
  far.fix.pose.map_from_base = {{0.81, 0}, 0};
  EXPECT_EQ(far.Verdict(), CheckVerdict::kElsewhere);
  far.fix.pose.map_from_base = {{0, 0}, 0.36};
  EXPECT_EQ(far.Verdict(), CheckVerdict::kElsewhere);
  // On another level, at the same place.
  far.fix.pose = {.map_from_base = {}, .place = {.level = 1, .height_m = 3}};
  EXPECT_EQ(far.Verdict(), CheckVerdict::kElsewhere);
}

TEST(CompareWithFix, WhereScansFitClearlyWorseItIsNot) {
  Comparison far;
  far.fix.pose.map_from_base = {{5, 0}, 0};
  far.fix.fit = Fits(0.79);
  EXPECT_EQ(far.Verdict(), CheckVerdict::kElsewhere);
  far.fix.fit = Fits(0.77);
  EXPECT_EQ(far.Verdict(), CheckVerdict::kStays);
}

TEST(CompareWithFix, CarriesTheFixOnByTheWheels) {
  Comparison driven;
  driven.motion.odom_from_base = {{3, 1}, 0.5};
  driven.pose.pose.map_from_base = {{3, 1}, 0.5};
  EXPECT_EQ(driven.Verdict(), CheckVerdict::kStays);
  const CheckFinding finding =
      CompareWithFix(driven.fix, driven.pose, driven.motion, Fits(0), kMargin);
  EXPECT_NEAR(geometry::Norm(finding.seen.map_from_base.translation -
                             geometry::Vec2{3, 1}),
              0, 1e-9);
}

class PlaceCheckTest : public testing::Test {
 protected:
  PlaceCheckTest() {
    tracker_.now = At(100);
    tracker_.believed =
        core::LevelPose{.map_from_base = tracker_.truth, .place = {}};
    server_.answers = {[] { return absl::UnavailableError("dead"); }};
  }
  bool Step(double at_s, bool drives_straight = true) {
    tracker_.now = At(at_s);
    auto frame = std::make_shared<core::RgbdFrame>();
    frame->stamp = At(at_s - picture_age_s_);
    return check_.Step({.now = tracker_.now,
                        .drives_straight = drives_straight,
                        .is_in_trouble = is_in_trouble_},
                       frame, checker_, question_, tools_);
  }

  ScriptedTracker tracker_;
  FakeServer server_{tracker_};
  std::shared_ptr<const traversability::NavigationMap> map_ =
      std::make_shared<const traversability::NavigationMap>(
          *traversability::NavigationMap::Make(TwoRooms()));
  RelocalizationBehaviorOptions options_;
  RelocalizationTools tools_{map_, core::RobotModel(), tracker_, options_};
  FixChecker checker_{map_, core::RobotModel(), options_.gate};
  ServerQuestion question_{&server_, 3};
  PlaceCheck check_{20};
  double picture_age_s_ = 0;
  bool is_in_trouble_ = false;
};

TEST_F(PlaceCheckTest, AsksARobotInTroubleSoonerAndWhileItStands) {
  is_in_trouble_ = true;
  Step(100, false);
  Step(104.9, false);
  EXPECT_EQ(server_.asked, 0);
  EXPECT_TRUE(check_.IsDue(At(105)));
  Step(105, false);
  EXPECT_EQ(server_.asked, 1);
  Step(106, false);
  Step(110, false);
  EXPECT_EQ(server_.asked, 2);
  // Out of it, as seldom as before.
  is_in_trouble_ = false;
  Step(111, false);
  EXPECT_FALSE(check_.IsDue(At(129.9)));
  Step(130, false);
  EXPECT_EQ(server_.asked, 2);
  Step(131);
  EXPECT_EQ(server_.asked, 3);
}

TEST_F(PlaceCheckTest, AsksEveryTwentySecondsOfDriving) {
  EXPECT_FALSE(check_.IsDue(At(1000)));
  Step(100);
  Step(119.9);
  EXPECT_EQ(server_.asked, 0);
  EXPECT_TRUE(check_.IsDue(At(120)));
  Step(120, false);
  EXPECT_EQ(server_.asked, 0);
  Step(121);
  EXPECT_EQ(server_.asked, 1);
  // A dead server is asked no more often.
  Step(122);
  Step(140);
  EXPECT_EQ(server_.asked, 1);
  Step(141);
  EXPECT_EQ(server_.asked, 2);
}

TEST_F(PlaceCheckTest, AsksOnlyWithANewPictureAndAPlace) {
  Step(100);
  picture_age_s_ = 0.3;
  Step(121);
  picture_age_s_ = 0;
  tracker_.searches = true;
  Step(122);
  EXPECT_EQ(server_.asked, 0);
  tracker_.searches = false;
  Step(123);
  EXPECT_EQ(server_.asked, 1);
}

TEST_F(PlaceCheckTest, WhatAPersonSaidIsCheckedSoon) {
  check_.Soon(At(100));
  Step(101.9);
  EXPECT_EQ(server_.asked, 0);
  Step(102.1);
  EXPECT_EQ(server_.asked, 1);
}

TEST_F(PlaceCheckTest, WithoutAnIntervalItNeverAsks) {
  check_ = PlaceCheck(0);
  Step(100);
  Step(1000);
  EXPECT_EQ(server_.asked, 0);
  EXPECT_FALSE(check_.IsDue(At(1000)));
}

}  // namespace
}  // namespace treeline::behavior
