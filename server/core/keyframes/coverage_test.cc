#include "server/core/keyframes/coverage.h"

#include <bit>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/keyframes/scene_axes.h"
#include "server/core/keyframes/testing_keyframe_model.h"
#include "server/core/keyframes/view_support.h"

namespace treeline::keyframes {
namespace {

using geometry::Rigid3;
using geometry::Rotation3;
using geometry::Vec3;
using testing::HasSubstr;

constexpr double kEast = 0;
constexpr double kNorth = std::numbers::pi / 2;
constexpr double kWest = std::numbers::pi;
// Of the cameras that look at the wall (m).
constexpr double kHeight_m = 1.4;
constexpr double kWall_m = 4;

// A camera in a world with z up.
Rigid3 CameraAt(Vec3 position, double heading_rad) {
  const Vec3 forward{std::cos(heading_rad), std::sin(heading_rad), 0};
  const Vec3 right{std::sin(heading_rad), -std::cos(heading_rad), 0};
  return {Rotation3::FromMatrix(
              geometry::Mat3{{right.x, 0, forward.x, right.y, 0, forward.y,
                              right.z, -1, forward.z}}),
          position};
}

void AddPoint(Vec3 position, Vec3 normal, Keyframes& keyframes) {
  KeyframePoint point;
  point.position_in_world = {static_cast<float>(position.x),
                             static_cast<float>(position.y),
                             static_cast<float>(position.z)};
  point.normal_in_world = {static_cast<int8_t>(std::lround(127 * normal.x)),
                           static_cast<int8_t>(std::lround(127 * normal.y)),
                           static_cast<int8_t>(std::lround(127 * normal.z))};
  keyframes.points.push_back(point);
  ++keyframes.records.back().points;
}

void AddCamera(const Rigid3& world_from_camera, Keyframes& keyframes) {
  const auto& [rotation, at] = world_from_camera;
  keyframes.records.push_back(
      {.rotation = {rotation.w, rotation.x, rotation.y, rotation.z},
       .position_in_world = {at.x, at.y, at.z},
       .first_point = static_cast<uint32_t>(keyframes.points.size())});
}

// Fifteen cameras, 1.5 to 2.5 m in front of a wall to the east of them that is
// 4 m wide, 2.4 m high and at x = kWall_m.
Keyframes WallToTheEast() {
  Keyframes keyframes;
  base::Random random(1, 0);
  const auto uniform = [&] { return random.NextBelow(1001) / 1000.0; };
  for (const double away_m : {1.5, 2.0, 2.5}) {
    for (const double y : {-0.5, -0.25, 0.0, 0.25, 0.5}) {
      AddCamera(CameraAt({kWall_m - away_m, y, kHeight_m}, kEast), keyframes);
      for (int i = 0; i < 600; ++i) {
        AddPoint({kWall_m, 4 * uniform() - 2, 2.4 * uniform()}, {-1, 0, 0},
                 keyframes);
      }
    }
  }
  return keyframes;
}

// The same world, its axes turned.
Keyframes Turned(Keyframes keyframes, const Rotation3& turned_from_world) {
  for (KeyframeRecord& record : keyframes.records) {
    const auto [w, x, y, z] = record.rotation;
    const auto [px, py, pz] = record.position_in_world;
    const Rotation3 rotation = turned_from_world * Rotation3{w, x, y, z};
    const Vec3 at = turned_from_world * Vec3{px, py, pz};
    record.rotation = {rotation.w, rotation.x, rotation.y, rotation.z};
    record.position_in_world = {at.x, at.y, at.z};
  }
  for (KeyframePoint& point : keyframes.points) {
    const auto [x, y, z] = point.position_in_world;
    const auto [nx, ny, nz] = point.normal_in_world;
    const Vec3 at = turned_from_world * Vec3{x, y, z};
    const Vec3 normal = turned_from_world * Vec3{static_cast<double>(nx),
                                                 static_cast<double>(ny),
                                                 static_cast<double>(nz)};
    point.position_in_world = {static_cast<float>(at.x),
                               static_cast<float>(at.y),
                               static_cast<float>(at.z)};
    point.normal_in_world = {static_cast<int8_t>(std::lround(normal.x)),
                             static_cast<int8_t>(std::lround(normal.y)),
                             static_cast<int8_t>(std::lround(normal.z))};
  }
  return keyframes;
}

// Keyframes as a model has them.
class Scene {
 public:
  explicit Scene(Keyframes keyframes)
      : keyframes_(std::move(keyframes)),
        model_(*ModelWithKeyframes(keyframes_)),
        map_(*KeyframeMap::Read(*model_)) {}
  const KeyframeMap& map() const { return map_; }

  double Support(Vec3 position, double heading_rad) const {
    const ViewSupport support(map_, {});
    return SupportOf(
        support.PanoramaAt(position),
        DirectionsInPicture(camera::Camera(),
                            CameraAt(position, heading_rad).rotation));
  }

 private:
  Keyframes keyframes_;
  std::unique_ptr<const forest::ModelFile> model_;
  KeyframeMap map_;
};

// Bit of the place at (x, y) and this heading.
bool IsGood(const CoverageMap& coverage, double x, double y,
            double heading_rad) {
  const auto column =
      static_cast<int>((x - coverage.min_x_m) / coverage.cell_m);
  const auto row = static_cast<int>((y - coverage.min_y_m) / coverage.cell_m);
  const auto h =
      static_cast<unsigned>(std::lround(heading_rad / coverage.Heading_rad(1)));
  return ((coverage.places[static_cast<size_t>(row * coverage.columns + column)]
               .good >>
           h) &
          1u) != 0;
}

TEST(ViewSupportTest, TheShareOfThePictureThatTheWallFills) {
  const Scene scene(WallToTheEast());
  // Up to 2.4 m x 525 px / 480 px away the wall is higher than the picture.
  EXPECT_GT(scene.Support({kWall_m - 2.5, 0, kHeight_m}, kEast), 0.9);
  EXPECT_GT(scene.Support({kWall_m - 1.5, 0, kHeight_m}, kEast), 0.8);
  // 8 m away it fills (4 / 8 x 525) x (2.4 / 8 x 525) of 640 x 480 pixels, and
  // at most a cell of the panorama, 7.5 degrees, more on each side.
  const double far = scene.Support({kWall_m - 8, 0, kHeight_m}, kEast);
  EXPECT_GT(far, 0.05);
  EXPECT_LT(far, (262 + 137) / 640.0 * (157 + 137) / 480.0);
}

TEST(ViewSupportTest, NothingWhereTheCameraLooksAway) {
  const Scene scene(WallToTheEast());
  EXPECT_EQ(scene.Support({kWall_m - 2, 0, kHeight_m}, kWest), 0);
  EXPECT_EQ(scene.Support({kWall_m - 4, 0, kHeight_m}, kNorth), 0);
}

TEST(ViewSupportTest, NothingFromBehindTheWall) {
  const Scene scene(WallToTheEast());
  EXPECT_EQ(scene.Support({kWall_m + 2, 0, kHeight_m}, kWest), 0);
}

TEST(ViewSupportTest, LittleWhereTheWallIsSeenAtAnotherAngle) {
  const Scene scene(WallToTheEast());
  const double in_front = scene.Support({kWall_m - 2, 0, kHeight_m}, kEast);
  // 60 degrees to the side, as far from the wall's middle.
  const double aside =
      scene.Support({kWall_m - 2 * std::cos(std::numbers::pi / 3),
                     -2 * std::sin(std::numbers::pi / 3), kHeight_m},
                    std::numbers::pi / 3);
  EXPECT_LT(aside, 0.4 * in_front);
}

TEST(ViewSupportTest, WhatStandsInFrontHidesTheWall) {
  Keyframes keyframes = WallToTheEast();
  const Vec3 place{kWall_m - 2.5, 0, kHeight_m};
  const double free = Scene(keyframes).Support(place, kEast);
  // A board larger than the picture, 0.8 m in front of the place, whose other
  // side cameras at the wall have seen, each of them 64 points.
  for (const double dy : {0.0, 0.08}) {
    for (const double dz : {0.0, 0.08}) {
      AddCamera(CameraAt({kWall_m - 0.2, 0, kHeight_m}, kWest), keyframes);
      for (int i = 0; i < 64; ++i) {
        AddPoint({place.x + 0.8, -0.6 + dy + 0.16 * (i % 8),
                  kHeight_m - 0.6 + dz + 0.16 * (i / 8)},
                 {1, 0, 0}, keyframes);
      }
    }
  }
  EXPECT_LT(Scene(keyframes).Support(place, kEast), 0.1 * free);
}

TEST(CoverageTest, GoodTowardsTheWallAndNotAway) {
  const Scene scene(WallToTheEast());
  const CoverageMap coverage =
      *PredictCoverage(scene.map(), camera::Camera(), {});
  EXPECT_NEAR(coverage.height_m, kHeight_m, 1e-9);
  EXPECT_NEAR(coverage.tilt_rad, 0, 1e-9);
  EXPECT_NEAR(coverage.ground_m, 0, 0.11);
  for (const double away_m : {1.0, 1.5, 2.0, 2.5}) {
    EXPECT_TRUE(IsGood(coverage, kWall_m - away_m, 0, kEast)) << away_m;
    EXPECT_FALSE(IsGood(coverage, kWall_m - away_m, 0, kWest)) << away_m;
    EXPECT_FALSE(IsGood(coverage, kWall_m - away_m, 0, kNorth)) << away_m;
  }
  const CoverageSummary summary = Summarize(coverage);
  // Between the cameras and the wall, and 1 m around the cameras.
  EXPECT_GT(summary.open_m2, 4);
  EXPECT_LT(summary.open_m2, 3.5 * 4);
  EXPECT_GT(summary.good_share, 0.1);
  EXPECT_LT(summary.good_share, 0.5);
  EXPECT_EQ(summary.all_headings_share, 0);
  EXPECT_GT(summary.any_heading_share, 0.5);
}

TEST(CoverageTest, OnlyPlacesNearCamerasOrLookedThroughAreOpen) {
  const Scene scene(WallToTheEast());
  const CoverageMap coverage =
      *PredictCoverage(scene.map(), camera::Camera(), {.places = 400});
  for (int row = 0; row < coverage.rows; ++row) {
    for (int column = 0; column < coverage.columns; ++column) {
      const CoveragePlace& place =
          coverage.places[static_cast<size_t>(row * coverage.columns + column)];
      const double x = coverage.min_x_m + (column + 0.5) * coverage.cell_m;
      const double y = coverage.min_y_m + (row + 0.5) * coverage.cell_m;
      // Beside the sight lines from the outermost cameras to the wall's edges,
      // and further than 1 m from all cameras.
      const bool is_beside =
          std::abs(y) > 1.5 + 2 * coverage.cell_m &&
          std::abs(y) >
              0.5 + 1.5 * (x - (kWall_m - 2.5)) / 1.5 + 2 * coverage.cell_m;
      if (!is_beside) continue;
      EXPECT_FALSE(place.is_open) << x << " " << y;
      EXPECT_EQ(place.good | place.weak, 0u);
    }
  }
}

TEST(CoverageTest, DoesNotDependOnThreads) {
  const Scene scene(WallToTheEast());
  const CoverageMap one =
      *PredictCoverage(scene.map(), camera::Camera(), {.threads = 1});
  const CoverageMap many =
      *PredictCoverage(scene.map(), camera::Camera(), {.threads = 8});
  ASSERT_EQ(one.places.size(), many.places.size());
  for (size_t i = 0; i < one.places.size(); ++i) {
    EXPECT_EQ(one.places[i].good, many.places[i].good);
    EXPECT_EQ(one.places[i].weak, many.places[i].weak);
  }
}

TEST(CoverageTest, AModelWithoutKeyframesSaysHowToGetThem) {
  const Scene scene({});
  const auto coverage = PredictCoverage(scene.map(), camera::Camera(), {});
  EXPECT_EQ(coverage.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(coverage.status().message(), HasSubstr("--method universal"));
}

TEST(CoverageTest, OptionsOutOfRangeAreRefused) {
  const Scene scene(WallToTheEast());
  for (const CoverageOptions& options :
       {CoverageOptions{.headings = 3}, CoverageOptions{.headings = 33},
        CoverageOptions{.places = 1}, CoverageOptions{.max_cell_m = 0}}) {
    EXPECT_EQ(
        PredictCoverage(scene.map(), camera::Camera(), options).status().code(),
        absl::StatusCode::kInvalidArgument);
  }
}

TEST(SceneAxesTest, AWorldWithZUpIsItsOwnPlan) {
  const Scene scene(WallToTheEast());
  EXPECT_EQ(PlanFromWorld(scene.map()), Rotation3());
}

TEST(SceneAxesTest, UpIsFoundInATurnedWorldAndWallsLieAlongThePlan) {
  Keyframes keyframes = WallToTheEast();
  // A floor, by which up is found to a degree.
  AddCamera(CameraAt({1.5, 0, kHeight_m}, kNorth), keyframes);
  for (int i = 0; i < 400; ++i) {
    AddPoint({0.1 * (i % 20), 0.1 * (i / 20), 0}, {0, 0, 1}, keyframes);
  }
  const Rotation3 turned_from_world =
      Rotation3::FromAxisAngle({0.6, -0.4, 0.5});
  const Scene scene(Turned(keyframes, turned_from_world));
  const Rotation3 plan_from_world =
      PlanFromWorld(scene.map()) * turned_from_world;
  // Normals are in steps of 1 / 127.
  EXPECT_GT((plan_from_world * Vec3{0, 0, 1}).z, std::cos(0.02));
  const Vec3 wall = plan_from_world * Vec3{-1, 0, 0};
  EXPECT_GT(std::max(std::abs(wall.x), std::abs(wall.y)), std::cos(0.02));
}

}  // namespace
}  // namespace treeline::keyframes
