#include "nav_agent/behavior/planner_worker.h"

#include <thread>
#include <utility>

#include "absl/synchronization/notification.h"
#include "gtest/gtest.h"

namespace treeline::behavior {
namespace {

// Plans when it is let; gives up when it is told to stop.
class GatedPlanner final : public planning::GlobalPlanner {
 public:
  absl::StatusOr<planning::PlanResult> Plan(
      const planning::PlanRequest& request,
      const planning::PlanBudget& /*budget*/,
      const std::stop_token& stop) const override {
    if (request.seed == 1) {
      begun->Notify();
      while (!stop.stop_requested()) std::this_thread::yield();
      gave_up->Notify();
      return absl::CancelledError("stopped");
    }
    planning::PlanResult result;
    result.length_m = static_cast<double>(request.seed);
    return result;
  }
  absl::Notification* begun = nullptr;
  absl::Notification* gave_up = nullptr;
};

planning::PlanRequest WithSeed(uint64_t seed) {
  planning::PlanRequest request;
  request.seed = seed;
  return request;
}

absl::StatusOr<planning::PlanResult> WaitFor(PlannerWorker& runner) {
  while (true) {
    if (auto result = runner.Take()) return *std::move(result);
    std::this_thread::yield();
  }
}

TEST(PlannerWorker, InlineHasTheResultAtOnce) {
  auto runner = MakeInlinePlannerWorker(std::make_unique<GatedPlanner>());
  EXPECT_FALSE(runner->IsBusy());
  EXPECT_FALSE(runner->Take().has_value());
  runner->Start(WithSeed(7), {});
  EXPECT_TRUE(runner->IsBusy());
  EXPECT_EQ((*runner->Take())->length_m, 7);
  EXPECT_FALSE(runner->IsBusy());
  runner->Start(WithSeed(7), {});
  runner->Cancel();
  EXPECT_FALSE(runner->Take().has_value());
}

TEST(PlannerWorker, AThreadPlansAndHandsOver) {
  auto runner = MakeThreadPlannerWorker(std::make_unique<GatedPlanner>());
  runner->Start(WithSeed(3), {});
  EXPECT_EQ(WaitFor(*runner)->length_m, 3);
  EXPECT_FALSE(runner->IsBusy());
}

TEST(PlannerWorker, ANewPlanReplacesTheOneThatIsBeingMade) {
  absl::Notification begun;
  absl::Notification gave_up;
  auto planner = std::make_unique<GatedPlanner>();
  planner->begun = &begun;
  planner->gave_up = &gave_up;
  auto runner = MakeThreadPlannerWorker(std::move(planner));
  runner->Start(WithSeed(1), {});
  begun.WaitForNotification();
  EXPECT_FALSE(runner->Take().has_value());
  EXPECT_TRUE(runner->IsBusy());
  runner->Start(WithSeed(5), {});
  EXPECT_EQ(WaitFor(*runner)->length_m, 5);
  EXPECT_TRUE(gave_up.HasBeenNotified());
}

// Takes as long as it is told, whatever the machine does meanwhile.
class SlowPlanner final : public planning::GlobalPlanner {
 public:
  absl::StatusOr<planning::PlanResult> Plan(
      const planning::PlanRequest& request,
      const planning::PlanBudget& /*budget*/,
      const std::stop_token& /*stop*/) const override {
    if (request.seed == 2) may_end->WaitForNotification();
    planning::PlanResult result;
    result.length_m = static_cast<double>(request.seed);
    return result;
  }
  absl::Notification* may_end = nullptr;
};

TEST(PlannerWorker, SteppedHandsOverExactlyThenAndNotBefore) {
  auto runner =
      MakeSteppedPlannerWorker(std::make_unique<SlowPlanner>(), 3, 25);
  for (uint64_t seed = 10; seed < 200; ++seed) {
    runner->BeginStep();
    runner->Start(WithSeed(seed), {});
    for (int step = 1; step < 3; ++step) {
      EXPECT_FALSE(runner->Take().has_value());
      EXPECT_TRUE(runner->IsBusy());
      runner->BeginStep();
    }
    EXPECT_FALSE(runner->Take().has_value());
    runner->BeginStep();
    const auto result = runner->Take();
    ASSERT_TRUE(result.has_value()) << seed;
    EXPECT_EQ((*result)->length_m, static_cast<double>(seed));
    EXPECT_FALSE(runner->Take().has_value());
    EXPECT_FALSE(runner->IsBusy());
  }
  EXPECT_EQ(runner->Tally().plans, 190);
}

TEST(PlannerWorker, SteppedWaitsForAPlanThatTakesLonger) {
  absl::Notification may_end;
  auto planner = std::make_unique<SlowPlanner>();
  planner->may_end = &may_end;
  auto runner = MakeSteppedPlannerWorker(std::move(planner), 1, 25);
  runner->Start(WithSeed(2), {});
  EXPECT_FALSE(runner->Take().has_value());
  runner->BeginStep();
  std::jthread other([&may_end] { may_end.Notify(); });
  const auto result = runner->Take();
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ((*result)->length_m, 2);
}

TEST(PlannerWorker, SteppedCountsPlansThatTakeLongerThanTheirSteps) {
  // No plan takes less processor time than none.
  auto late = MakeSteppedPlannerWorker(std::make_unique<SlowPlanner>(), 1, -1);
  auto in_time =
      MakeSteppedPlannerWorker(std::make_unique<SlowPlanner>(), 1, 1e9);
  for (PlannerWorker* runner : {late.get(), in_time.get()}) {
    runner->Start(WithSeed(10), {});
    runner->BeginStep();
    ASSERT_TRUE(runner->Take().has_value());
  }
  EXPECT_EQ(late->Tally().late, 1);
  EXPECT_EQ(in_time->Tally().late, 0);
}

TEST(PlannerWorker, SteppedCancelLeavesNothingBehind) {
  auto runner =
      MakeSteppedPlannerWorker(std::make_unique<SlowPlanner>(), 2, 25);
  runner->Start(WithSeed(10), {});
  runner->BeginStep();
  runner->Cancel();
  EXPECT_FALSE(runner->IsBusy());
  runner->BeginStep();
  runner->BeginStep();
  EXPECT_FALSE(runner->Take().has_value());
}

TEST(PlannerWorker, EndsWhileAPlanIsBeingMade) {
  absl::Notification begun;
  absl::Notification gave_up;
  auto planner = std::make_unique<GatedPlanner>();
  planner->begun = &begun;
  planner->gave_up = &gave_up;
  auto runner = MakeThreadPlannerWorker(std::move(planner));
  runner->Start(WithSeed(1), {});
  begun.WaitForNotification();
  runner.reset();
  EXPECT_TRUE(gave_up.HasBeenNotified());
}

}  // namespace
}  // namespace treeline::behavior
