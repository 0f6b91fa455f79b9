#include "common/base/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <numeric>
#include <thread>
#include <vector>

#include "absl/synchronization/mutex.h"
#include "absl/synchronization/notification.h"
#include "absl/time/time.h"
#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::base {
namespace {

using ::testing::Each;
using ::testing::ElementsAreArray;

TEST(ParallelFor, CallsEachIndexOnce) {
  for (int threads : {1, 2, 8}) {
    std::vector<std::atomic<int>> calls(1000);
    ParallelFor(1000, threads,
                [&](int64_t i) { ++calls[static_cast<size_t>(i)]; });
    std::vector<int> counts(calls.begin(), calls.end());
    EXPECT_THAT(counts, Each(1)) << threads << " threads";
  }
}

TEST(ParallelFor, GivesTheSameSlotsForAnyThreadCount) {
  const auto compute = [](int threads) {
    std::vector<double> slots(500);
    ParallelFor(500, threads, [&](int64_t i) {
      Random random(9, static_cast<uint64_t>(i));
      double sum = 0;
      for (int k = 0; k < 100; ++k) sum += random.NextGaussian();
      slots[static_cast<size_t>(i)] = sum;
    });
    return slots;
  };
  const std::vector<double> alone = compute(1);
  EXPECT_THAT(compute(2), ElementsAreArray(alone));
  EXPECT_THAT(compute(8), ElementsAreArray(alone));
}

TEST(ParallelFor, RunsOneThreadOnTheCallerInAscendingOrder) {
  std::vector<int64_t> order;
  std::vector<std::thread::id> ids;
  ParallelFor(50, 1, [&](int64_t i) {
    order.push_back(i);
    ids.push_back(std::this_thread::get_id());
  });
  std::vector<int64_t> ascending(50);
  std::iota(ascending.begin(), ascending.end(), 0);
  EXPECT_THAT(order, ElementsAreArray(ascending));
  EXPECT_THAT(ids, Each(std::this_thread::get_id()));
}

TEST(ParallelFor, RunsTwoBodiesAtTheSameTime) {
  // Each body waits for the other to have started.
  absl::Notification started[2];
  std::atomic<int> met{0};
  ParallelFor(2, 2, [&](int64_t i) {
    started[i].Notify();
    if (started[1 - i].WaitForNotificationWithTimeout(absl::Seconds(60))) ++met;
  });
  EXPECT_EQ(met, 2);
}

TEST(ParallelFor, UsesNoMoreThreadsThanItWasGiven) {
  absl::Mutex mutex;
  std::vector<std::thread::id> ids;
  ParallelFor(2000, 3, [&](int64_t) {
    absl::MutexLock lock(&mutex);
    const std::thread::id id = std::this_thread::get_id();
    if (std::find(ids.begin(), ids.end(), id) == ids.end()) ids.push_back(id);
  });
  EXPECT_LE(ids.size(), 3u);
}

TEST(ParallelFor, DoesNothingForAnEmptyRange) {
  for (int threads : {0, 1, 4}) {
    std::atomic<int> calls{0};
    ParallelFor(0, threads, [&](int64_t) { ++calls; });
    ParallelFor(-5, threads, [&](int64_t) { ++calls; });
    EXPECT_EQ(calls, 0);
  }
}

TEST(ParallelFor, TakesTheMachinesThreadsWhenNoneAreNamed) {
  std::atomic<int> calls{0};
  ParallelFor(10, 0, [&](int64_t) { ++calls; });
  EXPECT_EQ(calls, 10);
}

TEST(ParallelFor, MayBeNested) {
  std::atomic<int> calls{0};
  ParallelFor(4, 2,
              [&](int64_t) { ParallelFor(5, 2, [&](int64_t) { ++calls; }); });
  EXPECT_EQ(calls, 20);
}

TEST(HardwareThreads, IsAtLeastOneAndAtMostTheMachines) {
  EXPECT_GE(HardwareThreads(), 1);
  EXPECT_LE(HardwareThreads(),
            static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace
}  // namespace treeline::base
