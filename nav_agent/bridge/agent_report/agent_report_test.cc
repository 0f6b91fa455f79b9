#include "nav_agent/bridge/agent_report/agent_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

namespace treeline::agent_report {
namespace {

using messages::DiagnosticStatus;
using ::testing::HasSubstr;

localization::TrackedPose Pose() {
  localization::TrackedPose pose;
  pose.pose = {.map_from_base = {{1, 2}, 0.5},
               .place = {.level = 1, .height_m = 3}};
  pose.covariance = {0.01, 0.02, 0.03, 0.02, 0.05, 0.06, 0.03, 0.06, 0.09};
  pose.level_from_base = geometry::Rotation3::FromAxisAngle({0, 0.1, 0});
  return pose;
}

std::map<std::string, DiagnosticStatus> ByName(
    const messages::DiagnosticArray& report) {
  std::map<std::string, DiagnosticStatus> by_name;
  for (const DiagnosticStatus& status : report.status) {
    by_name[status.name] = status;
  }
  return by_name;
}

TEST(AgentReportTest, APlaceIsOnItsGroundWithItsCovariance) {
  const messages::Header header = {.stamp = {7, 8}, .frame_id = "map"};
  const messages::PoseWithCovarianceStamped place = PlaceOf(Pose(), header);
  EXPECT_EQ(place.header, header);
  EXPECT_EQ(place.pose.pose.position, (messages::Point{1, 2, 3}));
  // Yaw and pitch as two rotations, one after the other.
  EXPECT_NEAR(place.pose.pose.orientation.z, std::sin(0.25) * std::cos(0.05),
              1e-9);
  EXPECT_NEAR(place.pose.pose.orientation.y, std::cos(0.25) * std::sin(0.05),
              1e-9);
  const auto& covariance = place.pose.covariance;
  EXPECT_EQ(covariance[0], 0.01);
  EXPECT_EQ(covariance[1], 0.02);
  EXPECT_EQ(covariance[5], 0.03);
  EXPECT_EQ(covariance[7], 0.05);
  EXPECT_EQ(covariance[11], 0.06);
  EXPECT_EQ(covariance[30], 0.03);
  EXPECT_EQ(covariance[35], 0.09);
  EXPECT_EQ(covariance[14], 0);
}

TEST(AgentReportTest, APathIsOfPosesInTheMap) {
  const messages::Header header = {.stamp = {7, 8}, .frame_id = "map"};
  const messages::Path path = PathOf({Pose().pose, {}}, header);
  ASSERT_EQ(path.poses.size(), 2U);
  EXPECT_EQ(path.header, header);
  EXPECT_EQ(path.poses[1].header, header);
  EXPECT_EQ(path.poses[0].pose.position, (messages::Point{1, 2, 3}));
  EXPECT_NEAR(path.poses[0].pose.orientation.z, std::sin(0.25), 1e-9);
}

TEST(AgentReportTest, DiagnosticsSayWhatIsWrong) {
  agent_service::AgentState state;
  auto report = ByName(ReportOf(state, {}, {1, 2}));
  EXPECT_EQ(report.at("treeline: navigation").level, DiagnosticStatus::kOk);
  EXPECT_EQ(report.at("treeline: localization").level,
            DiagnosticStatus::kStale);
  EXPECT_EQ(report.count("treeline: goal"), 0U);

  state.snapshot.mode = behavior::NavigatorMode::kSafeStop;
  state.snapshot.cause = core::NavigationCause::kLaserLost;
  state.snapshot.cause_text = "nothing usable from the laser for 0.40 s";
  state.snapshot.pose = Pose();
  state.snapshot.verdict.state = localization::LostState::kLost;
  state.snapshot.goal =
      behavior::GoalStatus{.state = behavior::GoalState::kFailed,
                           .cause = core::NavigationCause::kBlocked,
                           .why = "a box"};
  state.devices = {{"laser", "lost", "nothing usable on scan"},
                   {"base", "running", ""},
                   {"camera", "starting", ""}};
  const TopicFacts facts = {.delivered = 10,
                            .refused = 4,
                            .clock_jumps = 1,
                            .odometry_leaps = 2,
                            .is_clock_running = false};
  report = ByName(ReportOf(state, facts, {1, 2}));
  const DiagnosticStatus& navigation = report.at("treeline: navigation");
  EXPECT_EQ(navigation.level, DiagnosticStatus::kError);
  EXPECT_EQ(navigation.message,
            "safe_stop: nothing usable from the laser for 0.40 s");
  EXPECT_THAT(navigation.values,
              ::testing::Contains(messages::KeyValue{"cause", "laser_lost"}));
  EXPECT_EQ(report.at("treeline: localization").level,
            DiagnosticStatus::kError);
  EXPECT_EQ(report.at("treeline: goal").message, "failed: a box");
  EXPECT_EQ(report.at("treeline: goal").level, DiagnosticStatus::kError);
  EXPECT_THAT(report.at("treeline: topics").message, HasSubstr("/clock"));
  EXPECT_THAT(report.at("treeline: topics").values,
              ::testing::Contains(messages::KeyValue{"refused", "4"}));
  EXPECT_EQ(report.at("treeline: laser").level, DiagnosticStatus::kError);
  EXPECT_THAT(report.at("treeline: laser").message, HasSubstr("scan"));
  EXPECT_EQ(report.at("treeline: base").level, DiagnosticStatus::kOk);
  EXPECT_EQ(report.at("treeline: camera").level, DiagnosticStatus::kStale);
}

}  // namespace
}  // namespace treeline::agent_report
