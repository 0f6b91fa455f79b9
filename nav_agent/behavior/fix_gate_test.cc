#include "nav_agent/behavior/fix_gate.h"

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::behavior {
namespace {

using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// A fix that nothing speaks against.
struct Testimony {
  core::RelocalizationAnswer answer;
  FixWitnesses judging_particles;
  FixGateOptions options;

  localization::ScanFit& AtFix() { return *judging_particles.scan->at_fix; }
};

Testimony Sure() {
  Testimony sure;
  sure.answer.localized = true;
  sure.answer.confidence = 0.97;
  for (size_t i = 0; i < 36; i += 7) sure.answer.covariance[i] = 1e-4;
  sure.judging_particles.tilt_error_rad = 0.01;
  sure.judging_particles.ground = {.base_in_map = {2, 3, 0.02}, .ground_m = 0};
  sure.judging_particles.scan = {
      .at_fix =
          localization::ScanFit{
              .explained = 0.95, .contradicted = 0.01, .judged = 100},
      .at_belief = {}};
  return sure;
}

FixJudgement Judge(const Testimony& told) {
  return JudgeFix(told.answer, told.judging_particles, told.options);
}

struct GateCase {
  std::string name;
  std::function<void(Testimony&)> change;
  FixVerdict verdict;
};

class FixGateTable : public testing::TestWithParam<GateCase> {};

TEST_P(FixGateTable, GivesTheVerdict) {
  Testimony told = Sure();
  GetParam().change(told);
  const FixJudgement judgement = Judge(told);
  EXPECT_EQ(judgement.verdict, GetParam().verdict)
      << FixVerdictName(judgement.verdict) << ": " << judgement.why;
}

std::string NameOf(const testing::TestParamInfo<GateCase>& info) {
  return info.param.name;
}

INSTANTIATE_TEST_SUITE_P(
    Answer, FixGateTable,
    testing::Values(
        GateCase{"NothingAgainstIt", [](Testimony&) {}, FixVerdict::kSure},
        GateCase{"NotLocalized",
                 [](Testimony& told) { told.answer.localized = false; },
                 FixVerdict::kNotLocalized},
        GateCase{"PositionIsNoNumber",
                 [](Testimony& told) {
                   told.answer.map_from_camera.translation.x = kNan;
                 },
                 FixVerdict::kBroken},
        GateCase{"RotationIsNone",
                 [](Testimony& told) {
                   told.answer.map_from_camera.rotation = {0, 0, 0, 0};
                 },
                 FixVerdict::kBroken},
        GateCase{"VarianceIsNegative",
                 [](Testimony& told) { told.answer.covariance[7] = -1e-9; },
                 FixVerdict::kBroken},
        GateCase{"CovarianceIsNoNumber",
                 [](Testimony& told) { told.answer.covariance[1] = kNan; },
                 FixVerdict::kBroken},
        GateCase{"NegativeCovarianceBesideTheDiagonal",
                 [](Testimony& told) { told.answer.covariance[1] = -1e-5; },
                 FixVerdict::kSure},
        GateCase{"ConfidenceAboveOne",
                 [](Testimony& told) { told.answer.confidence = 1.001; },
                 FixVerdict::kBroken},
        GateCase{"ConfidenceIsNoNumber",
                 [](Testimony& told) { told.answer.confidence = kNan; },
                 FixVerdict::kBroken},
        GateCase{"LeastConfidence",
                 [](Testimony& told) {
                   told.answer.confidence = told.options.min_confidence;
                 },
                 FixVerdict::kWeak},
        GateCase{"BelowLeastConfidence",
                 [](Testimony& told) {
                   told.answer.confidence = told.options.min_confidence - 1e-9;
                 },
                 FixVerdict::kLowConfidence},
        GateCase{"SureConfidence",
                 [](Testimony& told) {
                   told.answer.confidence = told.options.sure_confidence;
                 },
                 FixVerdict::kSure},
        GateCase{"BelowSureConfidence",
                 [](Testimony& told) {
                   told.answer.confidence = told.options.sure_confidence - 1e-9;
                 },
                 FixVerdict::kWeak},
        GateCase{
            "AtTheScenesThreshold",
            [](Testimony& told) { told.answer.confidence_threshold = 0.97; },
            FixVerdict::kSure},
        GateCase{
            "BelowTheScenesThreshold",
            [](Testimony& told) { told.answer.confidence_threshold = 0.98; },
            FixVerdict::kWeak}),
    NameOf);

INSTANTIATE_TEST_SUITE_P(
    Gravity, FixGateTable,
    testing::Values(GateCase{"LeansAsMuchAsItMay",
                             [](Testimony& told) {
                               told.judging_particles.tilt_error_rad =
                                   told.options.max_tilt_rad;
                             },
                             FixVerdict::kSure},
                    GateCase{"LeansMore",
                             [](Testimony& told) {
                               told.judging_particles.tilt_error_rad =
                                   told.options.max_tilt_rad + 1e-9;
                             },
                             FixVerdict::kAgainstGravity},
                    GateCase{"LeanIsNoNumber",
                             [](Testimony& told) {
                               told.judging_particles.tilt_error_rad = kNan;
                             },
                             FixVerdict::kAgainstGravity},
                    // Of two that refuse, gravity speaks first.
                    GateCase{"LeansInAWall",
                             [](Testimony& told) {
                               told.judging_particles.tilt_error_rad = 1;
                               told.judging_particles.ground->ground_m.reset();
                             },
                             FixVerdict::kAgainstGravity}),
    NameOf);

INSTANTIATE_TEST_SUITE_P(
    Map, FixGateTable,
    testing::Values(
        GateCase{"NoRoom",
                 [](Testimony& told) {
                   told.judging_particles.ground->ground_m.reset();
                 },
                 FixVerdict::kNotOnGround},
        GateCase{"AsHighAsItMay",
                 [](Testimony& told) {
                   told.judging_particles.ground->base_in_map.z =
                       told.options.max_height_error_m;
                 },
                 FixVerdict::kSure},
        GateCase{"InTheAir",
                 [](Testimony& told) {
                   told.judging_particles.ground->base_in_map.z =
                       told.options.max_height_error_m + 1e-9;
                 },
                 FixVerdict::kNotOnGround},
        GateCase{"AmongObstaclesThatAreSeenThrough",
                 [](Testimony& told) {
                   told.judging_particles.ground->is_seen_through = true;
                 },
                 FixVerdict::kWeak},
        GateCase{"SeenThroughByAScanThatJustFits",
                 [](Testimony& told) {
                   told.judging_particles.ground->is_seen_through = true;
                   told.AtFix().explained = told.options.sure_explained;
                   told.AtFix().contradicted = told.options.max_contradicted;
                 },
                 FixVerdict::kWeak},
        GateCase{"SeenThroughByAScanThatFitsBadly",
                 [](Testimony& told) {
                   told.judging_particles.ground->is_seen_through = true;
                   told.AtFix().explained = told.options.sure_explained - 1e-9;
                 },
                 FixVerdict::kNotOnGround},
        GateCase{"SeenThroughByTooFewBeams",
                 [](Testimony& told) {
                   told.judging_particles.ground->is_seen_through = true;
                   told.AtFix().judged = told.options.min_judged_beams - 1;
                 },
                 FixVerdict::kNotOnGround},
        GateCase{"SeenThroughWithoutAScan",
                 [](Testimony& told) {
                   told.judging_particles.ground->is_seen_through = true;
                   told.judging_particles.scan->at_fix.reset();
                 },
                 FixVerdict::kNotOnGround},
        GateCase{"SeenThroughAndAgainstTheScan",
                 [](Testimony& told) {
                   told.judging_particles.ground->is_seen_through = true;
                   told.AtFix().explained = 0.1;
                 },
                 FixVerdict::kAgainstScan},
        GateCase{"BelowTheFloor",
                 [](Testimony& told) {
                   told.judging_particles.ground->base_in_map.z =
                       -told.options.max_height_error_m - 1e-9;
                 },
                 FixVerdict::kNotOnGround}),
    NameOf);

INSTANTIATE_TEST_SUITE_P(
    Laser, FixGateTable,
    testing::Values(
        GateCase{"NoScan",
                 [](Testimony& told) {
                   told.judging_particles.scan->at_fix.reset();
                 },
                 FixVerdict::kWeak},
        GateCase{"NobodyAskedTheLaser",
                 [](Testimony& told) { told.judging_particles.scan.reset(); },
                 FixVerdict::kWeak},
        GateCase{"EnoughBeams",
                 [](Testimony& told) {
                   told.AtFix().judged = told.options.min_judged_beams;
                 },
                 FixVerdict::kSure},
        GateCase{"TooFewBeams",
                 [](Testimony& told) {
                   told.AtFix().judged = told.options.min_judged_beams - 1;
                 },
                 FixVerdict::kWeak},
        // Few beams do not speak against it either.
        GateCase{"TooFewBeamsThatDoNotFit",
                 [](Testimony& told) {
                   told.AtFix() = {.explained = 0.1,
                                   .contradicted = 0.9,
                                   .judged = told.options.min_judged_beams - 1};
                 },
                 FixVerdict::kWeak},
        GateCase{"ExplainsEnoughToBeSure",
                 [](Testimony& told) {
                   told.AtFix().explained = told.options.sure_explained;
                 },
                 FixVerdict::kSure},
        GateCase{"ExplainsLess",
                 [](Testimony& told) {
                   told.AtFix().explained = told.options.sure_explained - 1e-9;
                 },
                 FixVerdict::kWeak},
        GateCase{"ExplainsJustEnough",
                 [](Testimony& told) {
                   told.AtFix().explained = told.options.min_explained;
                 },
                 FixVerdict::kWeak},
        GateCase{"ExplainsTooLittle",
                 [](Testimony& told) {
                   told.AtFix().explained = told.options.min_explained - 1e-9;
                 },
                 FixVerdict::kAgainstScan},
        GateCase{"ContradictsLittleEnoughToBeSure",
                 [](Testimony& told) {
                   told.AtFix().contradicted = told.options.sure_contradicted;
                 },
                 FixVerdict::kSure},
        GateCase{"ContradictsMore",
                 [](Testimony& told) {
                   told.AtFix().contradicted =
                       told.options.sure_contradicted + 1e-9;
                 },
                 FixVerdict::kWeak},
        GateCase{"ContradictsAsMuchAsItMay",
                 [](Testimony& told) {
                   told.AtFix().contradicted = told.options.max_contradicted;
                 },
                 FixVerdict::kWeak},
        GateCase{"ContradictsTooMuch",
                 [](Testimony& told) {
                   told.AtFix().contradicted =
                       told.options.max_contradicted + 1e-9;
                 },
                 FixVerdict::kAgainstScan},
        // A good scan does not make a loose_search answer sure.
        GateCase{"DoubtfulAnswerThatFits",
                 [](Testimony& told) { told.answer.confidence = 0.6; },
                 FixVerdict::kWeak},
        GateCase{"DoubtfulAnswerThatDoesNotFit",
                 [](Testimony& told) {
                   told.answer.confidence = 0.6;
                   told.AtFix().explained = 0.3;
                 },
                 FixVerdict::kAgainstScan}),
    NameOf);

// The scan's score at the fix is 0.80 - 0.05 = 0.75.
void FitsLess(Testimony& told, double explained_at_belief) {
  told.AtFix() = {.explained = 0.80, .contradicted = 0.05, .judged = 100};
  told.judging_particles.scan->at_belief = localization::ScanFit{
      .explained = explained_at_belief, .contradicted = 0, .judged = 100};
}

INSTANTIATE_TEST_SUITE_P(
    Belief, FixGateTable,
    testing::Values(GateCase{"FitsBetterThanWhereItThoughtItWas",
                             [](Testimony& told) { FitsLess(told, 0.5); },
                             FixVerdict::kSure},
                    GateCase{"FitsALittleWorse",
                             [](Testimony& told) { FitsLess(told, 0.82); },
                             FixVerdict::kSure},
                    GateCase{"FitsWorse",
                             [](Testimony& told) { FitsLess(told, 0.84); },
                             FixVerdict::kWeak},
                    GateCase{"FitsWorseByAsMuchAsItMay",
                             [](Testimony& told) { FitsLess(told, 0.99); },
                             FixVerdict::kWeak},
                    GateCase{"FitsMuchWorse",
                             [](Testimony& told) {
                               FitsLess(told, 0.99);
                               told.AtFix().explained = 0.75;
                               told.AtFix().contradicted = 0.08;
                             },
                             FixVerdict::kAgainstScan},
                    GateCase{"TooFewBeamsWhereItThoughtItWas",
                             [](Testimony& told) {
                               FitsLess(told, 0.99);
                               told.AtFix().explained = 0.75;
                               told.AtFix().contradicted = 0.08;
                               told.judging_particles.scan->at_belief->judged =
                                   told.options.min_judged_beams - 1;
                             },
                             FixVerdict::kSure}),
    NameOf);

TEST(FixGate, SaysWhy) {
  Testimony told = Sure();
  EXPECT_THAT(Judge(told).why, HasSubstr("explains 0.95 and contradicts 0.01"));
  told.judging_particles.ground->base_in_map.z = -0.5;
  EXPECT_EQ(Judge(told).why, "0.50 m below the ground");
  told.judging_particles.ground->ground_m.reset();
  EXPECT_EQ(Judge(told).why, "no room for the robot at 2.00, 3.00");
  told.judging_particles.tilt_error_rad = 0.5;
  EXPECT_THAT(Judge(told).why, HasSubstr("leans 28.6 degrees"));
  told.answer.confidence = 0.1;
  EXPECT_EQ(Judge(told).why, "0.10, needs 0.30");
  told.answer.localized = false;
  told.answer.reason = "TOO_FEW_INLIERS";
  EXPECT_EQ(Judge(told).why, "TOO_FEW_INLIERS");
}

TEST(FixGate, TiltIsTheAngleBetweenTwoIdeasOfUp) {
  const geometry::Rotation3 turned =
      geometry::Rotation3::FromAxisAngle({0, 0, 2});
  const geometry::Rotation3 leaning =
      geometry::Rotation3::FromAxisAngle({0.2, 0, 0});
  EXPECT_NEAR(TiltError_rad(turned, {}), 0, 1e-7);
  EXPECT_NEAR(TiltError_rad(turned * leaning, {}), 0.2, 1e-7);
  EXPECT_NEAR(TiltError_rad(turned * leaning, leaning), 0, 1e-7);
  EXPECT_NEAR(
      TiltError_rad(geometry::Rotation3::FromAxisAngle({3.1, 0, 0}), {}), 3.1,
      1e-7);
}

// A view of 0.9 at the origin, its camera turned by so much.
GatedFix View(double yaw_rad) {
  GatedFix fix;
  fix.verdict = FixVerdict::kWeak;
  fix.pose.map_from_base = {{1, 2}, yaw_rad};
  fix.motion.odom_from_base = {{0, 0}, yaw_rad};
  fix.covariance = FixCovariance({});
  fix.confidence = 0.9;
  fix.log_odds = LogOddsOf(0.9);
  return fix;
}

TEST(FixPairs, AgreeByTheWheelsBetweenThem) {
  const FixGateOptions options;
  const GatedFix first = View(0);
  GatedFix second = View(1);
  EXPECT_TRUE(FixesAgree(first, second, options));
  // The robot drove on, and the fix did not.
  second.motion.odom_from_base.translation = {0.31, 0};
  EXPECT_FALSE(FixesAgree(first, second, options));
  second.pose.map_from_base.translation = {1.31, 2};
  EXPECT_TRUE(FixesAgree(first, second, options));
}

TEST(FixPairs, MayDifferByTheirLimits) {
  const FixGateOptions options;
  const GatedFix first = View(0);
  const auto agrees = [&](const geometry::Rigid2& off, double height_m) {
    GatedFix second = View(0);
    second.pose.map_from_base = first.pose.map_from_base * off;
    second.pose.place.height_m = height_m;
    return FixesAgree(first, second, options);
  };
  const double m = options.pair_m;
  const double rad = options.pair_rad;
  EXPECT_TRUE(agrees({{m - 1e-6, 0}, 0}, 0));
  EXPECT_FALSE(agrees({{m + 1e-6, 0}, 0}, 0));
  EXPECT_TRUE(agrees({{0, 0}, rad - 1e-6}, 0));
  EXPECT_FALSE(agrees({{0, 0}, rad + 1e-6}, 0));
  EXPECT_TRUE(agrees({}, 0.79));
  EXPECT_FALSE(agrees({}, 0.81));
}

TEST(FixPairs, MayDifferMoreIfTheServerSaysSo) {
  const FixGateOptions options;
  const GatedFix first = View(0);
  GatedFix second = View(0);
  second.pose.map_from_base.translation = {1.5, 2};
  EXPECT_FALSE(FixesAgree(first, second, options));
  geometry::PoseCovariance wide{};
  wide[0] = 0.2 * 0.2;
  second.covariance = FixCovariance(wide);
  EXPECT_TRUE(FixesAgree(first, second, options));
  // What is not believed any more does not widen it either.
  wide[0] = 100;
  second.covariance = FixCovariance(wide);
  second.pose.map_from_base.translation = {2, 2};
  EXPECT_FALSE(FixesAgree(first, second, options));
}

TEST(FixPairs, ViewsOfOtherThingsAddUp) {
  EXPECT_FALSE(AreViewsSure(View(0)));
  EXPECT_FALSE(AreViewsSure(CombinedFix(View(0), View(0))));
  EXPECT_FALSE(AreViewsSure(CombinedFix(View(0), View(0.29))));
  EXPECT_FALSE(AreViewsSure(CombinedFix(View(0), View(0.6))));
  GatedFix loose_search = View(-0.6);
  loose_search.log_odds = LogOddsOf(0.6);
  // 2.2 + 2.2 + 0.4 from three directions.
  EXPECT_TRUE(
      AreViewsSure(CombinedFix(loose_search, CombinedFix(View(0), View(0.6)))));
}

TEST(FixPairs, AViewThatTheServerIsSureOfIsSure) {
  GatedFix sure = View(0);
  sure.is_server_sure = true;
  EXPECT_TRUE(AreViewsSure(CombinedFix(sure, View(0))));
  EXPECT_TRUE(AreViewsSure(CombinedFix(View(0), sure)));
}

TEST(FixPairs, TheLaterFixIsKept) {
  GatedFix later = View(0.1);
  later.pose.map_from_base.translation = {1.1, 2};
  EXPECT_EQ(CombinedFix(View(0), later).pose, later.pose);
}

TEST(FixCovariance, StaysWithinWhatAFixCanBeKnownTo) {
  geometry::PoseCovariance server{};
  server[7] = 0.2 * 0.2;
  server[35] = 100;
  const localization::PoseCovariance2 fix = FixCovariance(server);
  EXPECT_DOUBLE_EQ(fix[0], 0.08 * 0.08);
  EXPECT_DOUBLE_EQ(fix[4], 0.2 * 0.2);
  EXPECT_DOUBLE_EQ(fix[8], 0.15 * 0.15);
}

}  // namespace
}  // namespace treeline::behavior
