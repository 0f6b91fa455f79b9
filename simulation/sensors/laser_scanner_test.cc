#include "simulation/sensors/laser_scanner.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "gtest/gtest.h"
#include "simulation/worlds/testing_world.h"

namespace treeline::sensors {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr double kPi = std::numbers::pi;

// A scanner that makes no errors.
LaserScannerOptions Ideal() {
  LaserScannerOptions options;
  options.noise_base_m = 0;
  options.noise_per_m = 0;
  options.range_step_m = 0;
  options.random_loss = 0;
  options.grazing_deg = 0;
  options.glass_return = 0;
  return options;
}

geometry::Rigid3 At(double x_m, double y_m, double yaw_rad, double z_m = 1.2) {
  return {geometry::Rotation3::FromAxisAngle({0, 0, yaw_rad}), {x_m, y_m, z_m}};
}

double Angle_rad(const LaserScannerOptions& options, size_t beam) {
  return options.angle_min_rad +
         static_cast<double>(beam) * options.angle_increment_rad;
}

// From a point inside to the walls of TestingWorld (4 x 3 m).
double ToWalls_m(double x_m, double y_m, double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  const double along_x = c > 0 ? (4 - x_m) / c : (c < 0 ? -x_m / c : kInfinity);
  const double along_y = s > 0 ? (3 - y_m) / s : (s < 0 ? -y_m / s : kInfinity);
  return std::min(along_x, along_y);
}

worlds::Finish Grey(worlds::WorldBuilder& builder) {
  return {.texture = builder.AddTexture([] {
    return worlds::Canvas(8, 8, {0.5f, 0.5f, 0.5f});
  })};
}

// A wall of 60 m across x = `x_m`, and nothing else.
worlds::World LongWall(float x_m) {
  worlds::WorldBuilder builder;
  builder.AddPanel({}, {x_m, 30, 3}, {0, -60, 0}, {0, 0, -3}, Grey(builder));
  return builder.Build("wall", {}, {}, 1);
}

LaserReturns ScanOnce(const worlds::World& world,
                      const LaserScannerOptions& options,
                      const geometry::Rigid3& world_from_laser,
                      uint64_t scan = 0) {
  const renderer::RayCaster caster = *renderer::RayCaster::Create(world);
  return LaserScanner::Create(world, options, 7)
      ->Scan(caster.At({}), world_from_laser, world_from_laser, scan);
}

TEST(LaserScanner, MeasuresARoomWithinAMillimetre) {
  // Above the box, so that there is nothing but walls.
  const LaserScannerOptions options = Ideal();
  const LaserReturns returns =
      ScanOnce(worlds::TestingWorld(), options, At(1.7, 1.1, 0.3));
  ASSERT_EQ(returns.ranges_m.size(), 1081u);
  for (size_t i = 0; i < returns.ranges_m.size(); ++i) {
    EXPECT_NEAR(returns.ranges_m[i],
                ToWalls_m(1.7, 1.1, 0.3 + Angle_rad(options, i)), 1e-3)
        << i;
  }
}

TEST(LaserScanner, MeasuresASlantedWallWithATiltedScanner) {
  // The plane x + y / 2 = 5, upright, wide and high.
  worlds::WorldBuilder builder;
  builder.AddPanel({}, {-5, 20, 20}, {20, -40, 0}, {0, 0, -40}, Grey(builder));
  const worlds::World world = builder.Build("slant", {}, {}, 1);
  const LaserScannerOptions options = Ideal();
  const geometry::Rotation3 rotation =
      geometry::Rotation3::FromAxisAngle({0, 0, 0.2}) *
      geometry::Rotation3::FromAxisAngle({0, 0.15, 0}) *
      geometry::Rotation3::FromAxisAngle({-0.1, 0, 0});
  const geometry::Vec3 origin = {0.5, -0.7, 1.1};
  const LaserReturns returns = ScanOnce(world, options, {rotation, origin});
  const geometry::Vec3 normal = {1, 0.5, 0};
  int seen = 0;
  for (size_t i = 0; i < returns.ranges_m.size(); ++i) {
    const double angle_rad = Angle_rad(options, i);
    const geometry::Vec3 way =
        rotation * geometry::Vec3{std::cos(angle_rad), std::sin(angle_rad), 0};
    const double range_m = (5 - Dot(normal, origin)) / Dot(normal, way);
    const geometry::Vec3 point = origin + range_m * way;
    if (range_m < 0 || std::abs(point.y) > 19 || std::abs(point.z) > 19) {
      continue;
    }
    ++seen;
    EXPECT_NEAR(returns.ranges_m[i], range_m, 1e-3) << i;
  }
  EXPECT_GT(seen, 500);
}

TEST(LaserScanner, MeasuresAPillarAsAPolygon) {
  worlds::WorldBuilder builder;
  const worlds::WorldBuilder::ProfilePoint profile[] = {{0.25f, 0}, {0.25f, 2}};
  constexpr int kSides = 48;
  builder.AddTurned({}, {3, 0.4f, 0}, profile, kSides, Grey(builder));
  const worlds::World world = builder.Build("pillar", {}, {}, 1);
  const LaserScannerOptions options = Ideal();
  const LaserReturns returns = ScanOnce(world, options, At(0, 0, 0));
  // A polygon's faces lie within radius * (1 - cos(pi / sides)) of the circle:
  // 0.54 mm, along a beam that meets the circle at 30 degrees or more 1.1 mm.
  int seen = 0;
  for (size_t i = 0; i < returns.ranges_m.size(); ++i) {
    const double angle_rad = Angle_rad(options, i);
    const double along_m = 3 * std::cos(angle_rad) + 0.4 * std::sin(angle_rad);
    const double aside_m = 3 * std::sin(angle_rad) - 0.4 * std::cos(angle_rad);
    if (along_m < 0 || std::abs(aside_m) > 0.26) {
      EXPECT_EQ(returns.ranges_m[i], kInfinity) << i;
    } else if (std::abs(aside_m) < 0.25 * std::cos(kPi / 6)) {
      ++seen;
      EXPECT_NEAR(returns.ranges_m[i],
                  along_m - std::sqrt(0.0625 - aside_m * aside_m), 1.2e-3)
          << i;
    }
  }
  EXPECT_GT(seen, 25);
}

TEST(LaserScanner, SeesBodiesWhereTheyStand) {
  worlds::World world = worlds::TestingWorld();
  worlds::WorldBuilder builder;
  builder.BeginBody();
  builder.AddBox({}, {-0.2f, -0.1f, 0}, {0.2f, 0.1f, 1.5f},
                 {.sides = Grey(builder)});
  builder.EndBody("post", 0.23f, 1.5f, std::nullopt);
  world.bodies = builder.Build("", {}, {}, 1).bodies;
  const renderer::RayCaster caster = *renderer::RayCaster::Create(world);
  const LaserScanner scanner = *LaserScanner::Create(world, Ideal(), 1);
  const geometry::Rigid3 pose = At(2, 1.5, 0);
  constexpr size_t kAhead = 540;
  const auto range_m = [&](const worlds::BodyInstance& instance) {
    return scanner.Scan(caster.At({instance}), pose, pose, 0).ranges_m[kAhead];
  };
  EXPECT_NEAR(range_m({.world_from_body = {.origin = {3, 1.5f, 0}}}), 0.8,
              1e-3);
  EXPECT_NEAR(range_m({.world_from_body = {.origin = {3, 1.5f, 0},
                                           .yaw_rad = float(kPi) / 2}}),
              0.9, 1e-3);
  EXPECT_NEAR(range_m({.world_from_body = {.origin = {3, 2.5f, 0}}}), 2, 1e-3);
}

TEST(LaserScanner, MotionSkewsAScan) {
  const worlds::World world = worlds::TestingWorld();
  const renderer::RayCaster caster = *renderer::RayCaster::Create(world);
  const LaserScannerOptions options = Ideal();
  const LaserScanner scanner = *LaserScanner::Create(world, options, 1);
  const LaserReturns returns =
      scanner.Scan(caster.At({}), At(1.5, 1.2, -0.1), At(1.8, 1.4, 0.2), 0);
  for (size_t i = 0; i < returns.ranges_m.size(); ++i) {
    const double t = static_cast<double>(i) / 1080;
    EXPECT_NEAR(returns.ranges_m[i],
                ToWalls_m(1.5 + 0.3 * t, 1.2 + 0.2 * t,
                          -0.1 + 0.3 * t + Angle_rad(options, i)),
                1e-3)
        << i;
  }
}

// Beams of many scans at a wall straight ahead.
struct Statistics {
  double mean_m = 0;
  double sigma_m = 0;
  int lost = 0;
  int measured = 0;
};

Statistics StatisticsOf(const worlds::World& world, LaserScannerOptions options,
                        double centre_m) {
  // All beams within a degree of straight ahead: to a wall at d, ranges are
  // d / cos(angle).
  options.beams = 1001;
  options.angle_increment_rad = 2 * kPi / 180 / 1000;
  options.angle_min_rad = -kPi / 180;
  const renderer::RayCaster caster = *renderer::RayCaster::Create(world);
  const renderer::WorldSnapshot snapshot = caster.At({});
  const LaserScanner scanner = *LaserScanner::Create(world, options, 11);
  Statistics result;
  double sum = 0;
  double squares = 0;
  for (uint64_t scan = 0; scan < 40; ++scan) {
    const LaserReturns returns =
        scanner.Scan(snapshot, At(0, 0, 0), At(0, 0, 0), scan);
    for (size_t i = 0; i < returns.ranges_m.size(); ++i) {
      if (!std::isfinite(returns.ranges_m[i])) {
        ++result.lost;
        continue;
      }
      const double error =
          returns.ranges_m[i] - centre_m / std::cos(Angle_rad(options, i));
      sum += error;
      squares += error * error;
      ++result.measured;
    }
  }
  result.mean_m = sum / result.measured;
  result.sigma_m =
      std::sqrt(squares / result.measured - result.mean_m * result.mean_m);
  return result;
}

TEST(LaserScanner, NoiseAndLossesAreAsTheModelSays) {
  for (const double range_m : {2.0, 20.0}) {
    LaserScannerOptions options;
    options.random_loss = 0.02;
    const Statistics measured =
        StatisticsOf(LongWall(static_cast<float>(range_m)), options, range_m);
    // Rounding to a millimetre adds a twelfth of its square.
    const double sigma_m =
        std::hypot(0.006 + 0.0004 * range_m, 0.001 / std::sqrt(12));
    // Five standard errors of each.
    const double count = measured.measured;
    EXPECT_NEAR(measured.mean_m, 0, 5 * sigma_m / std::sqrt(count));
    EXPECT_NEAR(measured.sigma_m, sigma_m, 5 * sigma_m / std::sqrt(2 * count));
    const double beams = 1001 * 40;
    EXPECT_NEAR(measured.lost, 0.02 * beams, 5 * std::sqrt(0.02 * beams));
  }
}

TEST(LaserScanner, RangesAreInWholeSteps) {
  const LaserReturns returns =
      ScanOnce(worlds::TestingWorld(), LaserScannerOptions(), At(1.7, 1.1, 0));
  for (const float range_m : returns.ranges_m) {
    if (!std::isfinite(range_m)) continue;
    EXPECT_NEAR(1000 * range_m, std::round(1000 * range_m), 1e-3);
  }
}

TEST(LaserScanner, TooFarIsNothingAndTooNearIsMinusInfinity) {
  LaserScannerOptions options = Ideal();
  options.range_max_m = 2.5;
  options.range_min_m = 1;
  const LaserReturns returns =
      ScanOnce(worlds::TestingWorld(), options, At(1, 0.5, 0));
  int far = 0;
  int near = 0;
  for (size_t i = 0; i < returns.ranges_m.size(); ++i) {
    const double range_m = ToWalls_m(1, 0.5, Angle_rad(options, i));
    if (range_m > 2.5 + 1e-4) {
      EXPECT_EQ(returns.ranges_m[i], kInfinity) << i;
      EXPECT_EQ(returns.intensities[i], 0) << i;
      ++far;
    } else if (range_m < 1 - 1e-4) {
      EXPECT_EQ(returns.ranges_m[i], -kInfinity) << i;
      ++near;
    }
  }
  EXPECT_GT(far, 50);
  EXPECT_GT(near, 50);
}

TEST(LaserScanner, GrazedSurfacesAreLost) {
  LaserScannerOptions options = Ideal();
  options.grazing_deg = 10.1;
  const LaserReturns returns = ScanOnce(LongWall(1), options, At(0, 0, 0));
  for (size_t i = 0; i < returns.ranges_m.size(); ++i) {
    const double angle_deg = std::abs(Angle_rad(options, i)) * 180 / kPi;
    EXPECT_EQ(std::isfinite(returns.ranges_m[i]), angle_deg < 79.9)
        << angle_deg;
  }
}

TEST(LaserScanner, GlassReturnsSomeBeamsThatMeetItStraight) {
  worlds::World world = LongWall(5);
  worlds::Surface pane;
  pane.corners = {
      worlds::Float3{3, 30, 3}, {3, -30, 3}, {3, -30, 0}, {3, 30, 0}};
  pane.kind = worlds::SurfaceKind::kGlass;
  world.surfaces.push_back(pane);
  LaserScannerOptions options = Ideal();
  options.glass_return = 0.7;
  options.glass_angle_deg = 12;
  const renderer::RayCaster caster = *renderer::RayCaster::Create(world);
  const renderer::WorldSnapshot snapshot = caster.At({});
  const LaserScanner scanner = *LaserScanner::Create(world, options, 3);
  double expected = 0;
  double variance = 0;
  int from_glass = 0;
  for (uint64_t scan = 0; scan < 100; ++scan) {
    const LaserReturns returns =
        scanner.Scan(snapshot, At(0, 0, 0), At(0, 0, 0), scan);
    for (size_t i = 0; i < returns.ranges_m.size(); ++i) {
      const double angle_rad = Angle_rad(options, i);
      if (std::abs(angle_rad) > 1.2) continue;
      const double angle_deg = std::abs(angle_rad) * 180 / kPi;
      const double share = 0.7 * std::max(1 - angle_deg / 12, 0.0);
      expected += share;
      variance += share * (1 - share);
      const double pane_m = 3 / std::cos(angle_rad);
      const double wall_m = 5 / std::cos(angle_rad);
      const double range_m = returns.ranges_m[i];
      const bool is_glass = std::abs(range_m - pane_m) < 1e-3;
      if (is_glass) {
        ++from_glass;
        EXPECT_LT(angle_deg, 12.01);
      } else {
        EXPECT_NEAR(range_m, wall_m, 1e-3) << i;
      }
    }
  }
  EXPECT_NEAR(from_glass, expected, 5 * std::sqrt(variance));
}

TEST(LaserScanner, GlassBehindAWallIsNotSeen) {
  worlds::World world = LongWall(2);
  worlds::Surface pane;
  pane.corners = {
      worlds::Float3{3, 30, 3}, {3, -30, 3}, {3, -30, 0}, {3, 30, 0}};
  pane.kind = worlds::SurfaceKind::kGlass;
  world.surfaces.push_back(pane);
  LaserScannerOptions options = Ideal();
  options.glass_return = 1;
  EXPECT_NEAR(ScanOnce(world, options, At(0, 0, 0)).ranges_m[540], 2, 1e-3);
}

TEST(LaserScanner, FarSlantedAndDarkSurfacesReturnLess) {
  const LaserScannerOptions options = Ideal();
  const LaserReturns near = ScanOnce(LongWall(1), options, At(0, 0, 0));
  const LaserReturns far = ScanOnce(LongWall(8), options, At(0, 0, 0));
  EXPECT_GT(near.intensities[540], 2 * far.intensities[540]);
  EXPECT_GT(near.intensities[540], 1.4 * near.intensities[540 + 180]);
  EXPECT_GT(far.intensities[540], 0);
}

TEST(LaserScanner, SeedAndScanDecideTheNoise) {
  const worlds::World world = worlds::TestingWorld();
  const LaserScannerOptions options;
  const LaserReturns first = ScanOnce(world, options, At(1.7, 1.1, 0), 5);
  EXPECT_EQ(first.ranges_m,
            ScanOnce(world, options, At(1.7, 1.1, 0), 5).ranges_m);
  EXPECT_NE(first.ranges_m,
            ScanOnce(world, options, At(1.7, 1.1, 0), 6).ranges_m);
  const renderer::RayCaster caster = *renderer::RayCaster::Create(world);
  const LaserScanner other = *LaserScanner::Create(world, options, 8);
  EXPECT_NE(
      first.ranges_m,
      other.Scan(caster.At({}), At(1.7, 1.1, 0), At(1.7, 1.1, 0), 5).ranges_m);
}

TEST(LaserScannerOptions, AreChecked) {
  const auto is_refused = [](auto change) {
    LaserScannerOptions options;
    change(options);
    return LaserScanner::Create(worlds::TestingWorld(), options, 0)
               .status()
               .code() == absl::StatusCode::kInvalidArgument;
  };
  EXPECT_TRUE(is_refused([](auto& o) { o.beams = 1; }));
  EXPECT_TRUE(is_refused([](auto& o) { o.range_max_m = 0.05; }));
  EXPECT_TRUE(is_refused([](auto& o) { o.noise_base_m = -1; }));
  EXPECT_TRUE(is_refused([](auto& o) { o.random_loss = 1.5; }));
  EXPECT_TRUE(is_refused([](auto& o) { o.glass_angle_deg = NAN; }));
  EXPECT_FALSE(is_refused([](auto&) {}));
}

}  // namespace
}  // namespace treeline::sensors
