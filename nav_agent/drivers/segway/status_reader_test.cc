#include "nav_agent/drivers/segway/status_reader.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::segway {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr double kCount_m = 1 / kSegwayCountsPerMetre;
const base::MonotonicTime kStart{std::chrono::hours(5)};

// A base at constant speed; its cycle i is measured at 10 i ms.
SegwayCycle CycleAt(int i) {
  SegwayCycle cycle;
  cycle.servo_frames = static_cast<uint16_t>(65530 + i);
  cycle.left_position =
      static_cast<int32_t>(0x7FFFFF00u + static_cast<uint32_t>(100 * i));
  cycle.right_position = -50 * i;
  cycle.mode = 1;
  return cycle;
}

class SegwayStatusReaderTest : public ::testing::Test {
 protected:
  std::optional<core::BaseReading> Take(const SegwayCycle& cycle,
                                        base::MonotonicTime arrival) {
    std::optional<core::BaseReading> result;
    for (const SegwayMessage& message : ToMessages(cycle, kSegwayChannelA)) {
      EXPECT_FALSE(result.has_value());
      result = reader_.Take(message, arrival);
    }
    return result;
  }

  static base::MonotonicTime TimeOf(int i) {
    return kStart + milliseconds(10 * i);
  }

  SegwayStatusReader reader_{{}, std::nullopt};
};

TEST_F(SegwayStatusReaderTest, OneReadingACycle) {
  for (int i = 0; i < 20; ++i) {
    const auto reading = Take(CycleAt(i), TimeOf(i));
    ASSERT_TRUE(reading.has_value()) << i;
    // On through the wrapping of positions and of the base's clock.
    EXPECT_DOUBLE_EQ(reading->left_wheel_m, 100 * i * kCount_m);
    EXPECT_DOUBLE_EQ(reading->right_wheel_m, -50 * i * kCount_m);
    EXPECT_EQ(reading->stamp, TimeOf(i));
  }
  EXPECT_EQ(reader_.incomplete_cycles(), 0);
  EXPECT_EQ(reader_.implausible_cycles(), 0);
}

TEST_F(SegwayStatusReaderTest, EveryMissingMessageCostsItsCycleAlone) {
  int i = 0;
  Take(CycleAt(i), TimeOf(i));
  for (size_t missing = 0; missing < 8; ++missing) {
    ++i;
    const auto messages = ToMessages(CycleAt(i), kSegwayChannelA);
    for (size_t m = 0; m < messages.size(); ++m) {
      if (m == missing) continue;
      EXPECT_FALSE(reader_.Take(messages[m], TimeOf(i)).has_value());
    }
    ++i;
    const auto reading = Take(CycleAt(i), TimeOf(i));
    ASSERT_TRUE(reading.has_value()) << missing;
    EXPECT_DOUBLE_EQ(reading->left_wheel_m, 100 * i * kCount_m);
    EXPECT_EQ(reader_.incomplete_cycles(), static_cast<int>(missing) + 1);
  }
}

TEST_F(SegwayStatusReaderTest, TwoHalvesOfDifferentCyclesAreNone) {
  const auto first = ToMessages(CycleAt(0), kSegwayChannelA);
  const auto second = ToMessages(CycleAt(1), kSegwayChannelA);
  for (size_t m = 0; m < 5; ++m) reader_.Take(first[m], kStart);
  for (size_t m = 2; m < 8; ++m) {
    EXPECT_FALSE(reader_.Take(second[m], kStart).has_value());
  }
  EXPECT_GT(reader_.incomplete_cycles(), 0);
}

// What waits in a buffer is stamped with when it was measured.
TEST_F(SegwayStatusReaderTest, LateArrivalsKeepTheirMoments) {
  Take(CycleAt(0), TimeOf(0));
  // A second of silence, then all at once.
  for (int i = 1; i <= 100; ++i) {
    const auto reading = Take(CycleAt(i), TimeOf(100));
    ASSERT_TRUE(reading.has_value());
    EXPECT_EQ(reading->stamp, TimeOf(i));
  }
}

TEST_F(SegwayStatusReaderTest, StampsFollowTheQuickestArrivals) {
  for (int i = 0; i < 300; ++i) {
    // From 1 to 15 ms late.
    const milliseconds late(1 + (i * 7) % 15);
    const auto reading = Take(CycleAt(i), TimeOf(i) + late);
    ASSERT_TRUE(reading.has_value());
    EXPECT_LE(reading->stamp, TimeOf(i) + late);
    // 15 cycles bring each lateness once.
    if (i >= 15) {
      EXPECT_EQ(reading->stamp, TimeOf(i) + milliseconds(1));
    }
  }
}

// A base whose clock is slow by a hundredth, which none is.
TEST_F(SegwayStatusReaderTest, StampsFollowAClockThatDrifts) {
  base::MonotonicTime before = kStart - milliseconds(1);
  for (int i = 0; i < 3000; ++i) {
    const base::MonotonicTime arrival = kStart + microseconds(10100 * i);
    const auto reading = Take(CycleAt(i), arrival);
    ASSERT_TRUE(reading.has_value());
    EXPECT_LE(reading->stamp, arrival);
    // The quickest arrival was up to two seconds ago.
    EXPECT_GE(reading->stamp, arrival - milliseconds(21));
    EXPECT_GE(reading->stamp, before);
    before = reading->stamp;
  }
}

// The first arrival of all was late: later ones are not put before it.
TEST_F(SegwayStatusReaderTest, StampsNeverRunBackwards) {
  Take(CycleAt(0), TimeOf(0) + milliseconds(90));
  base::MonotonicTime before = TimeOf(0) + milliseconds(90);
  for (int i = 1; i < 30; ++i) {
    const auto reading = Take(CycleAt(i), std::max(TimeOf(i), TimeOf(9)));
    ASSERT_TRUE(reading.has_value());
    EXPECT_GE(reading->stamp, before);
    before = reading->stamp;
  }
  EXPECT_EQ(before, TimeOf(29));
}

TEST_F(SegwayStatusReaderTest, ACorruptPositionIsLeftOut) {
  for (int i = 0; i < 5; ++i) Take(CycleAt(i), TimeOf(i));
  SegwayCycle corrupt = CycleAt(5);
  corrupt.right_position ^= 0xFF0000;
  EXPECT_FALSE(Take(corrupt, TimeOf(5)).has_value());
  const auto reading = Take(CycleAt(6), TimeOf(6));
  ASSERT_TRUE(reading.has_value());
  EXPECT_DOUBLE_EQ(reading->right_wheel_m, -300 * kCount_m);
  EXPECT_EQ(reader_.implausible_cycles(), 1);
}

TEST_F(SegwayStatusReaderTest, WheelsGoOnWhenTheBaseWasRestarted) {
  for (int i = 0; i <= 5; ++i) Take(CycleAt(i), TimeOf(i));
  // Off for 20 s; everything counts from zero again.
  reader_.Reconnected();
  const base::MonotonicTime restart = TimeOf(5) + std::chrono::seconds(20);
  SegwayCycle cycle;
  EXPECT_FALSE(Take(cycle, restart).has_value());
  for (int i = 1; i < 10; ++i) {
    cycle.servo_frames = static_cast<uint16_t>(i);
    cycle.left_position = 10 * i;
    const auto reading = Take(cycle, restart + milliseconds(10 * i));
    ASSERT_TRUE(reading.has_value());
    EXPECT_DOUBLE_EQ(reading->left_wheel_m, (500 + 10 * (i - 1)) * kCount_m);
    EXPECT_EQ(reading->stamp, restart + milliseconds(10 * i));
  }
}

TEST_F(SegwayStatusReaderTest, WheelsCountWhatRolledDuringAGap) {
  Take(CycleAt(0), TimeOf(0));
  reader_.Reconnected();
  // 20 minutes: the base's clock has wrapped once and most of another time.
  const int later = 120000;
  SegwayCycle cycle = CycleAt(later);
  cycle.left_position = CycleAt(0).left_position + 5;
  cycle.right_position = 7;
  const auto reading = Take(cycle, TimeOf(later));
  ASSERT_TRUE(reading.has_value());
  EXPECT_DOUBLE_EQ(reading->left_wheel_m, 5 * kCount_m);
  EXPECT_DOUBLE_EQ(reading->right_wheel_m, 7 * kCount_m);
}

TEST_F(SegwayStatusReaderTest, CountersThatAreResetDoNotMoveTheWheels) {
  Take(CycleAt(0), TimeOf(0));
  Take(CycleAt(1), TimeOf(1));
  reader_.CountersReset();
  SegwayCycle cycle = CycleAt(2);
  cycle.left_position = cycle.right_position = 0;
  const auto reading = Take(cycle, TimeOf(2));
  ASSERT_TRUE(reading.has_value());
  EXPECT_DOUBLE_EQ(reading->left_wheel_m, 100 * kCount_m);
}

TEST_F(SegwayStatusReaderTest, KeepsToOneOfTwoChannels) {
  // Both buses carry the cycles, a message from each in turn.
  int readings = 0;
  for (int i = 0; i < 10; ++i) {
    const auto a = ToMessages(CycleAt(i), kSegwayChannelA);
    const auto b = ToMessages(CycleAt(i), kSegwayChannelB);
    for (size_t m = 0; m < a.size(); ++m) {
      readings += reader_.Take(b[m], TimeOf(i)).has_value() ? 1 : 0;
      readings += reader_.Take(a[m], TimeOf(i)).has_value() ? 1 : 0;
    }
  }
  EXPECT_EQ(readings, 10);
  EXPECT_EQ(reader_.channel(), kSegwayChannelB);
  EXPECT_EQ(reader_.incomplete_cycles(), 0);
}

TEST_F(SegwayStatusReaderTest, HeedsTheChosenChannelAlone) {
  SegwayStatusReader reader({}, kSegwayChannelB);
  int readings = 0;
  for (const uint8_t channel : {kSegwayChannelA, kSegwayChannelB}) {
    for (const SegwayMessage& message : ToMessages(CycleAt(0), channel)) {
      readings += reader.Take(message, kStart).has_value() ? 1 : 0;
    }
  }
  EXPECT_EQ(readings, 1);
  EXPECT_EQ(reader.channel(), kSegwayChannelB);
}

}  // namespace
}  // namespace treeline::segway
