#include "evaluation/dockings/docking_suite.h"

#include <cmath>
#include <memory>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "evaluation/dockings/docking_report.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::dockings {
namespace {

using ::testing::HasSubstr;

// Made once: it takes a second.
const suites::SuitePlace& Cafe() {
  static const auto* const kCafe = [] {
    auto world = worlds::MakeWorld(
        "cafe", {.with_people = false, .threads = 1, .paint = false});
    EXPECT_TRUE(world.ok()) << world.status();
    auto place = suites::SuitePlace::MakePerfect(*std::move(world));
    EXPECT_TRUE(place.ok()) << place.status();
    return new std::shared_ptr<const suites::SuitePlace>(*std::move(place));
  }();
  return **kCafe;
}

DockingRun DockIn(const std::string& scene, uint64_t seed) {
  const auto run =
      RunDocking(Cafe(), {.seed = seed, .scene = scene}, std::stop_token());
  EXPECT_TRUE(run.ok()) << run.status();
  return run.value_or(DockingRun());
}

// Wheels that slip, AMCL's error and the laser's noise: all of them.
TEST(RunDockingTest, ItStandsWithinTwoCentimetresOfItsDock) {
  for (const char* scene : {"plain", "backward", "moved"}) {
    SCOPED_TRACE(scene);
    const DockingRun run = DockIn(scene, 1000);
    EXPECT_TRUE(run.IsGood()) << DockingSummary({run}, 1);
  }
}

// Its battery says all the time that it charges.
TEST(RunDockingTest, WhoIsCarriedAwayKnowsAndComesBack) {
  const DockingRun run = DockIn("cable", 1000);
  EXPECT_TRUE(run.IsGood()) << DockingSummary({run}, 1);
  EXPECT_TRUE(run.was_carried);
  EXPECT_GE(run.false_losses, 1);
  EXPECT_LE(run.believed_s, kMostBelieved_s);
}

TEST(RunDockingTest, SomebodyMustBeThere) {
  EXPECT_TRUE(HasPeople("visitor"));
  EXPECT_FALSE(HasPeople("plain"));
  EXPECT_THAT(std::string(RunDocking(Cafe(), {.seed = 1, .scene = "passers"},
                                     std::stop_token())
                              .status()
                              .message()),
              HasSubstr("nobody is about"));
}

TEST(RunDockingTest, IsAFunctionOfTheSeed) {
  const DockingRun first = DockIn("plain", 1001);
  const DockingRun second = DockIn("plain", 1001);
  EXPECT_EQ(first.record.final_state.world_from_base.translation,
            second.record.final_state.world_from_base.translation);
  EXPECT_EQ(first.miss.along_m, second.miss.along_m);
  EXPECT_FALSE(DockIn("plain", 1002).dock.position == first.dock.position);
}

TEST(RunDockingTest, WhatIsNoSceneIsSaid) {
  EXPECT_THAT(std::string(RunDocking(Cafe(), {.seed = 1, .scene = "moon"},
                                     std::stop_token())
                              .status()
                              .message()),
              HasSubstr("plain, backward"));
}

TEST(DockingReportTest, SaysHowFarOffAndWhatFailedWithItsSeed) {
  DockingRun good;
  good.world = "cafe";
  good.scene = "plain";
  good.seed = 1;
  good.outcome = DockingSuiteOutcome::kExact;
  good.miss = {.along_m = -0.004, .aside_m = 0.003, .turned_rad = 0.01};
  DockingRun off = good;
  off.seed = 2;
  off.outcome = DockingSuiteOutcome::kInexact;
  off.miss.aside_m = 0.03;
  DockingRun failed = good;
  failed.seed = 3;
  failed.outcome = DockingSuiteOutcome::kFailed;
  failed.miss.along_m = -1;
  failed.why = "no \"way\"";
  const std::string text = DockingSummary({good, off, failed}, 4);
  EXPECT_THAT(text, HasSubstr("cafe, plain"));
  EXPECT_THAT(text, HasSubstr("seed 2: inexact"));
  EXPECT_THAT(text, HasSubstr("seed 3: failed"));
  EXPECT_THAT(text, HasSubstr("1 of 4 dockings were not run"));
  const std::string json = DockingJson({good, off, failed}, 4);
  EXPECT_THAT(json, HasSubstr("\"good\": 1,"));
  // Of those that say that they are docked.
  EXPECT_THAT(json, HasSubstr("\"off_most_m\": 0.0303,"));
  EXPECT_THAT(json, HasSubstr("no \\\"way\\\""));
}

}  // namespace
}  // namespace treeline::dockings
