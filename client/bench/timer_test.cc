#include "client/bench/timer.h"

#include <chrono>
#include <vector>

#include "absl/synchronization/mutex.h"
#include "absl/synchronization/notification.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::bench {
namespace {

using ::testing::ElementsAre;

TEST(Timer, ActionsComeInTheOrderOfTheirTimes) {
  const base::MonotonicTime start = base::SteadyClock().Now();
  absl::Notification done;
  std::vector<int> order;  // of the timer's thread, until `done`
  Timer timer;
  timer.At(start + std::chrono::milliseconds(30), [&] {
    order.push_back(3);
    done.Notify();
  });
  timer.At(start + std::chrono::milliseconds(20), [&] { order.push_back(2); });
  timer.At(start, [&] { order.push_back(1); });
  done.WaitForNotification();
  EXPECT_GE(base::SteadyClock().Now() - start, std::chrono::milliseconds(30));
  EXPECT_THAT(order, ElementsAre(1, 2, 3));
}

TEST(Timer, WhatIsNotDueIsDropped) {
  bool ran = false;
  {
    Timer timer;
    timer.At(base::SteadyClock().Now() + std::chrono::hours(1),
             [&] { ran = true; });
  }
  EXPECT_FALSE(ran);
}

}  // namespace
}  // namespace treeline::bench
