#include "nav_agent/localization/likelihood_field.h"

#include <cmath>

#include "common/base/random.h"
#include "common/base/testing_vector_targets.h"
#include "gtest/gtest.h"
#include "nav_agent/localization/testing_map.h"

namespace treeline::localization {
namespace {

TEST(LikelihoodField, IsTheEquationOfTheDistance) {
  // One obstacle in a row of cells.
  core::OccupancyGrid map =
      core::OccupancyGrid::Filled(40, 1, 0.1, {}, core::Occupancy::kFree);
  map.Set({10, 0}, core::Occupancy::kOccupied);
  const LikelihoodField field =
      *LikelihoodField::Create(map, {.sigma_hit_m = 0.2, .hit_share = 0.8});
  for (int cell = 0; cell < 40; ++cell) {
    const double distance_m = std::min(1.0, 0.1 * std::abs(cell - 10));
    const double expected =
        std::log(0.8 * std::exp(-distance_m * distance_m / 0.08) + 0.2);
    float log = 0;
    field.LogLikelihoods({.x_m = {0}, .y_m = {0}},
                         {map.CenterInMap({cell, 0}), 0}, {&log, 1});
    EXPECT_NEAR(log, expected, 1e-6) << cell;
  }
}

TEST(LikelihoodField, SumsAreThoseOfSinglePoints) {
  base::WithEachVectorTarget([&] {
    const core::OccupancyGrid map = TestingMap();
    const LikelihoodField field = *LikelihoodField::Create(map, {});
    base::Random random(3, 1);
    // Numbers of points that do and do not fill SIMD registers, and poses that
    // look out of the map.
    for (const size_t count : {0u, 1u, 7u, 8u, 60u, 61u}) {
      ScanPoints points;
      for (size_t i = 0; i < count; ++i) {
        points.x_m.push_back(static_cast<float>(random.NextUniform(-9, 9)));
        points.y_m.push_back(static_cast<float>(random.NextUniform(-9, 9)));
      }
      constexpr size_t kPoses = 50;
      PoseArrays poses;
      poses.Resize(kPoses);
      std::vector<geometry::Rigid2> map_from_base;
      for (size_t i = 0; i < kPoses; ++i) {
        map_from_base.push_back(
            {{random.NextUniform(-5, 12), random.NextUniform(-5, 12)},
             random.NextUniform(-3, 3)});
        poses.Set(i, map_from_base.back());
      }
      std::vector<float> sums(kPoses);
      field.SumLogLikelihoods(points, poses, sums);
      int different = 0;
      for (size_t i = 0; i < kPoses; ++i) {
        std::vector<float> logs(count);
        field.LogLikelihoods(points, map_from_base[i], logs);
        double sum = 0;
        for (const float log : logs) sum += log;
        // A point within rounding of a cell's side may be on either of them.
        different += std::abs(sums[i] - sum) > 1e-3 ? 1 : 0;
      }
      EXPECT_LE(different, 2) << count << " points";
    }
  });
}

TEST(PointsOf, ChoosesEvenlyAmongBeamsThatEnd) {
  const core::RangeSensorInfo info = {.angle_min_rad = -1,
                                      .angle_increment_rad = 0.5,
                                      .beams = 5,
                                      .range_min_m = 0.1,
                                      .range_max_m = 10,
                                      .beam_interval_s = 0,
                                      .scan_interval_s = 0.1};
  core::LaserScan scan;
  scan.ranges_m = {1, core::kNoReturn, 2, core::kInvalidRange, 4};
  const geometry::Rigid2 base_from_laser = {.translation = {0.5, 0},
                                            .yaw_rad = 0};
  const ScanPoints all = *PointsOf(scan, info, base_from_laser, 60);
  ASSERT_EQ(all.size(), 3u);
  EXPECT_FLOAT_EQ(all.x_m[1], 2.5f);
  EXPECT_FLOAT_EQ(all.y_m[1], 0);
  EXPECT_NEAR(all.x_m[2], 0.5 + 4 * std::cos(1.0), 1e-5);
  const ScanPoints one = *PointsOf(scan, info, base_from_laser, 1);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_FLOAT_EQ(one.x_m[0], 2.5f);
  scan.ranges_m.pop_back();
  EXPECT_EQ(PointsOf(scan, info, base_from_laser, 60).status().message(),
            "a scan of 4 beams; the sensor has 5");
}

TEST(PointsOf, WhatIsNearCountsByItsWidthAndNotByItsAngle) {
  // A quarter of the beams end on a box at 0.4 m, the others on a wall around
  // at 5 m: 0.6 m against 23 m.
  const core::RangeSensorInfo info = {.angle_min_rad = -3,
                                      .angle_increment_rad = 0.006,
                                      .beams = 1000,
                                      .range_min_m = 0.1,
                                      .range_max_m = 30,
                                      .beam_interval_s = 0,
                                      .scan_interval_s = 0.1};
  core::LaserScan scan;
  scan.ranges_m.assign(1000, 5);
  for (size_t i = 375; i < 625; ++i) scan.ranges_m[i] = 0.4F;
  const ScanPoints points = *PointsOf(scan, info, {}, 60);
  ASSERT_EQ(points.size(), 60u);
  int near = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    near += std::hypot(points.x_m[i], points.y_m[i]) < 1 ? 1 : 0;
  }
  EXPECT_GE(near, 1);
  EXPECT_LE(near, 3);
}

}  // namespace
}  // namespace treeline::localization
