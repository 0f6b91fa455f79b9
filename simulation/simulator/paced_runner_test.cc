#include "simulation/simulator/paced_runner.h"

#include <limits>

#include "gtest/gtest.h"

namespace treeline::simulator {
namespace {

using std::chrono::milliseconds;

// Moves on by 10 ms each time somebody looks.
class TickingClock final : public base::Clock {
 public:
  base::MonotonicTime Now() const override {
    now_ += milliseconds(10);
    return now_;
  }

 private:
  mutable base::MonotonicTime now_{};
};

base::MonotonicTime At(int ms) { return base::MonotonicTime(milliseconds(ms)); }

TEST(Pace, FollowsRealTimeTimesItsFactor) {
  Pace pace(2);
  EXPECT_EQ(pace.Due(At(1000)), SimTime(0));
  EXPECT_EQ(pace.Due(At(1010)), milliseconds(20));
  // Too little to be worth it is not lost.
  EXPECT_EQ(pace.Due(At(1012)), SimTime(0));
  EXPECT_EQ(pace.Due(At(1020)), milliseconds(20));
  EXPECT_EQ(pace.Wait(At(1020)), SimTime(2'500'000));
}

TEST(Pace, FallsBehindRatherThanHurrying) {
  Pace pace(1);
  pace.Due(At(0));
  EXPECT_EQ(pace.Due(At(5000)), Pace::kMaxAtOnce);
  EXPECT_EQ(pace.Due(At(5001)), SimTime(0));
}

TEST(Pace, WithoutLimitThereIsAlwaysSomethingDue) {
  Pace pace(std::numeric_limits<double>::infinity());
  pace.Due(At(0));
  EXPECT_EQ(pace.Due(At(0)), Pace::kMaxAtOnce);
  EXPECT_EQ(pace.Wait(At(0)), SimTime(0));
}

TEST(PacedRunner, PausedItTakesOnlySingleSteps) {
  const TickingClock clock;
  std::stop_source stop;
  SimTime total{0};
  PacedRunner runner(
      [&](SimTime duration) {
        total += duration;
        if (total >= milliseconds(70)) stop.request_stop();
      },
      1, clock);
  runner.Pause();
  EXPECT_TRUE(runner.is_paused());
  runner.StepOnce(milliseconds(70));
  runner.Run(stop.get_token());
  EXPECT_EQ(total, milliseconds(70));
  EXPECT_EQ(runner.passed(), milliseconds(70));
}

TEST(PacedRunner, RunsUntilItIsStopped) {
  const TickingClock clock;
  std::stop_source stop;
  int steps = 0;
  PacedRunner runner(
      [&](SimTime) {
        if (++steps == 5) stop.request_stop();
      },
      1, clock);
  runner.Run(stop.get_token());
  EXPECT_EQ(steps, 5);
  EXPECT_GE(runner.passed(), milliseconds(50));
}

}  // namespace
}  // namespace treeline::simulator
