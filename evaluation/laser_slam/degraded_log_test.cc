#include "evaluation/laser_slam/degraded_log.h"

#include <cmath>
#include <string>

#include "evaluation/laser_slam/synthetic_office.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::laser_slam {
namespace {

using ::testing::HasSubstr;

const OfficeDrive& Drive() {
  static const OfficeDrive* const drive =
      new OfficeDrive(DriveThroughOffice({.seed = 3, .beams = 19}));
  return *drive;
}

double EndError_m(const recording::LaserLog& log) {
  return geometry::Norm(log.scans.back().odom_from_base.translation -
                        Drive().map_from_base.back().translation);
}

TEST(DegradedLog, IsAsItWasWithoutDegradation) {
  const auto same = Degraded(Drive().log, {});
  ASSERT_TRUE(same.ok()) << same.status();
  EXPECT_EQ(same->scans.size(), Drive().log.scans.size());
  EXPECT_EQ(same->scans.back().ranges_m, Drive().log.scans.back().ranges_m);
  EXPECT_LT(EndError_m(*same), 1e-6);
}

TEST(DegradedLog, LosesScansAndBeams) {
  const size_t scans = Drive().log.scans.size();
  const auto third = Degraded(Drive().log, {.every_scan = 3, .every_beam = 2});
  ASSERT_TRUE(third.ok());
  EXPECT_EQ(third->scans.size(), (scans + 2) / 3);
  EXPECT_EQ(third->laser.beams, 10);
  EXPECT_EQ(third->scans[1].stamp, Drive().log.scans[3].stamp);
  EXPECT_EQ(third->scans[1].ranges_m[4], Drive().log.scans[3].ranges_m[8]);
  EXPECT_NEAR(third->laser.AngleOf_rad(9), Drive().log.laser.AngleOf_rad(18),
              1e-9);
  const auto gaps = Degraded(Drive().log, {.gap_every = 40, .gap_scans = 10});
  ASSERT_TRUE(gaps.ok());
  EXPECT_EQ(gaps->scans[40].stamp, Drive().log.scans[50].stamp);
}

TEST(DegradedLog, DriftsAndSlipsWithItsSeed) {
  Degradation d = {.rad_per_m = 0.1, .slip_every_m = 5, .slip_m = 0.2};
  const auto one = Degraded(Drive().log, d);
  const auto again = Degraded(Drive().log, d);
  d.seed = 2;
  const auto other = Degraded(Drive().log, d);
  ASSERT_TRUE(one.ok() && again.ok() && other.ok());
  EXPECT_GT(EndError_m(*one), 1);
  EXPECT_EQ(EndError_m(*one), EndError_m(*again));
  EXPECT_NE(EndError_m(*one), EndError_m(*other));
}

TEST(DegradedLog, WheelsOfTwoSizesTurnWithTheWay) {
  const auto curved = Degraded(Drive().log, {.turn_per_m_rad = 0.1});
  ASSERT_TRUE(curved.ok()) << curved.status();
  double way_m = 0;
  double turn_rad = 0;
  for (size_t i = 1; i < curved->scans.size(); ++i) {
    const auto step = [i](const recording::LaserLog& log) {
      return log.scans[i - 1].odom_from_base.Inverse() *
             log.scans[i].odom_from_base;
    };
    way_m += geometry::Norm(step(Drive().log).translation);
    turn_rad += geometry::NormalizedAngle_rad(step(*curved).yaw_rad -
                                              step(Drive().log).yaw_rad);
  }
  EXPECT_NEAR(turn_rad, 0.1 * way_m, 1e-6);
}

TEST(DegradedLog, RefusesWhatIsNotSane) {
  const auto none = Degraded(Drive().log, {.every_scan = 1000000});
  EXPECT_THAT(std::string(none.status().message()),
              HasSubstr("leaves 1 scans"));
  EXPECT_FALSE(Degraded(Drive().log, {.every_beam = 0}).ok());
  EXPECT_FALSE(Degraded(Drive().log, {.turn_scale = 0}).ok());
}

TEST(SyntheticOffice, RelationsAreOfTheTruthAndCloseLoops) {
  const auto relations = TrueRelations(Drive(), Drive().log);
  int loops = 0;
  for (const recording::PoseRelation& relation : relations) {
    const double way_m =
        geometry::Norm(relation.from_base_from_to_base.translation);
    EXPECT_LT(way_m, 2.01);
    loops += recording::SecondsBetween(relation.from, relation.to) > 60 ? 1 : 0;
  }
  EXPECT_GT(relations.size(), 100u);
  EXPECT_GT(loops, 20);
}

// The robot drives through no wall: something is seen, and not at once.
TEST(SyntheticOffice, DrivesInTheClear) {
  for (const recording::RecordedScan& scan : Drive().log.scans) {
    for (const float range_m : scan.ranges_m) EXPECT_GT(range_m, 0.2F);
  }
}

}  // namespace
}  // namespace treeline::laser_slam
