#include "evaluation/kidnaps/kidnap_suite.h"

#include <optional>
#include <string>
#include <vector>

#include "evaluation/kidnaps/kidnap_report.h"
#include "evaluation/suites/suite_maps.h"
#include "evaluation/suites/suite_report.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::kidnaps {
namespace {

using ::testing::HasSubstr;

constexpr suites::PoseMiss kRight = {
    .distance_m = 0.1, .turn_deg = 2, .height_m = 0};
constexpr suites::PoseMiss kWrong = {
    .distance_m = 4, .turn_deg = 90, .height_m = 0};

// A mode for a while, ten times a second.
void Pass(KidnapJudge& judge, double& now_s, double seconds,
          behavior::NavigatorMode mode,
          const std::optional<suites::PoseMiss>& error) {
  for (const double end_s = now_s + seconds; now_s < end_s; now_s += 0.1) {
    judge.Observe(now_s, mode, false, error);
  }
}

KidnapRun Judged(const KidnapJudge& judge) {
  KidnapRun run;
  judge.Judge(run);
  return run;
}

TEST(KidnapJudgeTest, WhoFindsItsPlaceAndDrivesOnIsBack) {
  KidnapJudge judge(100);
  double now_s = 100;
  Pass(judge, now_s, 2, behavior::NavigatorMode::kDriving, kWrong);
  Pass(judge, now_s, 5, behavior::NavigatorMode::kRelocalizing, kWrong);
  Pass(judge, now_s, 3, behavior::NavigatorMode::kDriving, kRight);
  EXPECT_TRUE(judge.IsBack());
  const KidnapRun run = Judged(judge);
  EXPECT_EQ(run.outcome, KidnapOutcome::kBack);
  EXPECT_NEAR(run.noticed_after_s, 2, 0.11);
  EXPECT_NEAR(run.back_after_s, 7, 0.21);
  EXPECT_EQ(run.resumptions, 1);
  EXPECT_EQ(run.wrong_resumptions, 0);
  EXPECT_EQ(run.error_at_resumption.distance_m, 0.1);
}

TEST(KidnapJudgeTest, WhoGoesOnWithAWrongPoseIsWrongEvenIfItIsRightLater) {
  KidnapJudge judge(0);
  double now_s = 0;
  Pass(judge, now_s, 5, behavior::NavigatorMode::kRelocalizing, kWrong);
  Pass(judge, now_s, 2, behavior::NavigatorMode::kDriving, kWrong);
  Pass(judge, now_s, 5, behavior::NavigatorMode::kRelocalizing, kWrong);
  Pass(judge, now_s, 3, behavior::NavigatorMode::kDriving, kRight);
  const KidnapRun run = Judged(judge);
  EXPECT_EQ(run.outcome, KidnapOutcome::kWrong);
  EXPECT_EQ(run.wrong_resumptions, 1);
  EXPECT_EQ(run.resumptions, 2);
  EXPECT_EQ(run.error_at_resumption.distance_m, 4);
}

TEST(KidnapJudgeTest, AGlimpseOfTheRightPoseIsNotEnough) {
  KidnapJudge judge(0);
  double now_s = 0;
  Pass(judge, now_s, 0.5, behavior::NavigatorMode::kDriving, kRight);
  Pass(judge, now_s, 5, behavior::NavigatorMode::kDriving, kWrong);
  EXPECT_FALSE(judge.IsBack());
  EXPECT_EQ(Judged(judge).outcome, KidnapOutcome::kUnnoticed);
}

TEST(KidnapJudgeTest, TellsLateFromHelplessFromSearching) {
  KidnapJudge late(0);
  double now_s = 0;
  Pass(late, now_s, 25, behavior::NavigatorMode::kRelocalizing, std::nullopt);
  Pass(late, now_s, 2, behavior::NavigatorMode::kDriving, kRight);
  EXPECT_EQ(Judged(late).outcome, KidnapOutcome::kLate);
  KidnapJudge searching(0);
  now_s = 0;
  Pass(searching, now_s, 25, behavior::NavigatorMode::kRelocalizing,
       std::nullopt);
  EXPECT_EQ(Judged(searching).outcome, KidnapOutcome::kSearching);
  Pass(searching, now_s, 1, behavior::NavigatorMode::kNeedHelp, std::nullopt);
  EXPECT_EQ(Judged(searching).outcome, KidnapOutcome::kNeedHelp);
}

// Maps and models of the one must not be taken for those of the other.
TEST(SuiteMapsTest, KeepsWhatWasLearntInOtherLightUnderAnotherName) {
  suites::SuiteMapOptions options = {.world = "seed:17",
                                     .lighting = building::Lighting::kEvening};
  EXPECT_EQ(suites::SuiteSceneName(options), "seed-17");
  options.map_lighting = building::Lighting::kEvening;
  options.lighting = building::Lighting::kDay;
  EXPECT_EQ(suites::SuiteSceneName(options), "seed-17-in-evening");
  options.cache = "cache";
  EXPECT_EQ(suites::SuiteBundleFolder(options),
            "cache/seed-17-in-evening/bundle");
}

TEST(KidnapReportTest, CountsWhatGoesWrong) {
  KidnapRun back;
  back.world = "cafe";
  back.seed = 1;
  back.is_warm = true;
  back.outcome = KidnapOutcome::kBack;
  back.back_after_s = 9;
  KidnapRun wrong = back;
  wrong.seed = 2;
  wrong.is_warm = false;
  wrong.outcome = KidnapOutcome::kWrong;
  wrong.wrong_resumptions = 2;
  const std::vector<KidnapRun> runs = {back, wrong};
  EXPECT_EQ(suites::GoodShare(runs), 0.5);
  EXPECT_EQ(WrongResumptions(runs), 2);
  EXPECT_THAT(KidnapSummary(runs, 2), HasSubstr("cafe seed 2 (cold): wrong"));
  const std::string json =
      KidnapJson(runs, 2,
                 {.method = "server",
                  .fault = "none",
                  .lighting = building::Lighting::kEvening,
                  .rearranged = {.seed = 3, .share = 0.25}});
  EXPECT_THAT(json, HasSubstr("\"back\": 1,"));
  EXPECT_THAT(json, HasSubstr("\"light\": \"evening\",\n  \"map_light\": "
                              "\"day\""));
  EXPECT_THAT(json, HasSubstr("\"rearranged\": {\"seed\": 3, \"share\": "
                              "0.25}"));
  EXPECT_THAT(json, HasSubstr("\"wrong_resumptions\": 2,"));
}

}  // namespace
}  // namespace treeline::kidnaps
