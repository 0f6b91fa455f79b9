#include "nav_agent/localization/place_hypotheses.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/localization/amcl.h"
#include "nav_agent/localization/testing_map.h"

namespace treeline::localization {
namespace {

// From the corridor below to the one above, m.
constexpr double kBetween_m = 6;
constexpr double kResolution_m = 0.1;

// Two corridors of 24 by 2 m without a way from one to the other, with niches
// at the same places; with_alcove: the lower one has one more.
core::OccupancyGrid Corridors(bool with_alcove) {
  core::OccupancyGrid map = core::OccupancyGrid::Filled(
      260, 120, kResolution_m, {}, core::Occupancy::kOccupied);
  const auto clear = [&map](int x0, int y0, int x1, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) map.Set({x, y}, core::Occupancy::kFree);
    }
  };
  for (const int y : {20, 20 + static_cast<int>(kBetween_m / kResolution_m)}) {
    clear(10, y, 250, y + 20);
    clear(30, y + 20, 40, y + 26);
    clear(66, y - 8, 78, y);
    clear(95, y + 20, 113, y + 28);
    clear(210, y - 6, 218, y);
  }
  if (with_alcove) clear(150, 5, 180, 20);
  // Walls, not rock: a beam that ends within rock would fit.
  core::OccupancyGrid walls = map;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      bool is_near_free = false;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          is_near_free |=
              map.AtOrUnknown({x + dx, y + dy}) == core::Occupancy::kFree;
        }
      }
      if (!is_near_free) walls.Set({x, y}, core::Occupancy::kUnknown);
    }
  }
  return walls;
}

core::RangeSensorInfo ShortLaser() {
  core::RangeSensorInfo laser = TestingLaser();
  laser.range_max_m = 5;
  return laser;
}

// Along the lower corridor, or the one above, and back, with odometry that
// stretches.
class CorridorDrive {
 public:
  explicit CorridorDrive(const core::OccupancyGrid& map, bool is_above = false)
      : map_(map) {
    if (is_above) truth_.translation.y += kBetween_m;
  }

  void Step() {
    const bool is_at_end = (truth_.translation.x > 22.5 && IsForth()) ||
                           (truth_.translation.x < 3 && !IsForth());
    is_turning_ = is_at_end || (is_turning_ && std::abs(ToGo_rad()) > 0.1);
    if (is_at_end) target_rad_ = IsForth() ? std::numbers::pi : 0;
    const geometry::Rigid2 move =
        is_turning_
            ? geometry::Rigid2{.translation = {0.01, 0}, .yaw_rad = 0.15}
            : geometry::Rigid2{.translation = {0.1, 0},
                               .yaw_rad = std::clamp(ToGo_rad(), -0.1, 0.1)};
    truth_ = truth_ * move;
    odometry_ =
        odometry_ * geometry::Rigid2{.translation = 1.01 * move.translation,
                                     .yaw_rad = 1.01 * move.yaw_rad +
                                                0.002 * random_.NextGaussian()};
  }
  const geometry::Rigid2& truth() const { return truth_; }
  const geometry::Rigid2& odometry() const { return odometry_; }
  ScanPoints Points() {
    return *PointsOf(ScanOf(map_, ShortLaser(), truth_, 0.01, random_),
                     ShortLaser(), geometry::Rigid2(), kScanBeams);
  }

 private:
  bool IsForth() const { return target_rad_ == 0; }
  double ToGo_rad() const {
    return geometry::NormalizedAngle_rad(target_rad_ - truth_.yaw_rad);
  }

  const core::OccupancyGrid& map_;
  base::Random random_{7, 0xd0};
  geometry::Rigid2 truth_ = {.translation = {2, 3.05}, .yaw_rad = 0};
  geometry::Rigid2 odometry_;
  double target_rad_ = 0;
  bool is_turning_ = false;
};

double ErrorOf(const PlanarEstimate& estimate, const geometry::Rigid2& truth) {
  return geometry::Norm(estimate.map_from_base.translation - truth.translation);
}

struct Course {
  bool was_sure_before_alcove = false;
  bool was_sure_and_wrong = false;
  // Believed in the other corridor once.
  bool was_wrong = false;
  double greatest_share_before_alcove = 0;
  bool named_twin = false;
  std::optional<double> sure_after_m;
  PlanarEstimate last;
};

Course Drive(bool with_alcove, uint64_t seed, int steps,
             bool is_above = false) {
  const core::OccupancyGrid map = Corridors(with_alcove);
  CorridorDrive drive(map, is_above);
  Amcl amcl = *Amcl::Create(map, {}, seed);
  amcl.StartGlobalLocalization();
  Course course;
  for (int i = 0; i < steps; ++i) {
    drive.Step();
    // As scans come more often than the robot gets on.
    const ScanPoints points = drive.Points();
    for (int again = 0; again < 3; ++again) {
      course.last = **amcl.Update(drive.odometry(), points);
    }
    const PlanarEstimate& estimate = course.last;
    const double error_m = ErrorOf(estimate, drive.truth());
    const bool is_sure = !estimate.in_doubt;
    course.was_wrong |= !estimate.is_searching && error_m > 4;
    course.was_sure_and_wrong |= is_sure && error_m > 0.5;
    // The laser's range before it begins.
    if (i < 75) {
      course.was_sure_before_alcove |= is_sure;
      course.greatest_share_before_alcove =
          std::max(course.greatest_share_before_alcove, estimate.place_share);
    }
    for (const PossiblePlace& other : estimate.other_places) {
      const geometry::Vec2 twin =
          drive.truth().translation +
          geometry::Vec2{0, is_above ? -kBetween_m : kBetween_m};
      course.named_twin |=
          geometry::Norm(other.pose.map_from_base.translation - twin) < 0.5 &&
          other.share > 0.3;
    }
    if (is_sure && !course.sure_after_m.has_value()) {
      course.sure_after_m = 0.1 * i;
    }
  }
  return course;
}

TEST(PlaceHypotheses, DoubtEndsWhereAlikeCorridorsDiffer) {
  bool was_wrong = false;
  bool named_twin = false;
  for (uint64_t seed = 0; seed < 3; ++seed) {
    // Once in the corridor that has no alcove: what the other one has is
    // missed.
    const Course course = Drive(true, seed, 400, seed == 1);
    EXPECT_FALSE(course.was_sure_before_alcove) << seed;
    EXPECT_LE(course.greatest_share_before_alcove, 0.6) << seed;
    EXPECT_FALSE(course.was_sure_and_wrong) << seed;
    EXPECT_TRUE(course.sure_after_m.has_value()) << seed;
    EXPECT_FALSE(course.last.in_doubt) << seed;
    EXPECT_EQ(course.last.place_share, 1) << seed;
    EXPECT_TRUE(course.last.other_places.empty()) << seed;
    was_wrong = was_wrong || course.was_wrong;
    named_twin = named_twin || course.named_twin;
  }
  EXPECT_TRUE(named_twin);
  // Else nothing was corrected.
  EXPECT_TRUE(was_wrong);
}

TEST(PlaceHypotheses, NobodyIsSureWhereNothingDiffers) {
  for (uint64_t seed = 0; seed < 2; ++seed) {
    const Course course = Drive(false, seed, 400);
    EXPECT_FALSE(course.sure_after_m.has_value()) << seed;
    EXPECT_TRUE(course.last.in_doubt) << seed;
    // One half each, but for the noise of scans; 0 while the particles are at
    // both.
    EXPECT_LT(course.last.place_share, 0.6) << seed;
  }
}

TEST(PlaceHypotheses, IsDeterministic) {
  const Course one = Drive(false, 3, 60);
  const Course other = Drive(false, 3, 60);
  EXPECT_EQ(one.last.place_share, other.last.place_share);
  ASSERT_EQ(one.last.other_places.size(), other.last.other_places.size());
  for (size_t i = 0; i < one.last.other_places.size(); ++i) {
    EXPECT_EQ(one.last.other_places[i].pose, other.last.other_places[i].pose);
  }
}

TEST(PlaceHypotheses, WhoeverIsToldIsNotInDoubt) {
  const core::OccupancyGrid map = Corridors(false);
  CorridorDrive drive(map);
  Amcl amcl = *Amcl::Create(map, {}, 1);
  amcl.StartGlobalLocalization();
  EXPECT_TRUE((*amcl.Update(drive.odometry(), drive.Points()))->in_doubt);
  ASSERT_TRUE(
      amcl.SetPose(drive.truth(), {0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01}).ok());
  for (int i = 0; i < 40; ++i) {
    drive.Step();
    const PlanarEstimate estimate =
        **amcl.Update(drive.odometry(), drive.Points());
    EXPECT_FALSE(estimate.in_doubt);
    EXPECT_EQ(estimate.place_share, 1);
  }
}

TEST(PlaceHypotheses, CanBeSwitchedOff) {
  const core::OccupancyGrid map = Corridors(false);
  CorridorDrive drive(map);
  AmclOptions options;
  options.doubt = false;
  Amcl amcl = *Amcl::Create(map, options, 1);
  amcl.StartGlobalLocalization();
  EXPECT_FALSE((*amcl.Update(drive.odometry(), drive.Points()))->in_doubt);
}

// Where a scan fits everywhere, memory is bounded and nobody is sure.
TEST(PlaceHypotheses, FollowsOnlySoManyPlaces) {
  core::OccupancyGrid map =
      core::OccupancyGrid::Filled(200, 200, 0.2, {}, core::Occupancy::kFree);
  std::vector<FreePlace> free;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      free.push_back({map.CenterInMap({x, y}), {}});
    }
  }
  const LikelihoodField field = *LikelihoodField::Create(map, {});
  const auto places = std::make_shared<const std::vector<FreePlace>>(
      OnePlaceOfEachSquare(free, kSearchGrid_m));
  ScanPoints points;
  for (int i = 0; i < 60; ++i) {
    points.x_m.push_back(static_cast<float>(2 * std::cos(0.1 * i)));
    points.y_m.push_back(static_cast<float>(2 * std::sin(0.1 * i)));
  }
  PlaceHypothesesOptions options;
  options.candidates = 50;
  options.slice = 100000;
  PlaceHypotheses hypotheses(options);
  hypotheses.BeginDoubt();
  for (int i = 0; i < 100; ++i) {
    const geometry::Rigid2 odom_from_base = {.translation = {0.1 * i, 0},
                                             .yaw_rad = 0};
    hypotheses.AddScan(odom_from_base, points);
    hypotheses.Step(
        {.field = &field, .places = places, .levels = nullptr}, odom_from_base,
        core::LevelPose{
            .map_from_base = {.translation = {10 + 0.1 * i, 20}, .yaw_rad = 0},
            .place = {}});
    EXPECT_LE(hypotheses.size(), 101u);
  }
  EXPECT_TRUE(hypotheses.in_doubt());
  EXPECT_GT(hypotheses.size(), 10u);
  EXPECT_EQ(hypotheses.share(), 0);
}

TEST(PlaceHypotheses, PonderingBetweenScansGathersTheParticlesAndEndsTheDoubt) {
  const core::OccupancyGrid map = Corridors(true);
  CorridorDrive drive(map);
  // So many particles are wanted that they are never few by themselves.
  AmclOptions options;
  options.kld_error = 0.003;
  Amcl amcl = *Amcl::Create(map, options, 1);
  EXPECT_FALSE(amcl.Ponder().has_value());
  amcl.StartGlobalLocalization();
  // Nothing is known of the wheels yet.
  EXPECT_FALSE(amcl.Ponder().has_value());
  PlanarEstimate last;
  int pondered = 0;
  std::optional<int> gathered_after;
  std::optional<int> sure_after;
  for (int i = 0; i < 400 && !sure_after.has_value(); ++i) {
    drive.Step();
    ASSERT_TRUE(amcl.Begin(drive.odometry(), drive.Points()).ok());
    // Half of an update says nothing.
    EXPECT_FALSE(amcl.Ponder().has_value());
    last = *amcl.Settle();
    for (int k = 0; k < 4 && last.in_doubt; ++k, ++pondered) {
      const std::optional<PlanarEstimate> estimate = amcl.Ponder();
      ASSERT_TRUE(estimate.has_value());
      last = *estimate;
    }
    if (!last.is_searching && !gathered_after.has_value()) gathered_after = i;
    if (!last.in_doubt) sure_after = i;
  }
  EXPECT_GT(pondered, 100);
  // Five viewpoints, half a metre apart.
  ASSERT_TRUE(gathered_after.has_value());
  EXPECT_GE(*gathered_after, 20);
  EXPECT_LT(ErrorOf(last, drive.truth()), 0.5);
  // The robot begins at 2 m, the alcove at 15 m.
  ASSERT_TRUE(sure_after.has_value());
  EXPECT_GT(*sure_after, 75);
}

// Of what a robot that believes nothing follows.
TEST(PlaceHypotheses, WithoutABeliefTheBestPlaceIsKnownAndTheDoubtGoesOn) {
  const core::OccupancyGrid map = Corridors(true);
  CorridorDrive drive(map);
  // Before the alcove.
  for (int i = 0; i < 80; ++i) drive.Step();
  std::vector<FreePlace> free;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      if (map.At({x, y}) != core::Occupancy::kFree) continue;
      free.push_back({map.CenterInMap({x, y}), {}});
    }
  }
  const LikelihoodField field = *LikelihoodField::Create(map, {});
  const PlaceMap place_map = {
      .field = &field,
      .places = std::make_shared<const std::vector<FreePlace>>(
          OnePlaceOfEachSquare(free, kSearchGrid_m)),
      .levels = nullptr};
  PlaceHypotheses hypotheses;
  EXPECT_FALSE(hypotheses.Best(drive.odometry()).has_value());
  hypotheses.BeginDoubt();
  for (int i = 0; i < 120; ++i) {
    drive.Step();
    hypotheses.AddScan(drive.odometry(), drive.Points());
    // One viewpoint is not enough.
    if (i == 0) {
      for (int k = 0; k < 200; ++k) {
        hypotheses.Step(place_map, drive.odometry(), std::nullopt);
      }
      EXPECT_FALSE(hypotheses.Best(drive.odometry()).has_value());
    }
    for (int k = 0; k < 3; ++k) {
      hypotheses.Step(place_map, drive.odometry(), std::nullopt);
    }
  }
  const std::optional<core::LevelPose> best = hypotheses.Best(drive.odometry());
  ASSERT_TRUE(best.has_value());
  EXPECT_LT(geometry::Norm(best->map_from_base.translation -
                           drive.truth().translation),
            0.5);
  EXPECT_TRUE(hypotheses.in_doubt());
  // Once that is believed, the doubt ends.
  for (int k = 0; k < 20; ++k) {
    hypotheses.Step(place_map, drive.odometry(), best);
  }
  EXPECT_FALSE(hypotheses.in_doubt());
}

TEST(GlobalPoseSearch, HandsOverEachPlaceThatFitsOnce) {
  const core::OccupancyGrid map = Corridors(false);
  CorridorDrive drive(map);
  for (int i = 0; i < 60; ++i) drive.Step();
  std::vector<FreePlace> free;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      if (map.At({x, y}) != core::Occupancy::kFree) continue;
      free.push_back({map.CenterInMap({x, y}), {}});
    }
  }
  const LikelihoodField field = *LikelihoodField::Create(map, {});
  GlobalPoseSearch search(std::make_shared<const std::vector<FreePlace>>(
                              OnePlaceOfEachSquare(free, kSearchGrid_m)),
                          drive.Points(), std::nullopt);
  while (!search.Step(field)) {
  }
  const std::vector<core::LevelPose> best = search.Best();
  ASSERT_EQ(best.size(), kSearchCandidates);
  for (size_t i = 0; i < best.size(); ++i) {
    for (size_t k = 0; k < i; ++k) {
      EXPECT_FALSE(AreNear(best[i], best[k], kOtherPlace_m, kOtherPlace_rad));
    }
  }
  for (const double above_m : {0.0, kBetween_m}) {
    const geometry::Vec2 place =
        drive.truth().translation + geometry::Vec2{0, above_m};
    EXPECT_TRUE(std::ranges::any_of(best, [&](const core::LevelPose& pose) {
      return geometry::Norm(pose.map_from_base.translation - place) < 0.5;
    }));
  }
}

}  // namespace
}  // namespace treeline::localization
