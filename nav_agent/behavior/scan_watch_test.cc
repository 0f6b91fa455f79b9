#include "nav_agent/behavior/scan_watch.h"

#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_relocalization.h"

namespace treeline::behavior {
namespace {

constexpr ScanFitLimits kLimits = {
    .min_explained = 0.6, .max_contradicted = 0.15, .min_judged = 12};

class ScanWatchTest : public testing::Test {
 protected:
  ScanWatchTest() {
    tracker_.now = At(100);
    tracker_.believed =
        core::LevelPose{.map_from_base = tracker_.truth, .place = {}};
  }
  // The fake's scans are 0.1 s apart.
  ScanVerdict Next() {
    tracker_.now += std::chrono::milliseconds(100);
    return watch_.Watch(tracker_, kLimits);
  }

  ScriptedTracker tracker_;
  ScanWatch watch_;
};

TEST_F(ScanWatchTest, JudgesEachScanOnce) {
  EXPECT_EQ(Next(), ScanVerdict::kGood);
  EXPECT_EQ(watch_.Watch(tracker_, kLimits), ScanVerdict::kNothingNew);
  tracker_.believed->map_from_base.translation.x += 2;
  EXPECT_EQ(watch_.Watch(tracker_, kLimits), ScanVerdict::kNothingNew);
  EXPECT_EQ(Next(), ScanVerdict::kBad);
}

TEST_F(ScanWatchTest, ASkippedScanIsNotJudged) {
  watch_.SkipNewest(tracker_);
  EXPECT_EQ(watch_.Watch(tracker_, kLimits), ScanVerdict::kNothingNew);
  EXPECT_EQ(Next(), ScanVerdict::kGood);
}

TEST_F(ScanWatchTest, FewBeamsSayNothing) {
  tracker_.judged = 11;
  EXPECT_EQ(Next(), ScanVerdict::kNothingNew);
  tracker_.judged = 12;
  EXPECT_EQ(Next(), ScanVerdict::kGood);
}

TEST_F(ScanWatchTest, WithoutAPlaceThereIsNothingToJudge) {
  tracker_.believed.reset();
  EXPECT_EQ(Next(), ScanVerdict::kNothingNew);
}

TEST_F(ScanWatchTest, CountsWithAndWithoutRows) {
  for (const auto verdict : {ScanVerdict::kGood, ScanVerdict::kGood,
                             ScanVerdict::kNothingNew, ScanVerdict::kBad}) {
    watch_.Count(verdict);
  }
  EXPECT_EQ(watch_.good(), 2);
  EXPECT_EQ(watch_.bad(), 1);
  watch_.CountInRow(ScanVerdict::kBad);
  EXPECT_EQ(watch_.good(), 0);
  EXPECT_EQ(watch_.bad(), 2);
  watch_.CountInRow(ScanVerdict::kGood);
  EXPECT_EQ(watch_.good(), 1);
  watch_.ForgetCounts();
  EXPECT_EQ(watch_.good(), 0);
  EXPECT_EQ(watch_.bad(), 0);
}

TEST(TurnMeter, AddsTurnsToEitherSide) {
  TurnMeter meter;
  EXPECT_EQ(meter.Add_rad(3), 0);
  EXPECT_NEAR(meter.Add_rad(-3.1), 0.1832, 1e-3);
  EXPECT_NEAR(meter.Add_rad(3), 0.1832, 1e-3);
  meter.Reset();
  EXPECT_EQ(meter.Add_rad(1), 0);
}

TEST_F(ScanWatchTest, APoseIsTightInOnePlaceOnly) {
  // The fake has all weight in one place, within 0.1 m.
  EXPECT_TRUE(IsPoseTight(tracker_, 0.8, 0.3));
  EXPECT_FALSE(IsPoseTight(tracker_, 0.8, 0.09));
  tracker_.searches = true;
  EXPECT_FALSE(IsPoseTight(tracker_, 0, 0.3));
  tracker_.searches = false;
  tracker_.is_in_doubt = true;
  EXPECT_FALSE(IsPoseTight(tracker_, 0, 0.3));
  // The particles are at one place all the same.
  EXPECT_TRUE(IsPoseGathered(tracker_, 0.8, 0.3));
  tracker_.is_in_doubt = false;
  tracker_.believed.reset();
  EXPECT_FALSE(IsPoseTight(tracker_, 0, 1));
}

}  // namespace
}  // namespace treeline::behavior
