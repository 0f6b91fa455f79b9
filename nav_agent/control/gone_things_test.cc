#include "nav_agent/control/gone_things.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/control/local_costmap.h"
#include "nav_agent/control/testing_floor.h"

namespace treeline::control {
namespace {

struct Box {
  geometry::Vec3 low;
  geometry::Vec3 high;
};

// Where a ray meets a box, in lengths of `way`; infinity: nowhere.
double Meets(const Box& box, geometry::Vec3 from, geometry::Vec3 way) {
  double enter = 0;
  double leave = std::numeric_limits<double>::infinity();
  for (const auto& [at, step, low, high] :
       {std::array{from.x, way.x, box.low.x, box.high.x},
        std::array{from.y, way.y, box.low.y, box.high.y},
        std::array{from.z, way.z, box.low.z, box.high.z}}) {
    const double a = (low - at) / step;
    const double b = (high - at) / step;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave ? enter : std::numeric_limits<double>::infinity();
}

// A floor at height 0 with boxes, walls around (6, 6), and a robot there
// whose map may have more.
class GoneThingsTest : public testing::Test {
 protected:
  // A thing of the map: 0.15 x 0.3 m, 1.75 to 1.9 m before the robot.
  GoneThingsTest() {
    floor_.Fill({7.75, 5.85}, {7.9, 6.15}, core::Occupancy::kOccupied);
  }

  void Start() {
    costmap_.emplace(*LocalCostmap::Make(floor_.Map(), robot_,
                                         {.front = TestingLaser()}, {}));
  }
  // A depth picture and the scans around it.
  void Look(int frames, double from_s = 0) {
    if (!costmap_.has_value()) Start();
    for (int i = 0; i < frames; ++i) {
      ControlPose pose = pose_;
      for (int scan = 0; scan < 8; ++scan) {
        pose.stamp = TestingTime(from_s + 0.2 * i + 0.025 * scan);
        costmap_->MoveTo(pose);
        ASSERT_TRUE(costmap_->AddScan(pose, Scan(pose)).ok());
        costmap_->Update(pose.stamp);
      }
      if (has_camera_) {
        ASSERT_TRUE(costmap_->AddDepth(pose, Depth(pose)).ok());
      }
    }
    costmap_->MoveTo(pose_);
    costmap_->Update(TestingTime(from_s + 0.2 * frames));
  }
  bool IsFree(geometry::Vec2 at) const {
    return costmap_->CellAt(at) == LocalCell::kFree;
  }
  bool IsGone() const { return IsFree({7.825, 6.0}); }

  double Range(geometry::Vec3 from, geometry::Vec3 way) const {
    double nearest = way.z < 0 ? -from.z / way.z : 1e9;
    for (const Box& box : boxes_) {
      nearest = std::min(nearest, Meets(box, from, way));
    }
    for (const double wall : {6 - walls_m_, 6 + walls_m_}) {
      for (const double along :
           {(wall - from.x) / way.x, (wall - from.y) / way.y}) {
        if (along > 0) nearest = std::min(nearest, along);
      }
    }
    return nearest;
  }
  core::LaserScan Scan(const ControlPose& pose) const {
    const core::RangeSensorInfo laser = TestingLaser();
    const geometry::Rigid3 map_from_laser =
        MapFromBase3(pose) * robot_.base_from_laser;
    core::LaserScan scan;
    scan.stamp = pose.stamp;
    for (int beam = 0; beam < laser.beams; ++beam) {
      const double angle_rad = laser.AngleOf_rad(beam) + 1e-9;
      scan.ranges_m.push_back(static_cast<float>(Range(
          map_from_laser.translation,
          map_from_laser.rotation *
              geometry::Vec3{std::cos(angle_rad), std::sin(angle_rad), 0})));
    }
    return scan;
  }
  core::RgbdFrame Depth(const ControlPose& pose) const {
    core::RgbdFrame frame;
    frame.stamp = pose.stamp;
    frame.frame.calibration = camera::RgbdCalibration();
    frame.frame.calibration->color = *camera::Camera::Create(
        camera::CameraModel::kPinhole, 160, 120,
        std::array<double, 4>{140, 140, 79.5, 59.5}.data(), 4);
    frame.frame.calibration->depth = frame.frame.calibration->color;
    const geometry::Rigid3 map_from_camera =
        MapFromBase3(pose) * robot_.base_from_camera;
    image::DepthImage depth = {.width = 160, .height = 120, .values = {}};
    for (int y = 0; y < 120; ++y) {
      for (int x = 0; x < 160; ++x) {
        const double z_m = Range(
            map_from_camera.translation,
            map_from_camera.rotation *
                geometry::Vec3{(x - 79.5) / 140 + 1e-9, (y - 59.5) / 140, 1});
        depth.values.push_back(static_cast<uint16_t>(
            z_m > camera_range_m_ ? 0 : std::lround(1000 * z_m)));
      }
    }
    frame.frame.depth = depth;
    return frame;
  }

  core::RobotModel robot_;
  TestingFloor floor_;
  std::vector<Box> boxes_;
  ControlPose pose_ = TestingPose(6, 6);
  bool has_camera_ = true;
  double camera_range_m_ = 4.5;
  double walls_m_ = 4;
  std::optional<LocalCostmap> costmap_;
};

TEST_F(GoneThingsTest, WhatBothSensorsSeeThroughIsGone) {
  Start();
  Look(2);
  EXPECT_FALSE(IsGone());
  EXPECT_EQ(costmap_->freed(), nullptr);
  Look(1, 0.4);
  EXPECT_TRUE(IsGone());
  EXPECT_GT(costmap_->FootprintDistance_m({.translation = {7.6, 6}}, 0.5), 0.4);
  ASSERT_NE(costmap_->freed(), nullptr);
  EXPECT_EQ(costmap_->freed()->cells().size(), 18);
}

TEST_F(GoneThingsTest, WhatStandsThereStays) {
  boxes_ = {{{7.75, 5.85, 0}, {7.9, 6.15, 0.9}}};
  Look(6);
  EXPECT_EQ(costmap_->freed(), nullptr);
}

// Low things, tops of tables and what hangs: the laser sees through them all.
TEST_F(GoneThingsTest, WhatTheLaserDoesNotMeetStays) {
  for (const auto& [low_m, high_m] :
       {std::pair{0.0, 0.1}, std::pair{0.0, 0.17}, std::pair{0.0, 0.3},
        std::pair{0.45, 0.5}, std::pair{0.7, 0.74}, std::pair{1.1, 1.2}}) {
    boxes_ = {{{7.75, 5.85, low_m}, {7.9, 6.15, high_m}}};
    costmap_.reset();
    Look(6);
    EXPECT_EQ(costmap_->freed(), nullptr) << low_m << " " << high_m;
  }
}

TEST_F(GoneThingsTest, WhatOnlyTheLaserMeetsStays) {
  // Depth cameras miss what is black.
  has_camera_ = false;
  Look(6);
  EXPECT_EQ(costmap_->freed(), nullptr);
}

// From a pose that is off, a part of a thing is where the map has nothing, and
// the map's other part is seen through.
TEST_F(GoneThingsTest, WhatIsSeenBesideItsPlaceStays) {
  for (const double off_m : {-0.1, -0.05, 0.05, 0.1}) {
    boxes_ = {{{7.75, 5.85 + off_m, 0}, {7.9, 6.15 + off_m, 0.9}}};
    costmap_.reset();
    Look(6);
    EXPECT_EQ(costmap_->freed(), nullptr) << off_m;
  }
}

TEST_F(GoneThingsTest, OneLegOfManyKeepsAll) {
  boxes_ = {{{7.78, 6.11, 0}, {7.81, 6.14, 0.5}}};
  Look(6);
  EXPECT_EQ(costmap_->freed(), nullptr);
}

TEST_F(GoneThingsTest, AHoleInTheFloorStays) {
  // The floor is 0.3 m lower there: what a camera sees of a hole.
  floor_.Raise({0, 0}, {12, 12}, 0.3);
  pose_.pose.place.height_m = 0.3;
  Look(6);
  EXPECT_EQ(costmap_->freed(), nullptr);
}

TEST_F(GoneThingsTest, WhatIsTooNearToBeSeenToTheFloorStays) {
  floor_.Fill({6.7, 5.95}, {6.8, 6.05}, core::Occupancy::kOccupied);
  Look(6);
  EXPECT_FALSE(IsFree({6.75, 6}));
  EXPECT_TRUE(IsGone());
}

TEST_F(GoneThingsTest, DepthMayLackWhereTheLaserSeesFar) {
  // The wall is too far for the camera.
  walls_m_ = 5.9;
  Look(6);
  EXPECT_TRUE(IsGone());
  // Where even the floor behind lacks, it may be the thing that does.
  camera_range_m_ = 2.2;
  costmap_.reset();
  Look(6);
  EXPECT_EQ(costmap_->freed(), nullptr);
}

TEST_F(GoneThingsTest, WhoStandsThereHoldsItUpUntilHeHasGone) {
  boxes_ = {{{7.78, 5.95, 0}, {7.86, 6.05, 1.7}}};
  Look(4);
  EXPECT_EQ(costmap_->freed(), nullptr);
  boxes_.clear();
  Look(4, 2);
  EXPECT_TRUE(IsGone());
}

TEST_F(GoneThingsTest, WhatComesBackIsAnObstacleThatIsSeen) {
  Look(4);
  ASSERT_TRUE(IsGone());
  boxes_ = {{{7.75, 5.85, 0}, {7.9, 6.15, 0.9}}};
  Look(2, 1);
  EXPECT_EQ(costmap_->CellAt({7.775, 6}), LocalCell::kSeen);
}

TEST_F(GoneThingsTest, IsForgottenUnseen) {
  Look(4);
  ASSERT_TRUE(IsGone());
  pose_.pose.map_from_base.yaw_rad = std::numbers::pi;
  Look(1, 10);
  EXPECT_TRUE(IsGone());
  Look(1, 80);
  EXPECT_FALSE(IsGone());
  EXPECT_EQ(costmap_->freed(), nullptr);
}

TEST_F(GoneThingsTest, IsForgottenWhenTheRobotWasElsewhere) {
  Look(4);
  ASSERT_TRUE(IsGone());
  // What was seen is cleared, what is gone is not: the pose is as before.
  costmap_->ClearObstacles();
  EXPECT_TRUE(IsGone());
  pose_ = TestingPose(6.2, 6, std::numbers::pi);
  Look(1, 1);
  EXPECT_FALSE(IsGone());
}

TEST_F(GoneThingsTest, AWallIsNoThing) {
  floor_.Fill({7.75, 4.0}, {7.9, 10}, core::Occupancy::kOccupied);
  Look(6);
  EXPECT_EQ(costmap_->freed(), nullptr);
}

}  // namespace
}  // namespace treeline::control
