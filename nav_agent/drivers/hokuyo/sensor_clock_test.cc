#include "nav_agent/drivers/hokuyo/sensor_clock.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/random.h"
#include "gtest/gtest.h"
#include "nav_agent/drivers/hokuyo/scip_codec.h"

namespace treeline::hokuyo {
namespace {

using std::chrono::milliseconds;

// A sensor whose clock began at first_ms when the host's said a day, and runs
// fast by drift_ppm.
struct Sensor {
  double first_ms = 5000;
  double drift_ppm = 0;

  static base::MonotonicTime Host(double elapsed_s) {
    return base::MonotonicTime() + std::chrono::hours(24) +
           std::chrono::duration_cast<base::MonotonicTime::duration>(
               std::chrono::duration<double>(elapsed_s));
  }
  int64_t Raw_ms(double elapsed_s) const {
    const double ms = first_ms + elapsed_s * 1e3 * (1 + drift_ppm * 1e-6);
    return static_cast<int64_t>(std::floor(ms)) % kScipTimeSpan_ms;
  }
};

// Twelve questions, each 0.4 to 3 ms on its way in either direction.
void Synchronise(SensorClock& clock, const Sensor& sensor, uint64_t seed) {
  base::Random random(seed, 0);
  double at_s = -1;
  for (int i = 0; i < 12; ++i) {
    const double there_s = random.NextUniform(0.0004, 0.003);
    const double back_s = random.NextUniform(0.0004, 0.003);
    clock.AddTimeReply(sensor.Raw_ms(at_s + there_s), Sensor::Host(at_s),
                       Sensor::Host(at_s + there_s + back_s));
    at_s += there_s + back_s + 0.0001;
  }
}

struct Errors {
  double worst_ms = 0;
  double mean_ms = 0;
};

// Of the stamps of scans at 40 Hz from begin_s to end_s, which arrive 19 to
// 24 ms after they began, and every tenth up to 200 ms later.
Errors ErrorsOf(SensorClock& clock, const Sensor& sensor, double begin_s,
                double end_s, uint64_t seed) {
  Errors errors;
  int count = 0;
  for (int k = static_cast<int>(begin_s * 40); k < end_s * 40; ++k) {
    base::Random random(seed, static_cast<uint64_t>(k));
    // The motor does not turn in step with the clock.
    const double start_s = k * 0.0250013;
    const double delay_s = random.NextUniform(0.019, 0.024) +
                           (k % 10 == 5 ? random.NextUniform(0, 0.2) : 0);
    const auto stamp = clock.HostTimeOfScan(sensor.Raw_ms(start_s),
                                            Sensor::Host(start_s + delay_s));
    if (!stamp) return {.worst_ms = 1e9, .mean_ms = 1e9};
    const double error_ms =
        base::MillisecondsBetween(Sensor::Host(start_s), *stamp);
    errors.worst_ms = std::max(errors.worst_ms, std::abs(error_ms));
    errors.mean_ms += error_ms;
    ++count;
  }
  errors.mean_ms /= count;
  return errors;
}

TEST(SensorClockTest, KnowsWhenScansWereInSpiteOfJitter) {
  for (const uint64_t seed : {1u, 2u, 3u, 4u, 5u}) {
    SensorClock clock(milliseconds(20));
    const Sensor sensor;
    Synchronise(clock, sensor, seed);
    const auto uncertainty = clock.SyncUncertainty();
    ASSERT_TRUE(uncertainty);
    EXPECT_LT(*uncertainty, std::chrono::microseconds(1500));
    const Errors errors = ErrorsOf(clock, sensor, 0, 20, seed);
    // Half a millisecond of rounding, what sync leaves open, and how much the
    // minimum of the first forty delays differs from that of 200 (5 ms / 40,
    // and the phase within a millisecond).
    EXPECT_LT(errors.worst_ms,
              0.5 + static_cast<double>(uncertainty->count()) * 1e-6 + 1.0);
  }
}

TEST(SensorClockTest, FollowsAClockThatRunsWrong) {
  for (const double drift_ppm : {-200.0, 200.0}) {
    SensorClock clock(milliseconds(20));
    const Sensor sensor = {.drift_ppm = drift_ppm};
    Synchronise(clock, sensor, 7);
    // After ten minutes it is wrong by 120 ms; the stamps by 5 s * 200 ppm
    // more than without drift.
    const Errors errors = ErrorsOf(clock, sensor, 0, 600, 7);
    EXPECT_LT(errors.worst_ms, 3.5) << drift_ppm;
  }
}

TEST(SensorClockTest, GoesOnWhereTheStampsBeginAgain) {
  SensorClock clock(milliseconds(20));
  const Sensor sensor = {.first_ms =
                             static_cast<double>(kScipTimeSpan_ms) - 3000.5};
  Synchronise(clock, sensor, 3);
  EXPECT_LT(ErrorsOf(clock, sensor, 0, 10, 3).worst_ms, 2.5);
}

TEST(SensorClockTest, SurvivesAPauseOfManyWraps) {
  SensorClock clock(milliseconds(20));
  const Sensor sensor;
  Synchronise(clock, sensor, 3);
  EXPECT_LT(ErrorsOf(clock, sensor, 0, 10, 3).worst_ms, 2.5);
  // A day later (5.15 wraps), after a second to find the least delay again.
  EXPECT_LT(ErrorsOf(clock, sensor, 86400, 86401, 3).worst_ms, 6);
  EXPECT_LT(ErrorsOf(clock, sensor, 86401, 86410, 3).worst_ms, 2.5);
}

TEST(SensorClockTest, WithoutTimeRepliesAssumesTheDelay) {
  SensorClock clock(milliseconds(20));
  EXPECT_EQ(clock.SyncUncertainty(), std::nullopt);
  const Errors errors = ErrorsOf(clock, {}, 1, 10, 3);
  // The least delay is 19 ms rather than 20, and found within the first
  // second only.
  EXPECT_LT(std::abs(errors.mean_ms), 2);
  EXPECT_LT(errors.worst_ms, 6);
}

TEST(SensorClockTest, NoticesThatTheSensorHasRestarted) {
  SensorClock clock(milliseconds(20));
  ASSERT_TRUE(clock.HostTimeOfScan(1'000'000, Sensor::Host(0)));
  ASSERT_TRUE(clock.HostTimeOfScan(1'000'025, Sensor::Host(0.025)));
  EXPECT_FALSE(clock.HostTimeOfScan(12, Sensor::Host(0.05)));
}

TEST(SensorClockTest, AStalledConnectionIsNoRestart) {
  SensorClock clock(milliseconds(20));
  ASSERT_TRUE(clock.HostTimeOfScan(1'000'000, Sensor::Host(0)));
  const auto stamp = clock.HostTimeOfScan(1'000'025, Sensor::Host(3));
  ASSERT_TRUE(stamp);
  EXPECT_NEAR(base::MillisecondsBetween(Sensor::Host(0), *stamp), 5, 1);
}

TEST(SensorClockTest, IgnoresTimeRepliesThatContradictEachOther) {
  SensorClock clock(milliseconds(20));
  clock.AddTimeReply(1000, Sensor::Host(0), Sensor::Host(0.001));
  clock.AddTimeReply(1500, Sensor::Host(0.01), Sensor::Host(0.011));
  EXPECT_EQ(clock.SyncUncertainty(), std::nullopt);
  const auto stamp = clock.HostTimeOfScan(1510, Sensor::Host(0.05));
  ASSERT_TRUE(stamp);
  EXPECT_NEAR(base::MillisecondsBetween(Sensor::Host(0), *stamp), 30, 1);
}

}  // namespace
}  // namespace treeline::hokuyo
