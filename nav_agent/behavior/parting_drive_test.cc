#include "nav_agent/behavior/parting_drive.h"

#include <string>

#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_relocalization.h"

namespace treeline::behavior {
namespace {

class PartingDriveTest : public testing::Test {
 protected:
  PartingDriveTest() {
    tracker_.now = At(100);
    tracker_.believed =
        core::LevelPose{.map_from_base = {{2, 3}, 0}, .place = {}};
    tracker_.is_in_doubt = true;
    // The fake's scan shows things all around: between their points.
    tools_.robot.half_width_m = 0;
    tracker_.others = {
        {.pose = {.map_from_base = {{9, 3}, 0}, .place = {}}, .share = 0.5}};
    // The left room looks different at its right.
    tracker_.expected_at = [](const core::LevelPose& pose, int directions) {
      const double x_m = pose.map_from_base.translation.x;
      return std::vector<float>(static_cast<size_t>(directions),
                                x_m > 3.5 && x_m < 6 ? 1.0F : 3.0F);
    };
  }
  // All that it says.
  std::string Choose(bool was_blocked) {
    const localization::TrackedMotion motion = *tracker_.Motion();
    drive_.Begin(motion, was_blocked, tools_);
    for (int i = 0; i < 1000 && drive_.is_choosing(); ++i) {
      drive_.Step(motion, tools_, tracker_.now);
    }
    EXPECT_FALSE(drive_.is_choosing());
    std::string text;
    for (const RelocalizationNote& note : tools_.report.TakeNotes()) {
      text += note.text;
    }
    return text;
  }

  std::shared_ptr<const traversability::NavigationMap> map_ =
      std::make_shared<const traversability::NavigationMap>(
          *traversability::NavigationMap::Make(TwoRooms()));
  ScriptedTracker tracker_;
  RelocalizationTools tools_{map_, core::RobotModel(), tracker_, {}};
  PartingDrive drive_;
};

TEST_F(PartingDriveTest, NamesThePlacesThatAreLeftAndGoes) {
  const std::string text = Choose(false);
  EXPECT_NE(text.find("2 places are left: 2.00, 3.00 on level 0, 0 degrees "
                      "(50 %); 9.00, 3.00"),
            std::string::npos)
      << text;
  EXPECT_TRUE(tools_.search_motion.is_under_way());
}

TEST_F(PartingDriveTest, OnePlaceIsNotParted) {
  tracker_.others.clear();
  EXPECT_EQ(Choose(false), "");
  EXPECT_FALSE(tools_.search_motion.is_under_way());
}

TEST_F(PartingDriveTest, NothingIsKnownWhileParticlesAreEverywhere) {
  tracker_.searches = true;
  EXPECT_TRUE(PlacesLeft(tracker_).empty());
  tracker_.searches = false;
  EXPECT_EQ(PlacesLeft(tracker_).size(), 2u);
  tracker_.is_in_doubt = false;
  EXPECT_TRUE(PlacesLeft(tracker_).empty());
  tracker_.believed.reset();
  EXPECT_TRUE(PlacesLeft(tracker_).empty());
}

TEST_F(PartingDriveTest, WhatBlockedAWayIsNotTriedAgain) {
  tools_.robot.half_width_m = 4;
  // With what stopped it just ahead, so wide a robot gets nowhere.
  const std::string text = Choose(true);
  EXPECT_NE(text.find("no view in reach parts them"), std::string::npos)
      << text;
  EXPECT_FALSE(tools_.search_motion.is_under_way());
}

}  // namespace
}  // namespace treeline::behavior
