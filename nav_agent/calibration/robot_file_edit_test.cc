#include "nav_agent/calibration/robot_file_edit.h"

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::calibration {
namespace {

using ::testing::HasSubstr;

std::vector<FileEntry> Entries() {
  return {{"", "wheel_track_m", "0.5562", ""},
          {"odometry", "left_scale", "1.0100", ""},
          {"laser", "at", "[0.26, -0.04, 0.35]", ""},
          {"laser", "yaw_rad", "0.0262", ""}};
}

std::string Edited(const std::string& text) {
  const auto edited = WithEntries(text, "robot.yaml", Entries());
  EXPECT_TRUE(edited.ok()) << edited.status();
  return edited.value_or("");
}

TEST(RobotFileEdit, KeepsCommentsInFilesOverLines) {
  EXPECT_EQ(Edited("# our robot\n"
                   "like: jackal\n"
                   "wheel_track_m: 0.54  # by tape\n"
                   "laser:\n"
                   "    # on the front plate\n"
                   "    at: [0.22, 0, 0.35]   # by tape, too\n"
                   "    beams: 181\n"
                   "height_m: 1.2\n"),
            "# our robot\n"
            "like: jackal\n"
            "wheel_track_m: 0.5562  # by tape\n"
            "laser:\n"
            "    yaw_rad: 0.0262\n"
            "    # on the front plate\n"
            "    at: [0.26, -0.04, 0.35]   # by tape, too\n"
            "    beams: 181\n"
            "height_m: 1.2\n"
            "odometry:\n"
            "  left_scale: 1.0100\n");
}

TEST(RobotFileEdit, EditsSectionsInBraces) {
  EXPECT_EQ(Edited("laser: {at: [0.1, 0, 0.2], beams: 181}  # near\n"
                   "rear_laser: {at: [-0.1, 0, 0.2]}\n"
                   "odometry: {}"),
            "laser: {yaw_rad: 0.0262, at: [0.26, -0.04, 0.35], beams: 181}  # "
            "near\n"
            "rear_laser: {at: [-0.1, 0, 0.2]}\n"
            "odometry: {left_scale: 1.0100}\n"
            "wheel_track_m: 0.5562\n");
}

TEST(RobotFileEdit, IsNotMisledByCommentsAndTexts) {
  EXPECT_EQ(Edited("# wheel_track_m: 9\n"
                   "like: rmp100 # laser: {at: [1, 2, 3]}\n"
                   "wheel_track_m:   0.5\n"),
            "# wheel_track_m: 9\n"
            "like: rmp100 # laser: {at: [1, 2, 3]}\n"
            "wheel_track_m:   0.5562\n"
            "odometry:\n"
            "  left_scale: 1.0100\n"
            "laser:\n"
            "  yaw_rad: 0.0262\n"
            "  at: [0.26, -0.04, 0.35]\n");
}

TEST(RobotFileEdit, IsTheSameWhenItIsDoneTwice) {
  const std::string once = Edited("like: jackal\n");
  EXPECT_EQ(Edited(once), once);
}

TEST(RobotFileEdit, RefusesWhatItCannotEdit) {
  for (const char* text :
       {"laser: &l {beams: 3}\nrear_laser: *l\nwheel_track_m: *x\n",
        "laser: none\n", "laser:\n  - 1\n"}) {
    const auto edited = WithEntries(text, "robot.yaml", Entries());
    EXPECT_FALSE(edited.ok()) << text;
    EXPECT_THAT(edited.status().message(), HasSubstr("robot.yaml"));
  }
  EXPECT_FALSE(WithEntries("- 1\n", "r", Entries()).ok());
  EXPECT_FALSE(WithEntries("", "r", Entries()).ok());
  EXPECT_FALSE(WithEntries("a: [", "r", Entries()).ok());
}

}  // namespace
}  // namespace treeline::calibration
