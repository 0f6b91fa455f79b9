#include "server/service/worker_pool.h"

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/synchronization/notification.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/service/service_test_util.h"

namespace treeline::service {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using Verdict = WorkerPool::Verdict;

// One worker that is busy until it is let go, so that tests can fill the queue.
class WorkerPoolTest : public testing::Test {
 protected:
  void StartBusy(int queue, const base::Clock& clock) {
    pool_ = std::make_unique<WorkerPool>(1, queue, clock);
    ASSERT_EQ(pool_
                  ->Submit({.client = "first",
                            .run =
                                [this] {
                                  started_.Notify();
                                  go_on_.WaitForNotification();
                                }})
                  .verdict,
              Verdict::kAccepted);
    started_.WaitForNotification();
  }
  // A task that writes its name when it runs, and "-name" when it gives way.
  WorkerPool::Task Named(const std::string& client, const std::string& name) {
    return {.client = client,
            .kind = "room",
            .run = [this, name] { done_.push_back(name); },
            .give_way = [this, name] { done_.push_back("-" + name); }};
  }
  WorkerPool::Admission Submit(const std::string& client,
                               const std::string& name) {
    return pool_->Submit(Named(client, name));
  }
  // Lets the worker go and waits until nothing is left to do.
  void Finish() {
    go_on_.Notify();
    pool_.reset();
  }

  base::SteadyClock steady_;
  absl::Notification started_;
  absl::Notification go_on_;
  std::vector<std::string> done_;
  std::unique_ptr<WorkerPool> pool_;
};

TEST(WorkerPool, RunsEveryTaskItTook) {
  std::atomic<int> ran{0};
  int taken = 0;
  const base::SteadyClock clock;
  {
    WorkerPool pool(4, 1000, clock);
    for (int i = 0; i < 1000; ++i) {
      taken +=
          pool.Submit({.run = [&] { ++ran; }}).verdict == Verdict::kAccepted;
    }
  }
  EXPECT_EQ(taken, 1000);
  EXPECT_EQ(ran, 1000);
}

TEST_F(WorkerPoolTest, OneClientsTasksKeepTheirOrder) {
  StartBusy(10, steady_);
  for (const char* name : {"1", "2", "3"}) Submit("a", name);
  Finish();
  EXPECT_THAT(done_, ElementsAre("1", "2", "3"));
}

TEST_F(WorkerPoolTest, ClientsTakeTurns) {
  StartBusy(10, steady_);
  for (const char* name : {"a1", "a2", "a3", "a4"}) Submit("a", name);
  for (const char* name : {"b1", "b2"}) Submit("b", name);
  Submit("c", "c1");
  Finish();
  EXPECT_THAT(done_, ElementsAre("a1", "b1", "c1", "a2", "b2", "a3", "a4"));
}

TEST_F(WorkerPoolTest, AFullQueueTurnsAwayTheOneThatFilledIt) {
  StartBusy(2, steady_);
  Submit("a", "a1");
  Submit("a", "a2");
  const auto refused = Submit("a", "a3");
  EXPECT_EQ(refused.verdict, Verdict::kQueueFull);
  EXPECT_GE(refused.retry_after, milliseconds(10));
  EXPECT_LE(refused.retry_after, milliseconds(2000));
  Finish();
  EXPECT_THAT(done_, ElementsAre("a1", "a2"));
}

TEST_F(WorkerPoolTest, TheGreedyGiveWayToTheModest) {
  StartBusy(3, steady_);
  for (const char* name : {"a1", "a2", "a3"}) Submit("a", name);
  EXPECT_EQ(Submit("b", "b1").verdict, Verdict::kAccepted);
  EXPECT_THAT(done_, ElementsAre("-a3"));
  // Two of a, one of b: another of b would only turn the tables.
  EXPECT_EQ(Submit("b", "b2").verdict, Verdict::kQueueFull);
  Finish();
  EXPECT_THAT(done_, ElementsAre("-a3", "a1", "b1", "a2"));
}

TEST_F(WorkerPoolTest, WhatIsWithdrawnNeverRuns) {
  StartBusy(2, steady_);
  const auto first = Submit("a", "a1");
  Submit("a", "a2");
  EXPECT_TRUE(pool_->Withdraw(first.ticket));
  EXPECT_FALSE(pool_->Withdraw(first.ticket));
  EXPECT_EQ(pool_->queued(), 1);
  // Its place is free.
  EXPECT_EQ(Submit("a", "a3").verdict, Verdict::kAccepted);
  Finish();
  EXPECT_THAT(done_, ElementsAre("a2", "a3"));
}

TEST_F(WorkerPoolTest, CountsWhatWaitsAndRuns) {
  StartBusy(5, steady_);
  Submit("a", "a1");
  EXPECT_EQ(pool_->running(), 1);
  EXPECT_EQ(pool_->queued(), 1);
  EXPECT_EQ(pool_->workers(), 1);
  EXPECT_EQ(pool_->capacity(), 5);
  Finish();
}

// With a clock that moves 10 ms at each look, a task takes 10 ms.
TEST(WorkerPool, TurnsAwayWhatWouldEndTooLate) {
  SteppingClock clock(milliseconds(10));
  WorkerPool pool(1, 10, clock);
  absl::Notification learned;
  pool.Submit({.kind = "room", .run = [&] { learned.Notify(); }});
  learned.WaitForNotification();
  while (pool.running() > 0) std::this_thread::yield();
  absl::Notification started;
  absl::Notification go_on;
  pool.Submit({.kind = "room", .run = [&] {
                 started.Notify();
                 go_on.WaitForNotification();
               }});
  started.WaitForNotification();
  pool.Submit({.kind = "room", .run = [] {}});
  const auto submit = [&](milliseconds deadline) {
    return pool
        .Submit(
            {.kind = "room", .deadline = clock.Now() + deadline, .run = [] {}})
        .verdict;
  };
  // 10 ms pass at the look; half of what runs and what waits are 15 ms, with
  // their margin 18.75, and its own time is 20 with its margin.
  EXPECT_EQ(submit(milliseconds(48)), Verdict::kTooLate);
  EXPECT_EQ(submit(milliseconds(49)), Verdict::kAccepted);
  go_on.Notify();
}

TEST(WorkerPool, AFreeWorkerTriesWhatIsExpectedToTakeTooLong) {
  SteppingClock clock(milliseconds(1000));
  absl::Notification ran;
  WorkerPool pool(1, 10, clock);
  absl::Notification learned;
  pool.Submit({.run = [&] { learned.Notify(); }});
  learned.WaitForNotification();
  while (pool.running() > 0) std::this_thread::yield();
  EXPECT_EQ(pool.Submit({.deadline = clock.Now() + milliseconds(1001),
                         .run = [&] { ran.Notify(); }})
                .verdict,
            Verdict::kAccepted);
  ran.WaitForNotification();
  EXPECT_EQ(
      pool.Submit({.deadline = clock.Now() - milliseconds(1), .run = [] {}})
          .verdict,
      Verdict::kTooLate);
}

}  // namespace
}  // namespace treeline::service
