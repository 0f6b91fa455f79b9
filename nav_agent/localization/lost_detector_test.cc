#include "nav_agent/localization/lost_detector.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/localization/testing_map.h"

namespace treeline::localization {
namespace {

constexpr geometry::Rigid2 kPlace = {.translation = {0.5, 2.9}, .yaw_rad = 0.4};
constexpr geometry::Rigid2 kElsewherePlace = {.translation = {7, 4},
                                              .yaw_rad = 2};
const geometry::Rigid3 kBaseFromLaser = {.rotation = {},
                                         .translation = {0, 0, 0.35}};
constexpr double kScan_s = 0.1;

LostFeatures Usual() {
  LostFeatures features;
  features.values[kLongShare] = 0.02;
  features.values[kResidual] = 0.15;
  features.values[kDeficit] = 0.02;
  return features;
}

double AfterScans(const LostFeatures& features, int scans) {
  LostFilter filter{LostFilterOptions()};
  for (int i = 0; i < scans; ++i) filter.Observe(features, kScan_s);
  return filter.Probability();
}

TEST(LostFilterTest, WorseEvidenceNeverLowersTheProbability) {
  for (size_t feature = 0; feature < kLostFeatures; ++feature) {
    double last = 0;
    for (double value = 0; value <= 1; value += 0.05) {
      LostFeatures features = Usual();
      features.values[feature] = value;
      const double probability = AfterScans(features, 8);
      EXPECT_GE(probability, last) << "feature " << feature << " at " << value;
      last = probability;
    }
  }
  double last = 0;
  for (double jump = 0; jump <= 1; jump += 0.05) {
    LostFeatures features = Usual();
    features.jump = jump;
    EXPECT_GE(AfterScans(features, 3), last) << "jump " << jump;
    last = AfterScans(features, 3);
  }
}

TEST(LostFilterTest, GoodScansBringItDownAgain) {
  LostFilter filter{LostFilterOptions()};
  LostFeatures bad = Usual();
  bad.values[kLongShare] = 0.6;
  bad.values[kDeficit] = 0.6;
  for (int i = 0; i < 100; ++i) filter.Observe(bad, kScan_s);
  EXPECT_GT(filter.Probability(), 0.99);
  for (int i = 0; i < 100; ++i) filter.Observe(Usual(), kScan_s);
  EXPECT_LT(filter.Probability(), 0.01);
}

TEST(LostFilterTest, StandingStillDoesNotMultiplyEvidence) {
  // The same time in ten times as many scans tells the same.
  LostFilter slow{LostFilterOptions()};
  LostFilter fast{LostFilterOptions()};
  LostFeatures bad = Usual();
  bad.values[kLongShare] = 0.35;
  for (int i = 0; i < 10; ++i) slow.Observe(bad, 0.1);
  for (int i = 0; i < 100; ++i) fast.Observe(bad, 0.01);
  EXPECT_NEAR(slow.log_odds(), fast.log_odds(), 1e-2);
}

// A robot at `true_pose` in the testing map, that believes it is at another.
class Drive {
 public:
  Drive()
      : detector_(*LostDetector::Create(LaserMap::AllOpaque(TestingMap()),
                                        TestingLaser(), kBaseFromLaser, {})) {}

  absl::StatusOr<LostVerdict> Scan(const geometry::Rigid2& map_from_base,
                                   const geometry::Rigid2& truth) {
    base::Random random(7, static_cast<uint64_t>(++scans_));
    const core::LaserScan scan =
        ScanOf(TestingMap(), TestingLaser(), truth, 0.01, random);
    return Show(map_from_base, scan);
  }
  absl::StatusOr<LostVerdict> Show(const geometry::Rigid2& map_from_base,
                                   const core::LaserScan& scan) {
    time_ += std::chrono::milliseconds(100);
    LostEvidence evidence;
    evidence.stamp = time_;
    evidence.estimate.map_from_base = map_from_base;
    evidence.estimate.share = 1;
    evidence.odom_from_base = odom_from_base;
    evidence.pitch_rad = pitch_rad;
    return detector_.Observe(evidence, scan);
  }
  LostDetector& detector() { return detector_; }

  geometry::Rigid2 odom_from_base;
  double pitch_rad = 0;

 private:
  LostDetector detector_;
  base::MonotonicTime time_{};
  int scans_ = 0;
};

// A box 0.3 m before the laser hides most of what it sees.
core::LaserScan BehindBox(const geometry::Rigid2& truth, uint64_t scan) {
  base::Random random(8, scan);
  core::LaserScan hidden =
      ScanOf(TestingMap(), TestingLaser(), truth, 0.01, random);
  const core::RangeSensorInfo laser = TestingLaser();
  for (int i = 0; i < laser.beams; ++i) {
    const double angle_rad = laser.AngleOf_rad(i);
    if (std::abs(angle_rad) > 1.3) continue;
    float& range_m = hidden.ranges_m[static_cast<size_t>(i)];
    range_m = std::min(range_m, static_cast<float>(0.3 / std::cos(angle_rad)));
  }
  return hidden;
}

TEST(LostDetectorTest, KnownThingsAreNotHeldAgainstItsPlace) {
  auto things = std::make_shared<KnownThings>();
  std::vector<geometry::Vec2> front;
  for (double y_m = -1.1; y_m <= 1.1; y_m += 0.02) {
    front.push_back(kPlace * geometry::Vec2{0.3, y_m});
  }
  things->Add(0, front);
  for (const bool knows : {false, true}) {
    Drive drive;
    if (knows) drive.detector().SetKnownThings(things);
    for (uint64_t i = 0; i < 60; ++i) {
      ASSERT_TRUE(drive.Show(kPlace, BehindBox(kPlace, i)).ok());
    }
    const LostFeatures& features = drive.detector().verdict().features;
    EXPECT_EQ(features.changed_share > 0.3, !knows) << features.changed_share;
    EXPECT_EQ(features.explained_share > 0.8, knows);
    if (knows) {
      EXPECT_EQ(drive.detector().verdict().state, LostState::kLocalized);
    }
  }
  // On another level they say nothing.
  EXPECT_FALSE(things->IsNear(1, front.front()));
  EXPECT_TRUE(things->IsNear(0, front.front()));
}

TEST(LostDetectorTest, ARobotWhereItBelievesToBeIsLocalized) {
  Drive drive;
  for (int i = 0; i < 50; ++i) {
    const auto verdict = drive.Scan(kPlace, kPlace);
    ASSERT_TRUE(verdict.ok());
    EXPECT_EQ(verdict->state, LostState::kLocalized);
  }
  EXPECT_LT(drive.detector().verdict().probability, 0.01);
}

TEST(LostDetectorTest, AColdStartAtTheWrongPlaceIsLostWithinThreeSeconds) {
  Drive drive;
  for (int i = 0; i < 30; ++i) {
    ASSERT_TRUE(drive.Scan(kPlace, kElsewherePlace).ok());
  }
  EXPECT_EQ(drive.detector().verdict().state, LostState::kLost);
  EXPECT_EQ(drive.detector().verdict().reason, LostReason::kPassesThroughWalls);
}

TEST(LostDetectorTest, AKidnapIsLostWithinThreeSecondsAndNamed) {
  Drive drive;
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(drive.Scan(kPlace, kPlace).ok());
  for (int i = 0; i < 30; ++i) {
    ASSERT_TRUE(drive.Scan(kPlace, kElsewherePlace).ok());
  }
  EXPECT_EQ(drive.detector().verdict().state, LostState::kLost);
  EXPECT_EQ(drive.detector().verdict().reason, LostReason::kJumped);
  // It is told the truth.
  drive.detector().Reset();
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(drive.Scan(kElsewherePlace, kElsewherePlace).ok());
  }
  EXPECT_EQ(drive.detector().verdict().state, LostState::kLocalized);
}

TEST(LostDetectorTest, ACrowdThatWalksAboutIsNeverLost) {
  // Everybody is near, up to all around, and everywhere else in the next scan.
  for (const size_t width : {20u, 60u, 120u, 181u}) {
    Drive drive;
    for (int i = 0; i < 20; ++i) ASSERT_TRUE(drive.Scan(kPlace, kPlace).ok());
    double highest = 0;
    LostState state = LostState::kLocalized;
    base::Random noise(9, 0);
    const core::LaserScan empty =
        ScanOf(TestingMap(), TestingLaser(), kPlace, 0.01, noise);
    for (int i = 0; i < 200; ++i) {
      base::Random random(9, static_cast<uint64_t>(i));
      core::LaserScan scan = empty;
      const size_t first = static_cast<size_t>(i * 37) % 181;
      const float range_m = static_cast<float>(0.5 + 0.9 * random.NextUnit());
      for (size_t k = 0; k < width; ++k) {
        float& beam_m = scan.ranges_m[(first + k) % 181];
        beam_m = std::min(beam_m, range_m);
      }
      const auto verdict = drive.Show(kPlace, scan);
      ASSERT_TRUE(verdict.ok());
      highest = std::max(highest, verdict->probability);
      state = verdict->state;
    }
    EXPECT_LT(highest, 0.5) << width << " beams";
    if (width == 120) {
      EXPECT_EQ(state, LostState::kPeopleNearby);
    }
  }
}

TEST(LostDetectorTest, NewFurnitureIsAChangedMap) {
  Drive drive;
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(drive.Scan(kPlace, kPlace).ok());
  base::Random random(11, 0);
  const core::LaserScan empty =
      ScanOf(TestingMap(), TestingLaser(), kPlace, 0.01, random);
  for (int i = 0; i < 100; ++i) {
    core::LaserScan scan = empty;
    for (size_t k = 60; k < 105; ++k) {
      scan.ranges_m[k] = std::min(scan.ranges_m[k], 1.0f);
    }
    ASSERT_TRUE(drive.Show(kPlace, scan).ok());
  }
  EXPECT_EQ(drive.detector().verdict().state, LostState::kMapChangedHere);
  EXPECT_LT(drive.detector().verdict().probability, 0.1);
}

TEST(LostDetectorTest, ALiftedRobotIsDoubted) {
  Drive drive;
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(drive.Scan(kPlace, kPlace).ok());
  const double before = drive.detector().verdict().probability;
  drive.pitch_rad = 0.5;
  ASSERT_TRUE(drive.Scan(kPlace, kPlace).ok());
  EXPECT_GT(drive.detector().verdict().probability, 10 * before);
}

TEST(LostDetectorTest, WheelsThatTurnInTheAirAreDoubted) {
  Drive drive;
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(drive.Scan(kPlace, kPlace).ok());
  const double before = drive.detector().verdict().probability;
  // Wheels say 0.8 m/s, and localization believes them; the scan stands.
  geometry::Rigid2 believed = kPlace;
  double highest = 0;
  for (int i = 0; i < 20; ++i) {
    const geometry::Rigid2 step = {.translation = {0.08, 0}};
    drive.odom_from_base = drive.odom_from_base * step;
    believed = believed * step;
    const auto verdict = drive.Scan(believed, kPlace);
    ASSERT_TRUE(verdict.ok());
    highest = std::max(highest, verdict->probability);
  }
  EXPECT_GT(highest, 10 * before);
}

TEST(LostDetectorTest, TheSameScansGiveTheSameVerdicts) {
  Drive a;
  Drive b;
  for (int i = 0; i < 30; ++i) {
    const geometry::Rigid2 truth = i < 15 ? kPlace : kElsewherePlace;
    ASSERT_TRUE(a.Scan(kPlace, truth).ok());
    ASSERT_TRUE(b.Scan(kPlace, truth).ok());
    EXPECT_EQ(a.detector().log_odds(), b.detector().log_odds());
  }
}

TEST(LostDetectorTest, RefusesWhatIsNoEvidenceAndStaysAsItWas) {
  Drive drive;
  ASSERT_TRUE(drive.Scan(kPlace, kPlace).ok());
  const double before = drive.detector().log_odds();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(drive.Scan({.translation = {nan, 0}}, kPlace).status().code(),
            absl::StatusCode::kInvalidArgument);
  drive.pitch_rad = nan;
  EXPECT_EQ(drive.Scan(kPlace, kPlace).status().code(),
            absl::StatusCode::kInvalidArgument);
  drive.pitch_rad = 0;
  EXPECT_EQ(drive.Show(kPlace, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(drive.detector().log_odds(), before);
  // Nothing that is seen is no evidence, and no error.
  core::LaserScan blind;
  blind.ranges_m.assign(181, core::kNoReturn);
  ASSERT_TRUE(drive.Show(kPlace, blind).ok());
  EXPECT_LT(drive.detector().verdict().probability, 0.5);
}

TEST(LostDetectorTest, AClockThatGoesBackIsAnError) {
  LostDetector detector = *LostDetector::Create(
      LaserMap::AllOpaque(TestingMap()), TestingLaser(), kBaseFromLaser, {});
  base::Random random(1, 1);
  const core::LaserScan scan =
      ScanOf(TestingMap(), TestingLaser(), kPlace, 0.01, random);
  LostEvidence evidence;
  evidence.estimate.map_from_base = kPlace;
  evidence.stamp = base::MonotonicTime(std::chrono::seconds(10));
  ASSERT_TRUE(detector.Observe(evidence, scan).ok());
  evidence.stamp = base::MonotonicTime(std::chrono::seconds(9));
  EXPECT_EQ(detector.Observe(evidence, scan).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(LostDetectorTest, RefusesBadOptions) {
  LostDetectorOptions options;
  options.filter.model.weights[kResidual] = -1;
  EXPECT_EQ(options.Validate().code(), absl::StatusCode::kInvalidArgument);
  options = {};
  options.declare_at = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(options.Validate().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_TRUE(LostDetectorOptions().Validate().ok());
}

}  // namespace
}  // namespace treeline::localization
