#include "nav_agent/service/agent_hub.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "absl/synchronization/notification.h"
#include "nav_agent/service/testing_navigator.h"

namespace treeline::agent_service {
namespace {

using ::testing::ElementsAre;
using ::testing::SizeIs;

absl::Time Later() { return absl::Now() + absl::Seconds(60); }

TEST(AgentHub, RunsCommandsInTheSteppingThreadAndTellsTheirResults) {
  SteppingAgent agent;
  std::thread::id ran_in;
  const absl::Status result = agent.hub.Do([&](behavior::Navigator&) {
    ran_in = std::this_thread::get_id();
    return absl::NotFoundError("so it says");
  });
  EXPECT_EQ(result, absl::NotFoundError("so it says"));
  EXPECT_NE(ran_in, std::this_thread::get_id());
  EXPECT_NE(ran_in, std::thread::id());
}

TEST(AgentHub, ACommandThatNobodyTakesIsNotRunLater) {
  AgentHub hub({.patience = absl::Milliseconds(5)});
  bool ran = false;
  EXPECT_EQ(hub.Do([&](behavior::Navigator&) {
                 ran = true;
                 return absl::OkStatus();
               })
                .code(),
            absl::StatusCode::kDeadlineExceeded);
  FakeNavigator navigator;
  hub.RunCommands(navigator);
  EXPECT_FALSE(ran);
}

TEST(AgentHub, ACommandThatIsRunIsWaitedForWhateverItTakes) {
  AgentHub hub({.patience = absl::Milliseconds(1)});
  absl::Notification started;
  std::atomic<bool> done = false;
  std::jthread caller([&] {
    EXPECT_TRUE(hub.Do([&](behavior::Navigator&) {
                     started.Notify();
                     absl::SleepFor(absl::Milliseconds(20));
                     done = true;
                     return absl::OkStatus();
                   })
                    .ok() ||
                !done);
    // Whether it was taken or not: it does not run any more.
    EXPECT_EQ(started.HasBeenNotified(), done.load());
  });
  FakeNavigator navigator;
  for (int i = 0; i < 1000 && !started.HasBeenNotified(); ++i) {
    hub.RunCommands(navigator);
  }
}

TEST(AgentHub, WhatIsUrgentComesFirstHoweverManyWait) {
  AgentHub hub(
      {.max_commands = 2, .commands_in_step = 1, .patience = absl::Minutes(1)});
  FakeNavigator navigator;
  std::vector<std::string> ran;
  const auto note = [&ran](const std::string& what) {
    return [&ran, what](behavior::Navigator&) {
      ran.push_back(what);
      return absl::OkStatus();
    };
  };
  const auto call = [&](const std::string& what, bool is_urgent) {
    return std::jthread([&, what, is_urgent] {
      EXPECT_TRUE(hub.Do(note(what), is_urgent).ok());
    });
  };
  const std::jthread first = call("a", false);
  const std::jthread second = call("b", false);
  while (hub.waiting() < 2) absl::SleepFor(absl::Milliseconds(1));
  EXPECT_TRUE(absl::IsResourceExhausted(hub.Do(note("c"))));
  const std::jthread urgent = call("stop", true);
  while (hub.waiting() < 3) absl::SleepFor(absl::Milliseconds(1));
  hub.RunCommands(navigator);
  EXPECT_THAT(ran, ElementsAre("stop"));
  hub.RunCommands(navigator);
  hub.RunCommands(navigator);
  EXPECT_THAT(ran, SizeIs(3));
}

TEST(AgentHub, TheQueueIsBounded) {
  AgentHub hub({.max_commands = 2,
                .commands_in_step = 1,
                .patience = absl::Seconds(60)});
  std::vector<absl::Status> results(3);
  {
    std::vector<std::jthread> callers;
    for (absl::Status& result : results) {
      callers.emplace_back([&hub, &result] {
        result = hub.Do([](behavior::Navigator&) { return absl::OkStatus(); });
        // The one that found no room lets the others go.
        if (absl::IsResourceExhausted(result)) hub.Close();
      });
    }
  }
  std::vector<absl::StatusCode> codes;
  for (const absl::Status& result : results) codes.push_back(result.code());
  EXPECT_THAT(codes, ::testing::UnorderedElementsAre(
                         absl::StatusCode::kResourceExhausted,
                         absl::StatusCode::kUnavailable,
                         absl::StatusCode::kUnavailable));
}

TEST(AgentHub, AStepRunsAFewCommandsAtMost) {
  AgentHub hub({.max_commands = 8, .commands_in_step = 2});
  FakeNavigator navigator;
  std::atomic<int> run = 0;
  std::vector<std::jthread> callers;
  callers.reserve(3);
  for (int i = 0; i < 3; ++i) {
    callers.emplace_back([&] {
      EXPECT_TRUE(hub.Do([&](behavior::Navigator&) {
                       ++run;
                       return absl::OkStatus();
                     })
                      .ok());
    });
  }
  while (run < 3) {
    const int before = run;
    hub.RunCommands(navigator);
    EXPECT_LE(run - before, 2);
  }
}

TEST(AgentHub, PublishesNumberedStates) {
  AgentHub hub({});
  EXPECT_EQ(hub.Latest(), nullptr);
  hub.Publish({.time_s = 1});
  const auto first = hub.WaitForNewer(0, Later());
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first->number, 1U);
  EXPECT_EQ(hub.WaitForNewer(1, absl::Now()), nullptr);
  std::jthread publisher([&] { hub.Publish({.time_s = 2}); });
  const auto second = hub.WaitForNewer(1, Later());
  ASSERT_NE(second, nullptr);
  EXPECT_EQ(second->time_s, 2);
  // What was taken stays as it was.
  EXPECT_EQ(first->time_s, 1);
}

TEST(AgentHub, ClosingWakesWhoeverWaits) {
  AgentHub hub({.patience = absl::Seconds(60)});
  std::jthread waiter(
      [&] { EXPECT_EQ(hub.WaitForNewer(0, Later()), nullptr); });
  std::jthread caller([&] {
    EXPECT_TRUE(absl::IsUnavailable(
        hub.Do([](behavior::Navigator&) { return absl::OkStatus(); })));
  });
  hub.Close();
  EXPECT_TRUE(hub.is_closed());
}

TEST(AgentHub, KeepsTheNewestEvents) {
  AgentHub hub({.max_events = 3});
  for (int i = 1; i <= 5; ++i) hub.AddEvent(i, "goal", std::to_string(i));
  EXPECT_EQ(hub.last_event(), 5U);
  std::vector<uint64_t> numbers;
  for (const auto& event : hub.EventsAfter(0, 10)) {
    numbers.push_back(event.number);
  }
  EXPECT_THAT(numbers, ElementsAre(3, 4, 5));
  EXPECT_THAT(hub.EventsAfter(4, 10), SizeIs(1));
  EXPECT_THAT(hub.EventsAfter(0, 2), SizeIs(2));
  EXPECT_THAT(hub.EventsAfter(5, 2), SizeIs(0));
}

TEST(AgentHubOptions, AreChecked) {
  EXPECT_TRUE(AgentHubOptions().Validate().ok());
  EXPECT_FALSE(AgentHubOptions{.max_commands = 0}.Validate().ok());
  EXPECT_FALSE(AgentHubOptions{.commands_in_step = 65}.Validate().ok());
  EXPECT_FALSE(
      AgentHubOptions{.patience = absl::ZeroDuration()}.Validate().ok());
  EXPECT_FALSE(AgentHubOptions{.max_events = 0}.Validate().ok());
}

}  // namespace
}  // namespace treeline::agent_service
