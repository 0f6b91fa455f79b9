#include "nav_agent/localization/amcl.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/localization/testing_map.h"

namespace treeline::localization {
namespace {

using testing::HasSubstr;

constexpr PoseCovariance2 kAbout = {0.04, 0, 0, 0, 0.04, 0, 0, 0, 0.02};

// A robot that drives a figure through TestingMap's two rooms, as it is and as
// its odometry, which stretches and turns too much, believes.
class Drive {
 public:
  explicit Drive(uint64_t seed) : random_(seed, 0x0d0) {}

  // Moves on by 0.1 m or so.
  void Step() {
    const geometry::Vec2 way =
        Target() - map_from_base_.map_from_base.translation;
    if (geometry::Norm(way) < 0.3) target_ = (target_ + 1) % 6;
    const double turn_rad = std::clamp(
        geometry::NormalizedAngle_rad(std::atan2(way.y, way.x) -
                                      map_from_base_.map_from_base.yaw_rad),
        -0.15, 0.15);
    const geometry::Rigid2 move = {.translation = {0.1, 0},
                                   .yaw_rad = turn_rad};
    map_from_base_.map_from_base = map_from_base_.map_from_base * move;
    const geometry::Rigid2 felt = {
        .translation = {0.1 * (1.02 + 0.03 * random_.NextGaussian()), 0},
        .yaw_rad = turn_rad * (1.02 + 0.05 * random_.NextGaussian()) +
                   0.002 * random_.NextGaussian()};
    odom_from_base_ = odom_from_base_ * felt;
  }
  void Kidnap(const geometry::Rigid2& map_from_base) {
    map_from_base_.map_from_base = map_from_base;
  }

  const geometry::Rigid2& truth() const { return map_from_base_.map_from_base; }
  const geometry::Rigid2& odometry() const { return odom_from_base_; }
  ScanPoints Points() {
    return *PointsOf(ScanOf(map_, TestingLaser(), truth(), 0.01, random_),
                     TestingLaser(), geometry::Rigid2(), 60);
  }
  const core::OccupancyGrid& map() const { return map_; }

 private:
  geometry::Vec2 Target() const {
    // Cells, through the door at (131, 72) and back.
    constexpr core::CellIndex kTargets[] = {{100, 72}, {165, 72}, {210, 80},
                                            {165, 75}, {100, 70}, {30, 60}};
    return map_.CenterInMap(kTargets[target_]);
  }

  base::Random random_;
  core::OccupancyGrid map_ = TestingMap();
  Particle map_from_base_ = {
      .map_from_base = {TestingMap().CenterInMap({30, 40}), 0.6}};
  geometry::Rigid2 odom_from_base_;
  size_t target_ = 0;
};

double DistanceBetween(const geometry::Rigid2& a, const geometry::Rigid2& b) {
  return geometry::Norm(a.translation - b.translation);
}

TEST(Amcl, TracksARobotThatDrivesAbout) {
  Drive drive(1);
  absl::StatusOr<Amcl> amcl = Amcl::Create(drive.map(), {}, 5);
  ASSERT_TRUE(amcl.ok()) << amcl.status();
  ASSERT_TRUE(amcl->SetPose(drive.truth(), kAbout).ok());
  double worst_m = 0;
  double worst_rad = 0;
  for (int i = 0; i < 400; ++i) {
    drive.Step();
    const auto estimate = *amcl->Update(drive.odometry(), drive.Points());
    ASSERT_TRUE(estimate.has_value());
    if (i < 20) continue;
    worst_m = std::max(worst_m,
                       DistanceBetween(estimate->map_from_base, drive.truth()));
    worst_rad =
        std::max(worst_rad,
                 std::abs(geometry::NormalizedAngle_rad(
                     estimate->map_from_base.yaw_rad - drive.truth().yaw_rad)));
    EXPECT_LE(estimate->particles, 2000);
  }
  // Three cells, of a map whose walls are two cells thick.
  EXPECT_LT(worst_m, 0.15);
  EXPECT_LT(worst_rad, 0.06);
}

TEST(Amcl, FindsItsPlaceFromNothing) {
  // Ends of the map look alike for a while: whoever is sure must be right.
  int found = 0;
  for (uint64_t seed = 0; seed < 4; ++seed) {
    Drive drive(seed);
    absl::StatusOr<Amcl> amcl = Amcl::Create(drive.map(), {}, seed);
    amcl->StartGlobalLocalization();
    std::optional<PlanarEstimate> estimate;
    for (int i = 0; i < 100; ++i) {
      drive.Step();
      estimate = *amcl->Update(drive.odometry(), drive.Points());
    }
    found += DistanceBetween(estimate->map_from_base, drive.truth()) < 0.2 &&
                     estimate->share > 0.9
                 ? 1
                 : 0;
    EXPECT_FALSE(estimate->is_searching) << seed;
    EXPECT_LE(estimate->particles, 2000) << seed;
  }
  EXPECT_EQ(found, 4);
}

TEST(Amcl, IsDeterministic) {
  const auto run = [] {
    Drive drive(3);
    absl::StatusOr<Amcl> amcl = Amcl::Create(drive.map(), {}, 9);
    amcl->StartGlobalLocalization();
    for (int i = 0; i < 30; ++i) {
      drive.Step();
      EXPECT_TRUE(amcl->Update(drive.odometry(), drive.Points()).ok());
    }
    std::vector<geometry::Rigid2> poses;
    for (const Particle& p : amcl->particles())
      poses.push_back(p.map_from_base);
    return poses;
  };
  EXPECT_EQ(run(), run());
}

// Whoever has no time for all of it at once gets the same.
TEST(Amcl, InTwoPartsItComesToTheSame) {
  Drive drive(1);
  Amcl whole = *Amcl::Create(drive.map(), {}, 5);
  Amcl parts = *Amcl::Create(drive.map(), {}, 5);
  whole.StartGlobalLocalization();
  parts.StartGlobalLocalization();
  for (int step = 0; step < 30; ++step) {
    drive.Step();
    const ScanPoints points = drive.Points();
    const auto estimate = *whole.Update(drive.odometry(), points);
    ASSERT_TRUE(parts.Begin(drive.odometry(), points).ok());
    EXPECT_FALSE(parts.is_settled());
    // What nobody asked for is settled by the next one.
    if (step % 3 == 1) continue;
    const auto settled = parts.Settle();
    EXPECT_TRUE(parts.is_settled());
    ASSERT_TRUE(estimate.has_value() && settled.has_value());
    EXPECT_EQ(settled->map_from_base, estimate->map_from_base);
    EXPECT_EQ(settled->share, estimate->share);
    EXPECT_EQ(settled->particles, estimate->particles);
  }
  EXPECT_LT(whole.particles().size(), 30000U);
  EXPECT_EQ(parts.particles().size(), whole.particles().size());
}

TEST(Amcl, LeavesOutBeamsThatNoParticleExplains) {
  Drive drive(2);
  absl::StatusOr<Amcl> amcl = Amcl::Create(drive.map(), {}, 5);
  ASSERT_TRUE(
      amcl->SetPose(drive.truth(), {1e-4, 0, 0, 0, 1e-4, 0, 0, 0, 1e-4}).ok());
  ScanPoints points = drive.Points();
  // Somebody stands close in front of a sixth of the beams.
  for (size_t i = 25; i < 35; ++i) {
    points.x_m[i] = 0.6f;
    points.y_m[i] = 0.03f * (static_cast<float>(i) - 30);
  }
  const auto estimate = *amcl->Update(drive.odometry(), points);
  EXPECT_EQ(estimate->beams_skipped, 10);
  EXPECT_EQ(estimate->beams_used, 50);
  EXPECT_GT(estimate->fit, 0.5);
}

// Where a robot that was carried into the other room believes to be, 12 m of
// driving later; and whether it has looked everywhere.
struct AfterKidnap {
  double away_m = 0;
  bool has_searched = false;
};
AfterKidnap Kidnap(bool inject) {
  Drive drive(4);
  AmclOptions options;
  options.inject = inject;
  absl::StatusOr<Amcl> amcl = Amcl::Create(drive.map(), options, 5);
  EXPECT_TRUE(amcl->SetPose(drive.truth(), kAbout).ok());
  AfterKidnap result;
  for (int i = 0; i < 180; ++i) {
    if (i == 60) drive.Kidnap({drive.map().CenterInMap({210, 60}), 2.5});
    drive.Step();
    const auto estimate = *amcl->Update(drive.odometry(), drive.Points());
    result.has_searched = result.has_searched || estimate->is_searching;
    // Nothing is looked for as long as all is well.
    EXPECT_FALSE(i < 60 && estimate->is_searching) << i;
    result.away_m = DistanceBetween(estimate->map_from_base, drive.truth());
  }
  return result;
}

TEST(Amcl, LooksEverywhereWhenTheFitFalls) {
  const AfterKidnap with = Kidnap(true);
  EXPECT_TRUE(with.has_searched);
  EXPECT_LT(with.away_m, 0.3);
  const AfterKidnap without = Kidnap(false);
  EXPECT_FALSE(without.has_searched);
  EXPECT_GT(without.away_m, 1);
}

TEST(Amcl, StartsWhereItIsTold) {
  const core::OccupancyGrid map = TestingMap();
  AmclOptions options;
  options.max_particles = 20000;
  absl::StatusOr<Amcl> amcl = Amcl::Create(map, options, 1);
  const geometry::Rigid2 pose = {.translation = {1, 2}, .yaw_rad = 3.1};
  // Correlated; 1 % of the sampling error of 20000 particles is 3 sigma.
  const PoseCovariance2 covariance = {0.09, 0.03, 0.01, 0.03, 0.04,
                                      0.0,  0.01, 0.0,  0.02};
  ASSERT_TRUE(amcl->SetPose(pose, covariance).ok());
  PoseCovariance2 found{};
  geometry::Vec2 mean;
  for (const Particle& p : amcl->particles()) {
    mean = mean + (1.0 / 20000) * p.map_from_base.translation;
    const double away[] = {
        p.map_from_base.translation.x - 1, p.map_from_base.translation.y - 2,
        geometry::NormalizedAngle_rad(p.map_from_base.yaw_rad - 3.1)};
    for (size_t a = 0; a < 3; ++a) {
      for (size_t b = 0; b < 3; ++b) {
        found[3 * a + b] += away[a] * away[b] / 20000;
      }
    }
  }
  EXPECT_NEAR(mean.x, 1, 0.007);
  EXPECT_NEAR(mean.y, 2, 0.005);
  for (size_t i = 0; i < 9; ++i) EXPECT_NEAR(found[i], covariance[i], 0.003);
}

TEST(Amcl, RefusesNonsense) {
  const core::OccupancyGrid map = TestingMap();
  absl::StatusOr<Amcl> amcl = Amcl::Create(map, {}, 1);
  EXPECT_FALSE((*amcl->Update({}, {})).has_value());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(amcl->SetPose({{nan, 0}, 0}, kAbout).code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(amcl->SetPose({}, {-1, 0, 0, 0, 1, 0, 0, 0, 1}).code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(amcl->SetPose({}, {1, 5, 0, 5, 1, 0, 0, 0, 1}).code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(amcl->Update({{0, nan}, 0}, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(Amcl::Create(core::OccupancyGrid::Filled(
                               3, 2, 0.1, {}, core::Occupancy::kUnknown),
                           {}, 1)
                  .status()
                  .message(),
              HasSubstr("none of the map's 3 x 2 cells is free"));
  AmclOptions options;
  options.max_particles = 10;
  EXPECT_THAT(Amcl::Create(map, options, 1).status().message(),
              HasSubstr("max_particles is 10; it must be 500.."));
}

TEST(KldSampleCount, IsTheBoundOfFox) {
  EXPECT_EQ(KldSampleCount(0, 0.05, 2.326), 1);
  EXPECT_EQ(KldSampleCount(1, 0.05, 2.326), 1);
  // The 99 % quantile of chi square with 1 and 10 degrees of freedom is 6.635
  // and 23.209; Wilson and Hilferty are within 2 % of them.
  EXPECT_NEAR(KldSampleCount(2, 0.05, 2.3263), 6.635 / 0.1, 2);
  EXPECT_NEAR(KldSampleCount(11, 0.05, 2.3263), 23.209 / 0.1, 2);
}

}  // namespace
}  // namespace treeline::localization
