#include "server/service/worker_pool.h"

#include <atomic>
#include <vector>

#include "absl/synchronization/notification.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/service/service_test_util.h"

namespace treeline {
namespace {

using ::testing::ElementsAre;

TEST(WorkerPool, RunsEveryTaskItTook) {
  std::atomic<int> ran{0};
  int taken = 0;
  const SteadyClock clock;
  {
    WorkerPool pool(4, 1000, clock);
    for (int i = 0; i < 1000; ++i) taken += pool.TrySubmit([&] { ++ran; });
  }
  EXPECT_EQ(taken, 1000);
  EXPECT_EQ(ran, 1000);
}

TEST(WorkerPool, OneWorkerKeepsTheOrder) {
  std::vector<int> order;
  const SteadyClock clock;
  {
    WorkerPool pool(1, 10, clock);
    for (int i = 0; i < 5; ++i) {
      ASSERT_TRUE(pool.TrySubmit([&order, i] { order.push_back(i); }));
    }
  }
  EXPECT_THAT(order, ElementsAre(0, 1, 2, 3, 4));
}

TEST(WorkerPool, TurnsAwayWhatDoesNotFitAndRunsTheRest) {
  const SteadyClock clock;
  absl::Notification started;
  absl::Notification go_on;
  std::atomic<int> ran{0};
  {
    WorkerPool pool(1, 2, clock);
    ASSERT_TRUE(pool.TrySubmit([&] {
      started.Notify();
      go_on.WaitForNotification();
    }));
    started.WaitForNotification();
    // The worker is busy, and the queue is empty: two fit.
    EXPECT_TRUE(pool.TrySubmit([&] { ++ran; }));
    EXPECT_TRUE(pool.TrySubmit([&] { ++ran; }));
    EXPECT_FALSE(pool.TrySubmit([&] { ran += 100; }));
    go_on.Notify();
  }
  EXPECT_EQ(ran, 2);
}

TEST(WorkerPool, EstimatesTheBacklogFromRecentTasks) {
  // Each look at the clock is 6 ms after the one before, so a task takes 6 ms.
  const SteppingClock clock(std::chrono::milliseconds(6));
  WorkerPool pool(1, 10, clock);
  EXPECT_EQ(pool.BacklogEstimate_ms(), 0);
  ASSERT_TRUE(pool.TrySubmit([] {}));
  absl::Notification started;
  absl::Notification go_on;
  ASSERT_TRUE(pool.TrySubmit([&] {
    started.Notify();
    go_on.WaitForNotification();
  }));
  started.WaitForNotification();
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(pool.TrySubmit([] {}));
  EXPECT_DOUBLE_EQ(pool.BacklogEstimate_ms(), 24);
  go_on.Notify();
}

}  // namespace
}  // namespace treeline
