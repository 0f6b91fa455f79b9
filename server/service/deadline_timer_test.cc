#include "server/service/deadline_timer.h"

#include <atomic>
#include <vector>

#include "absl/synchronization/notification.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::service {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;

TEST(DeadlineTimer, ExpiresInTheOrderOfTheDeadlinesAndNotBefore) {
  DeadlineTimer timer;
  const base::MonotonicTime start = std::chrono::steady_clock::now();
  std::vector<int> order;
  absl::Notification last;
  timer.Arm(start + milliseconds(30), [&] {
    order.push_back(3);
    EXPECT_GE(std::chrono::steady_clock::now(), start + milliseconds(30));
    last.Notify();
  });
  timer.Arm(start + milliseconds(10), [&] { order.push_back(1); });
  timer.Arm(start + milliseconds(20), [&] { order.push_back(2); });
  last.WaitForNotification();
  EXPECT_THAT(order, ElementsAre(1, 2, 3));
}

TEST(DeadlineTimer, ADeadlineThatHasPassedExpiresAtOnce) {
  DeadlineTimer timer;
  absl::Notification expired;
  timer.Arm(base::MonotonicTime{}, [&] { expired.Notify(); });
  expired.WaitForNotification();
}

TEST(DeadlineTimer, WhatIsDisarmedDoesNotExpire) {
  DeadlineTimer timer;
  const base::MonotonicTime soon =
      std::chrono::steady_clock::now() + milliseconds(20);
  std::atomic<bool> wrong{false};
  const DeadlineTimer::Key key = timer.Arm(soon, [&] { wrong = true; });
  timer.Disarm(key);
  timer.Disarm(key);
  absl::Notification later;
  timer.Arm(soon + milliseconds(1), [&] { later.Notify(); });
  later.WaitForNotification();
  EXPECT_FALSE(wrong);
}

}  // namespace
}  // namespace treeline::service
