#include "nav_agent/service/docking_calls.h"

#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "absl/time/clock.h"
#include "common/base/file.h"
#include "gmock/gmock.h"
#include "nav_agent/service/testing_navigator.h"

namespace treeline::agent_service {
namespace {

using ::testing::HasSubstr;

class ListSink final : public MessageSink<v1::DockResponse> {
 public:
  bool Write(const v1::DockResponse& message) override {
    messages.push_back(message);
    return true;
  }
  bool IsGone() override { return is_gone; }
  std::vector<v1::DockResponse> messages;
  std::atomic<bool> is_gone = false;
};

v1::Dock Charger(const std::string& name = "charger") {
  v1::Dock dock;
  dock.set_name(name);
  dock.set_x_m(0.5);
  return dock;
}

class DockingCallsTest : public testing::Test {
 protected:
  absl::StatusOr<v1::PutDocksResponse> Put(const v1::Dock& dock,
                                           bool here = false) {
    v1::PutDocksRequest request;
    *request.add_docks() = dock;
    request.set_here(here);
    return calls.PutDocks(request);
  }
  absl::Status Dock(const std::string& name) {
    v1::DockRequest request;
    request.set_name(name);
    return calls.Dock(request, sink);
  }
  void TellPose(double x_m, double y_m) {
    ASSERT_TRUE(
        agent.commands.SetPose({.x_m = x_m, .y_m = y_m}, 0.1, 0.1).ok());
    // It is published.
    const auto state = agent.hub.Latest();
    agent.hub.WaitForNewer(state == nullptr ? 1 : state->number + 1,
                           absl::Now() + absl::Seconds(20));
  }

  SteppingAgent agent;
  DockingCalls calls{agent.commands, 2};
  ListSink sink;
};

TEST_F(DockingCallsTest, DocksAreKeptByNameWithTheDistanceThatTheRobotNeeds) {
  ASSERT_TRUE(Put(Charger()).ok());
  v1::Dock moved = Charger();
  moved.set_yaw_rad(0.5);
  moved.set_staging_m(0.5);
  const auto put = Put(moved);
  ASSERT_TRUE(put.ok()) << put.status();
  EXPECT_FALSE(put->survives_restart());
  ASSERT_TRUE(Put(Charger("another")).ok());
  const auto got = calls.GetDocks({});
  ASSERT_TRUE(got.ok());
  EXPECT_GT(got->revision(), put->revision());
  ASSERT_EQ(got->docks_size(), 2);
  EXPECT_EQ(got->docks(0).SerializeAsString(), moved.SerializeAsString());
  EXPECT_NEAR(got->docks(1).staging_m(),
              docking::DefaultStaging_m(agent.info.robot), 1e-9);
  v1::Dock inside = Charger("inside");
  inside.set_x_m(1.2);
  EXPECT_THAT(std::string(Put(inside).status().message()),
              HasSubstr("dock 'inside': its docked pose"));
  v1::RemoveDocksRequest remove;
  remove.add_names("charger");
  EXPECT_TRUE(calls.RemoveDocks(remove).ok());
  EXPECT_THAT(std::string(calls.RemoveDocks(remove).status().message()),
              HasSubstr("no dock is called 'charger'; there are: 'another'"));
  EXPECT_FALSE(calls.PutDocks({}).ok());
}

TEST_F(DockingCallsTest, ADockIsMadeWhereTheRobotStandsIfItKnows) {
  v1::Dock here = Charger();
  EXPECT_EQ(Put(here, true).status().code(),
            absl::StatusCode::kFailedPrecondition);
  TellPose(0.25, 0.5);
  const auto put = Put(here, true);
  ASSERT_TRUE(put.ok()) << put.status();
  EXPECT_EQ(calls.GetDocks({})->docks(0).x_m(), 0.25);
  EXPECT_EQ(calls.GetDocks({})->docks(0).y_m(), 0.5);
}

TEST_F(DockingCallsTest, WhatIsSeenFromADockStaysWithItsPlace) {
  ASSERT_TRUE(Put(Charger()).ok());
  DockBook& book = agent.commands.docks().book();
  docking::Dock looked = *book.Find("charger");
  looked.view = {{1, 2}};
  ASSERT_TRUE(book.Put({looked}).ok());
  // As the page sends it, which knows nothing of views.
  ASSERT_TRUE(Put(calls.GetDocks({})->docks(0)).ok());
  EXPECT_EQ(book.Find("charger")->view.size(), 1u);
  v1::Dock moved = Charger();
  moved.set_x_m(0.6);
  ASSERT_TRUE(Put(moved).ok());
  EXPECT_TRUE(book.Find("charger")->view.empty());
}

TEST_F(DockingCallsTest, TheRobotsContactsSayWhichEndGoesInFirst) {
  for (const core::ContactEnd end :
       {core::ContactEnd::kRear, core::ContactEnd::kFront}) {
    DockDesk desk(std::make_unique<DockBook>(agent.info.map), agent.info.robot,
                  {}, end);
    AgentCommands commands(agent.hub, agent.info, nullptr, nullptr, nullptr,
                           nullptr, &desk);
    DockingCalls with(commands, 2);
    v1::PutDocksRequest request;
    *request.add_docks() = Charger();
    const bool is_rear = end == core::ContactEnd::kRear;
    // Away from the wall that is ahead.
    if (is_rear) request.mutable_docks(0)->set_yaw_rad(std::numbers::pi);
    const auto put = with.PutDocks(request);
    ASSERT_TRUE(put.ok()) << put.status();
    EXPECT_EQ(with.GetDocks({})->docks(0).backward(), is_rear);
    request.mutable_docks(0)->set_backward(true);
    EXPECT_EQ(with.PutDocks(request).ok(), is_rear);
  }
}

TEST_F(DockingCallsTest, DockingIsToldOfUntilTheRobotStandsThere) {
  EXPECT_EQ(Dock("charger").code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(Dock("").code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(calls.Undock({}).status().code(),
            absl::StatusCode::kFailedPrecondition);
  ASSERT_TRUE(Put(Charger()).ok());
  TellPose(-0.9, 0.5);
  const absl::Status told = Dock("");
  ASSERT_TRUE(told.ok()) << told;
  ASSERT_FALSE(sink.messages.empty());
  const v1::DockingStatus& last = sink.messages.back().docking();
  EXPECT_TRUE(sink.messages.back().is_final());
  EXPECT_EQ(last.outcome(), v1::DOCKING_OUTCOME_SUCCEEDED)
      << last.ShortDebugString();
  EXPECT_EQ(last.state(), v1::DOCKING_STATE_DOCKED);
  EXPECT_EQ(last.dock(), "charger");
  EXPECT_TRUE(calls.Undock({}).ok());
}

TEST_F(DockingCallsTest, WhoGoesAwayCancelsIt) {
  ASSERT_TRUE(Put(Charger()).ok());
  agent.navigator.may_arrive = false;
  sink.is_gone = true;
  EXPECT_EQ(Dock("charger").code(), absl::StatusCode::kCancelled);
  for (int i = 0; i < 2000; ++i) {
    const auto state = agent.hub.Latest();
    if (state != nullptr &&
        state->docks.docking.outcome == docking::DockingOutcome::kCancelled) {
      return;
    }
    absl::SleepFor(absl::Milliseconds(10));
  }
  ADD_FAILURE() << "it is still under way";
}

TEST(DockBook, IsFoundAfterARestartAndNotLostInSilence) {
  const std::string folder = testing::TempDir() + "/docks";
  std::filesystem::remove_all(folder);
  const docking::Dock dock = {
      .name = "charger", .map_from_docked = {{0.5, 0}, 0}, .staging_m = 0.8};
  {
    auto book = DockBook::Open(TwoLevelMap(), folder);
    ASSERT_TRUE(book.ok()) << book.status();
    EXPECT_TRUE((*book)->keeping().ok());
    ASSERT_TRUE((*book)->Put({dock}).ok());
  }
  auto again = DockBook::Open(TwoLevelMap(), folder);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ((*again)->contents().things, std::vector<docking::Dock>{dock});
  const std::string text = *base::ReadFile(folder + "/docks");
  ASSERT_TRUE(
      base::WriteFileAtomically(folder + "/docks", text.substr(1)).ok());
  auto damaged = DockBook::Open(TwoLevelMap(), folder);
  EXPECT_EQ(damaged.status().code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(std::string(damaged.status().message()),
              HasSubstr("remove the file and set them up again"));
}

}  // namespace
}  // namespace treeline::agent_service
