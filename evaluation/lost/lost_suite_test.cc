#include "evaluation/lost/lost_suite.h"

#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"
#include "evaluation/lost/lost_fit.h"
#include "evaluation/lost/lost_suite_report.h"
#include "gtest/gtest.h"

namespace treeline::lost {
namespace {

const double kThreshold = std::log(0.95 / 0.05);

runs::SuiteWorld Map() {
  const auto world = worlds::MakeWorld(
      "cafe", {.with_people = false, .threads = 1, .paint = false});
  EXPECT_TRUE(world.ok());
  auto map = runs::SuiteWorld::Create(*world, 0.35);
  EXPECT_TRUE(map.ok()) << map.status();
  return *std::move(map);
}

LostRun ShortRun(const runs::SuiteWorld& map) {
  LostRunOptions options;
  options.world = "cafe";
  options.seed = 5;
  options.drive_s = 8;
  options.kidnaps = 2;
  options.new_obstacles = 2;
  double simulated_s = 0;
  auto run = RunLostSuite(map, options,
                          [&](double seconds) { simulated_s += seconds; }, {});
  EXPECT_TRUE(run.ok()) << run.status();
  EXPECT_NEAR(simulated_s, ExpectedSeconds(options), 1);
  return *std::move(run);
}

TEST(LostSuiteTest, KidnappedRobotsAreLostAndDrivingOnesAreNot) {
  const runs::SuiteWorld map = Map();
  const LostRun run = ShortRun(map);
  const LostReport report({run}, kThreshold);
  // One drives, one stands.
  EXPECT_EQ(report.Kidnaps(kThreshold, "").kidnaps, 2);
  EXPECT_EQ(report.Kidnaps(kThreshold, "").declared, 2);
  EXPECT_TRUE(report.FalseAlarms(kThreshold, "").empty());
  EXPECT_GT(report.Hours(""), 7.0 / 3600);

  // The same seed gives the same run.
  const LostRun again = ShortRun(map);
  ASSERT_EQ(run.drive.size(), again.drive.size());
  for (size_t i = 0; i < run.drive.size(); ++i) {
    ASSERT_EQ(run.drive[i].log_odds, again.drive[i].log_odds) << i;
  }

  LostRunOptions options;
  options.world = "atlantis";
  EXPECT_FALSE(RunLostSuite(map, options, [](double) {}, {}).ok());
}

KidnapTrial TrialOf(const std::vector<double>& log_odds,
                    const std::vector<bool>& lost) {
  KidnapTrial trial;
  trial.log_odds_before = -5;
  for (size_t i = 0; i < log_odds.size(); ++i) {
    LostSample sample;
    sample.time_s = static_cast<float>(i);
    sample.log_odds = static_cast<float>(log_odds[i]);
    sample.is_lost = lost[i];
    trial.samples.push_back(sample);
  }
  return trial;
}

TEST(LostReportTest, CountsKidnapsThatLastUntilTheyAreDeclared) {
  LostRun run;
  run.world = "w";
  // Declared after one second; after four, too late.
  run.trials.push_back(
      TrialOf({-5, 5, 5, 5, 5}, {true, true, true, true, true}));
  run.trials.push_back(
      TrialOf({-5, -5, -5, -5, 5}, {true, true, true, true, true}));
  // It found its place again before; and was called lost before.
  run.trials.push_back(
      TrialOf({-5, -5, 5, 5, 5}, {true, false, false, true, true}));
  run.trials.push_back(TrialOf({5, 5}, {true, true}));
  run.trials.back().log_odds_before = 4;
  const KidnapTally tally =
      LostReport({run}, kThreshold).Kidnaps(kThreshold, "");
  EXPECT_EQ(tally.kidnaps, 2);
  EXPECT_EQ(tally.declared, 1);
  EXPECT_EQ(tally.not_lost, 1);
  EXPECT_EQ(tally.alarmed_before, 1);
  ASSERT_EQ(tally.delays_s.size(), 1u);
  EXPECT_DOUBLE_EQ(tally.delays_s[0], 1);
}

TEST(LostReportTest, AnAlarmThatGoesOnIsOneAndARealLossIsNone) {
  LostRun run;
  run.world = "w";
  for (int s = 0; s < 100; ++s) {
    LostSample sample;
    sample.time_s = static_cast<float>(s);
    // From 10 to 15 s with a gap, at 40 s, and before and after a loss at 60 s.
    sample.log_odds =
        (s >= 10 && s < 15 && s != 12) || s == 40 || s == 58 || s == 65 ? 5
                                                                        : -5;
    sample.is_lost = s == 60;
    run.drive.push_back(sample);
  }
  const LostReport report({run}, kThreshold);
  const std::vector<FalseAlarm> alarms = report.FalseAlarms(kThreshold, "");
  ASSERT_EQ(alarms.size(), 2u);
  EXPECT_EQ(alarms[0].sample.time_s, 10);
  EXPECT_EQ(alarms[1].sample.time_s, 40);
}

TEST(LostFitTest, FindsWhatTellsAndNeverWeighsBackwards) {
  // long_share tells, residual tells the wrong way round.
  std::string table = "header\n";
  base::Random random(3, 1);
  for (int i = 0; i < 400; ++i) {
    const int lost = i % 2;
    const double tells = 0.2 * lost + 0.4 * random.NextUnit();
    const double backwards = 0.3 - 0.2 * lost + 0.1 * random.NextUnit();
    absl::StrAppend(&table, lost, ",0,", tells, ",", backwards, ",0,0,0,0,0\n");
  }
  const auto model = FitLostModel(table);
  ASSERT_TRUE(model.ok()) << model.status();
  EXPECT_GT(model->weights[localization::kLongShare], 3);
  EXPECT_EQ(model->weights[localization::kResidual], 0);
}

TEST(LostFitTest, RefusesOtherTables) {
  for (const std::string& table :
       {std::string(), std::string("h\n1,0,1,1,1,1,1,1,1\n"),
        std::string("h\n1,0,nan,1,1,1,1,1,1\n0,0,1,1,1,1,1,1,1\n"),
        std::string("h\n1,0,1\n"), std::string("h\n2,0,1,1,1,1,1,1,1\n")}) {
    EXPECT_EQ(FitLostModel(table).status().code(),
              absl::StatusCode::kInvalidArgument)
        << table;
  }
}

}  // namespace
}  // namespace treeline::lost
