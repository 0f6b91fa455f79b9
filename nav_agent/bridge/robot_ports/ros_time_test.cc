#include "nav_agent/bridge/robot_ports/ros_time.h"

#include <gtest/gtest.h>

#include "nav_agent/bridge/robot_ports/testing_ports.h"

namespace treeline::robot_ports {
namespace {

messages::Clock ClockAt(double seconds) {
  return {.clock = messages::TimeOf(static_cast<int64_t>(seconds * 1e9))};
}

double Since(base::MonotonicTime from, const RosTime& time) {
  return base::SecondsBetween(from, time.Now());
}

TEST(RosTimeTest, StampsOfTheSystemsClockAreInSteadyTime) {
  TestingTime testing;
  EXPECT_EQ(testing.time.Now(), testing.real.Now());
  const messages::Time stamp = testing.Stamp();
  EXPECT_EQ(testing.time.TimeOf(stamp), testing.real.Now());
  EXPECT_EQ(testing.time.StampOf(testing.real.Now()), stamp);
}

TEST(RosTimeTest, ASystemsClockThatIsSetChangesStampsAndNotTime) {
  TestingTime testing;
  testing.time.Watch();
  testing.real.Pass(1);
  testing.time.Watch();
  EXPECT_EQ(testing.time.jumps(), 0);
  testing.system_ahead_s -= 3600;
  testing.time.Watch();
  EXPECT_EQ(testing.time.jumps(), 1);
  EXPECT_EQ(testing.time.Now(), testing.real.Now());
  EXPECT_EQ(testing.time.TimeOf(testing.Stamp()), testing.real.Now());
  // A clock that is corrected slowly has not jumped.
  testing.system_ahead_s += 0.01;
  testing.time.Watch();
  EXPECT_EQ(testing.time.jumps(), 1);
}

TEST(RosTimeTest, AStampOfAnotherClockSaysWhatToDo) {
  const auto told = [](const RosTime& time, double seconds) {
    return std::string(time.CheckStamp(ClockAt(seconds).clock).message());
  };
  TestingTime testing;
  const double now_s = 1e-9 * static_cast<double>(testing.SystemNow());
  EXPECT_EQ(told(testing.time, now_s), "");
  EXPECT_EQ(told(testing.time, now_s - 9), "");
  EXPECT_EQ(told(testing.time, now_s + 20),
            "its stamp is more than 10 s ahead: in a simulation, set "
            "use_sim_time; else "
            "set the clocks of both machines (chrony)");
  EXPECT_EQ(told(testing.time, 0),
            "its stamp is 0: whoever publishes it must stamp it");
  ManualClock real;
  RosTime simulated(true, real, [] { return int64_t{0}; });
  EXPECT_EQ(told(simulated, 5000), "") << "nobody has told the time";
  simulated.Set(ClockAt(100));
  EXPECT_EQ(told(simulated, 105), "");
  EXPECT_EQ(told(simulated, 5000),
            "its stamp is hours ahead: whoever publishes it does not go by "
            "/clock (use_sim_time)");
  // What is left of before a clock was set back.
  simulated.Set(ClockAt(10));
  EXPECT_EQ(told(simulated, 11), "");
  EXPECT_NE(told(simulated, 100), "");
}

TEST(RosTimeTest, ASimulationsTimeIsCarriedOnToTheNextMessageAndNotBeyond) {
  ManualClock real;
  RosTime time(true, real, [] { return int64_t{0}; });
  EXPECT_FALSE(time.is_running());
  time.Set(ClockAt(100));
  const base::MonotonicTime begin = time.Now();
  real.Pass(0.05);
  EXPECT_EQ(Since(begin, time), 0) << "how fast it goes is not known yet";
  // Twice as fast as real time.
  time.Set(ClockAt(100.1));
  EXPECT_NEAR(Since(begin, time), 0.1, 1e-6);
  real.Pass(0.02);
  EXPECT_NEAR(Since(begin, time), 0.14, 1e-6);
  real.Pass(0.2);
  EXPECT_NEAR(Since(begin, time), 0.2, 1e-6);
  EXPECT_TRUE(time.is_running());
  // A message that says less than was told: time waits for it.
  time.Set(ClockAt(100.15));
  EXPECT_NEAR(Since(begin, time), 0.2, 1e-6);
  real.Pass(0.6);
  EXPECT_FALSE(time.is_running());
  EXPECT_EQ(time.jumps(), 0);
}

TEST(RosTimeTest, ASimulationThatBeginsAnewDoesNotTurnTimeBack) {
  ManualClock real;
  RosTime time(true, real, [] { return int64_t{0}; });
  time.Set(ClockAt(100));
  real.Pass(0.1);
  time.Set(ClockAt(100.1));
  const base::MonotonicTime before = time.Now();
  real.Pass(0.1);
  // Out of order.
  time.Set(ClockAt(100.05));
  EXPECT_EQ(time.jumps(), 0);
  time.Set(ClockAt(0));
  EXPECT_EQ(time.jumps(), 1);
  EXPECT_NEAR(Since(before, time), 0.1, 1e-6);
  // What is stamped now is of now.
  EXPECT_EQ(time.TimeOf(ClockAt(0).clock), time.Now());
  EXPECT_EQ(time.StampOf(time.Now()), ClockAt(0).clock);
}

TEST(RosTimeTest, TimeThatASimulationDidNotTellHasPassed) {
  ManualClock real;
  RosTime time(true, real, [] { return int64_t{0}; });
  time.Set(ClockAt(100));
  const base::MonotonicTime before = time.Now();
  real.Pass(8);
  time.Set(ClockAt(108));
  EXPECT_EQ(time.jumps(), 1);
  EXPECT_NEAR(Since(before, time), 8, 1e-6);
}

}  // namespace
}  // namespace treeline::robot_ports
