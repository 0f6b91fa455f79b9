#include "simulation/building/gazebo_world.h"

#include <cmath>
#include <numbers>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "simulation/building/gazebo_plan.h"
#include "simulation/building/plan_file.h"

namespace treeline::building {
namespace {

using ::testing::HasSubstr;

// A world of what is within it.
std::string World(absl::string_view inner) {
  return absl::StrCat("<sdf version='1.6'>\n<world name='default'>\n", inner,
                      "\n</world>\n</sdf>\n");
}

std::string Model(absl::string_view pose, absl::string_view shape,
                  absl::string_view more = "") {
  return absl::StrCat(
      "<model name='thing'><static>1</static><pose frame=''>", pose,
      "</pose>\n<link name='l'><collision name='c'><geometry>", shape,
      "</geometry></collision></link>", more, "</model>");
}

constexpr absl::string_view kPost =
    "<cylinder><radius>0.25</radius><length>1</length></cylinder>";
constexpr absl::string_view kBox = "<box><size>3 0.2 1</size></box>";

GazeboSolid Only(const std::string& text) {
  const auto solids = ParseGazeboWorld(text, "w.world");
  EXPECT_TRUE(solids.ok()) << solids.status();
  EXPECT_TRUE(solids.ok() && solids->size() == 1);
  return solids.ok() && !solids->empty() ? solids->front() : GazeboSolid();
}

void ExpectRefused(const std::string& text, absl::string_view why) {
  const auto solids = ParseGazeboWorld(text, "w.world");
  ASSERT_FALSE(solids.ok()) << text;
  EXPECT_EQ(solids.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(solids.status().message()),
              HasSubstr(std::string(why)));
}

TEST(GazeboWorld, ReadsCylindersAsTheBarnDataSetHasThem) {
  // Its cylinders stand half below the ground.
  const GazeboSolid solid = Only(World(Model("-0.075 4.575 0.0 0 0 0", kPost)));
  EXPECT_EQ(solid.model, "thing");
  EXPECT_EQ(solid.line, 4);
  EXPECT_TRUE(solid.is_round);
  EXPECT_DOUBLE_EQ(solid.x_m, -0.075);
  EXPECT_DOUBLE_EQ(solid.y_m, 4.575);
  EXPECT_DOUBLE_EQ(solid.along_m, 0.5);
  EXPECT_DOUBLE_EQ(solid.bottom_m, -0.5);
  EXPECT_DOUBLE_EQ(solid.top_m, 0.5);
}

TEST(GazeboWorld, PosesOfModelLinkAndCollisionAreChained) {
  const GazeboSolid solid = Only(World(absl::StrReplaceAll(
      Model("1 2 0 0 0 1.5707963267948966", kBox),
      {{"<link name='l'>", "<link name='l'><pose>1 0 0.5 0 0 0</pose>"},
       {"<collision name='c'>",
        "<collision name='c'><pose>0 0.5 0 0 0 0</pose>"}})));
  EXPECT_NEAR(solid.x_m, 0.5, 1e-9);
  EXPECT_NEAR(solid.y_m, 3, 1e-9);
  EXPECT_NEAR(std::abs(solid.yaw_rad), std::numbers::pi / 2, 1e-9);
  EXPECT_DOUBLE_EQ(solid.along_m, 3);
  EXPECT_DOUBLE_EQ(solid.across_m, 0.2);
  EXPECT_DOUBLE_EQ(solid.top_m, 1);
}

TEST(GazeboWorld, ABoxOnItsEndIsUpright) {
  const GazeboSolid solid =
      Only(World(Model("0 0 1.5 0 1.5707963267948966 0", kBox)));
  EXPECT_NEAR(solid.top_m, 3, 1e-9);
  EXPECT_NEAR(std::min(solid.along_m, solid.across_m), 0.2, 1e-9);
  EXPECT_NEAR(std::max(solid.along_m, solid.across_m), 1, 1e-9);
}

TEST(GazeboWorld, TheSavedStateCounts) {
  const GazeboSolid solid = Only(World(
      absl::StrCat(Model("1 1 0.5 0 0 0", kPost),
                   "<state world_name='default'><model name='thing'>"
                   "<pose frame=''>4 5 0.5 0 0 0</pose></model></state>")));
  EXPECT_DOUBLE_EQ(solid.x_m, 4);
  EXPECT_DOUBLE_EQ(solid.y_m, 5);
}

TEST(GazeboWorld, PassesOverTheGroundAndTheSun) {
  const auto solids = ParseGazeboWorld(
      World("<include><uri>model://ground_plane</uri></include>\n"
            "<include><uri> model://sun </uri></include>\n"
            "<model name='ground'><link name='l'><collision name='c'><geometry>"
            "<plane><normal>0 0 1</normal><size>100 100</size></plane>"
            "</geometry></collision></link></model><gravity>0 0 -9.8</gravity>"
            "<plugin name='ros' filename='libgazebo_ros_init.so'/>"),
      "w.world");
  ASSERT_TRUE(solids.ok()) << solids.status();
  EXPECT_TRUE(solids->empty());
}

TEST(GazeboWorld, RefusesByNameWhatItCannotRead) {
  ExpectRefused(World("<include><uri>model://cafe_table</uri></include>"),
                "w.world:3: the model 'model://cafe_table'");
  ExpectRefused(World(Model("0 0 0 0 0 0", kPost,
                            "<plugin name='p' filename='easylibobs_51.so'/>")),
                "model 'thing': a plugin, 'easylibobs_51.so', moves it");
  ExpectRefused(World(Model("0 0 0 0 0 0", "<mesh><uri>a.dae</uri></mesh>")),
                "model 'thing': its shape is a <mesh>");
  ExpectRefused(World(Model("0 0 0 1.2 0 0", kPost)), "tilted");
  ExpectRefused(World(Model("0 0 0 0.3 0 0", kBox)), "tilted");
  ExpectRefused(
      World(Model("0 0 1 0 0 0",
                  "<plane><normal>0 0 1</normal><size>1 1</size></plane>")),
      "not the ground");
  ExpectRefused(World(Model("0 0 0 0 0", kPost)), "the pose '0 0 0 0 0'");
  ExpectRefused(World(Model("0 0 0 0 0 nan", kPost)), "not six numbers");
  ExpectRefused(World(Model("0 0 0 0 0 0", "<box><size>1 2</size></box>")),
                "<size> of <box> is '1 2', not 3 numbers");
  ExpectRefused(
      World(Model("0 0 0 0 0 0", kPost, "<joint name='j' type='fixed'/>")),
      "it has a <joint>");
  ExpectRefused(World("<actor name='walker'/>"), "<actor> 'walker'");
  ExpectRefused(absl::StrReplaceAll(World(Model("0 0 0 0 0 0", kPost)),
                                    {{"frame=''", "relative_to='table'"}}),
                "in the frame 'table'");
  ExpectRefused("<sdf><model name='m'/></sdf>", "no world of Gazebo");
  // As DynaBARN's worlds have it; no reader of XML takes that.
  ExpectRefused(absl::StrReplaceAll(World(Model("0 0 0 0 0 0", kPost)),
                                    {{"frame=''", "frame="}}),
                "w.world:3: this is no XML");
}

TEST(GazeboPlan, IsAPlanThatAWorldFileCanHold) {
  const auto solids = ParseGazeboWorld(
      World(absl::StrCat(
          Model("-2 3 0 0 0 0", kPost), Model("1 0 0.5 0 0 0.7", kBox),
          // Overhead, and below the ground.
          Model("5 5 3 0 0 0", kBox), Model("7 5 -3 0 0 0", kBox))),
      "w.world");
  ASSERT_TRUE(solids.ok()) << solids.status();
  const auto plan = GazeboPlan(*solids, "w.world");
  ASSERT_TRUE(plan.ok()) << plan.status();
  ASSERT_EQ(plan->pillars.size(), 1);
  ASSERT_EQ(plan->walls.size(), 1);
  ASSERT_EQ(plan->places.size(), 2);
  const PlanPoint origin = plan->places[1].stand.at;
  EXPECT_NEAR(plan->pillars[0].at.x_m - origin.x_m, -2, 1.5e-3);
  EXPECT_NEAR(plan->pillars[0].at.y_m - origin.y_m, 3, 1.5e-3);
  EXPECT_DOUBLE_EQ(plan->pillars[0].width_m, 0.5);
  EXPECT_DOUBLE_EQ(plan->pillars[0].height_m, 0.5);
  const PlanWall& wall = plan->walls[0];
  EXPECT_NEAR(
      std::hypot(wall.to.x_m - wall.from.x_m, wall.to.y_m - wall.from.y_m), 3,
      2e-3);
  EXPECT_NEAR((wall.to.x_m + wall.from.x_m) / 2 - origin.x_m, 1, 1.5e-3);
  EXPECT_DOUBLE_EQ(wall.thickness_m, 0.2);
  // A robot that starts there stands clear of both.
  const PlanPoint start = plan->places[0].stand.at;
  EXPECT_GE(std::hypot(start.x_m - plan->pillars[0].at.x_m,
                       start.y_m - plan->pillars[0].at.y_m),
            1.7);
  const auto again = ParsePlan(PlanText(*plan), "again.yaml");
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(*again, *plan);
}

TEST(GazeboPlan, RefusesByNameWhatHoversAndWhatIsTooFar) {
  const auto refusal = [](const std::string& text) {
    const auto solids = ParseGazeboWorld(text, "w.world");
    EXPECT_TRUE(solids.ok()) << solids.status();
    return std::string(GazeboPlan(*solids, "w.world").status().message());
  };
  EXPECT_THAT(refusal(World(Model("0 0 1.2 0 0 0", kBox))),
              HasSubstr("w.world:4: model 'thing': it begins 0.7 m above"));
  EXPECT_THAT(refusal(World(Model("400 0 0.5 0 0 0", kBox))),
              HasSubstr("larger than 196 m"));
  EXPECT_THAT(refusal(World(
                  Model("0 0 0.5 0 0 0", "<box><size>100 100 1</size></box>"))),
              HasSubstr("has a robot room"));
}

}  // namespace
}  // namespace treeline::building
