#include "nav_agent/mapping/between_scans.h"

#include <memory>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/mapping/testing_plan.h"

namespace treeline::mapping {
namespace {

// They may be 10 cm off, where the rest is as usual.
const OdometryNoise kWheels = {.m = 0.1, .is_estimated = false};

std::vector<TestWall> Room() {
  std::vector<TestWall> walls;
  AddBox({-3, -2}, {4, 2}, &walls);
  AddBox({1, 1}, {1.5, 1.4}, &walls);
  return walls;
}

ScanOutline See(const geometry::Rigid2& from, uint64_t stream) {
  const core::RangeSensorInfo laser = TestLaser(20);
  return MakeScanOutline(CastScan(Room(), from, laser, 0.01, stream), laser,
                         {});
}

// Two keyscans 0.4 m apart and three scans between, which odometry puts 4 cm
// and 0.02 rad beside their places; the front end was wrong by as much about
// the second keyscan.
class BetweenScansTest : public ::testing::Test {
 protected:
  BetweenScansTest() {
    for (int i = 0; i <= 4; ++i) {
      truth_.push_back({{0.1 * i, 0}, 0});
      const double part = 0.25 * i;
      places_.push_back(
          {.stamp = {},
           .keyscan = i < 4 ? 0u : 1u,
           .keyscan_from_base =
               i < 4 ? geometry::Rigid2{{0.1 * i, 0.04 * part}, 0.02 * part}
                     : geometry::Rigid2{},
           .level_from_base = {},
           .way_m = 0.1 * i});
    }
    for (const size_t i : {size_t{0}, size_t{4}}) {
      keyscans_.push_back(
          {.scan = std::make_shared<const ScanOutline>(See(truth_[i], i)),
           .map_from_base = truth_[i],
           .slope = {}});
    }
    keyscans_[1].previous_from_this = geometry::Rigid2{{0.4, 0.04}, 0.02};
  }
  void Refine(const BetweenScans& scans) {
    scans.Refine(keyscans_, OdometryDoubt(kWheels, 3), 0.3, 0.03, places_);
  }
  double Off_m(size_t i) const {
    const geometry::Rigid2 pose = keyscans_[places_[i].keyscan].map_from_base *
                                  places_[i].keyscan_from_base;
    return geometry::Norm(pose.translation - truth_[i].translation);
  }

  std::vector<geometry::Rigid2> truth_;
  std::vector<Keyscan> keyscans_;
  std::vector<ScanPlace> places_;
};

TEST_F(BetweenScansTest, TheWayLeadsFromOneKeyscanToTheNext) {
  Refine(BetweenScans({}));
  for (size_t i = 0; i < places_.size(); ++i) EXPECT_LT(Off_m(i), 1e-9) << i;
  // There is nothing left to bend.
  Refine(BetweenScans({}));
  for (size_t i = 0; i < places_.size(); ++i) EXPECT_LT(Off_m(i), 1e-9) << i;
}

TEST_F(BetweenScansTest, KeptScansAreLaidUponKeyscansAndOthersFollow) {
  // A slip that odometry does not know of: all three are beside their places.
  for (size_t i = 1; i <= 3; ++i) {
    places_[i].keyscan_from_base.translation.x += 0.06;
  }
  BetweenScans scans({});
  scans.Add(1, See(truth_[1], 11));
  scans.Add(3, See(truth_[3], 13));
  Refine(scans);
  // Surfels of a centimetre, dozens of them.
  EXPECT_LT(Off_m(1), 0.008);
  EXPECT_LT(Off_m(2), 0.008);
  EXPECT_LT(Off_m(3), 0.008);
}

TEST_F(BetweenScansTest, PlacesThatNobodyKnowsStayAsTheyAre) {
  places_[2].keyscan = kNowhere;
  const geometry::Rigid2 was = places_[2].keyscan_from_base;
  BetweenScans scans({});
  scans.Add(2, See(truth_[2], 12));
  Refine(scans);
  EXPECT_EQ(places_[2].keyscan_from_base, was);
}

}  // namespace
}  // namespace treeline::mapping
