#include "nav_agent/drivers/segway/segway_codec.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::segway {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr double kDegree_rad = std::numbers::pi / 180;
using Bytes = std::vector<uint8_t>;

SegwayFrame MotionFrame(double forward_mps, double yaw_rate_radps,
                        const SegwayWire& wire = {}) {
  return EncodeToBase(ToMessage({.velocity_counts = static_cast<int16_t>(
                                     SegwayVelocityCounts(forward_mps)),
                                 .turn_counts = static_cast<int16_t>(
                                     SegwayTurnCounts(yaw_rate_radps, wire))},
                                wire));
}

// What it says differs from byte to byte and from number to number.
SegwayCycle SomeCycle() {
  return {.pitch = -78,
          .pitch_rate = 39,
          .roll = 156,
          .roll_rate = -8,
          .left_velocity = 401,
          .right_velocity = -802,
          .yaw_rate = 780,
          .servo_frames = 65000,
          .left_position = 0x12345678,
          .right_position = -40181,
          .forward_position = 0x0A0B0C0D,
          .turn_position = -117031,
          .left_torque = 1463,
          .right_torque = -1463,
          .mode = 1,
          .gain = 2,
          .ui_battery = 800,
          .base_battery = 290,
          .velocity_command = 200,
          .turn_command = -234};
}

// The frames of `count` cycles, one after another.
Bytes CycleBytes(int count) {
  Bytes bytes;
  for (int i = 0; i < count; ++i) {
    SegwayCycle cycle = SomeCycle();
    cycle.servo_frames = static_cast<uint16_t>(i);
    for (const SegwayMessage& message : ToMessages(cycle, kSegwayChannelA)) {
      const SegwayFrame frame = EncodeFromBase(message);
      bytes.insert(bytes.end(), frame.begin(), frame.end());
    }
  }
  return bytes;
}

std::vector<SegwayFrame> FramesOf(const Bytes& bytes) {
  return SegwayFrameParser(SegwayDirection::kFromBase).Parse(bytes);
}

TEST(SegwayCodec, GoldenStopFrame) {
  EXPECT_THAT(MotionFrame(0, 0), ElementsAre(0xF0, 0x55, 0, 0, 0, 0, 0x04, 0x13,
                                             0, 0, 0, 0, 0, 0, 0, 0, 0, 0xA3));
}

TEST(SegwayCodec, GoldenArcFrame) {
  EXPECT_THAT(MotionFrame(0.5, 30 * kDegree_rad),
              ElementsAre(0xF0, 0x55, 0, 0, 0, 0, 0x04, 0x13, 0, 0x00, 0xC8,
                          0x00, 0xEA, 0, 0, 0, 0, 0xEF));
}

// Worked out by hand from the rules: 0x402 >> 3 = 0x80, 0x402 << 5 = 0x40;
// -401 = 0xFE6F; 10 deg/s = 78 = 0x4E; sum F0+55+AA+80+40+01+91+FE+6F+4E+12+34
// = 0x542, 5 + 42 = 47, -47 = B9.
TEST(SegwayCodec, GoldenFrameOfTheBase) {
  SegwayCycle cycle;
  cycle.left_velocity = 401;
  cycle.right_velocity = -401;
  cycle.yaw_rate = 78;
  cycle.servo_frames = 0x1234;
  EXPECT_THAT(EncodeFromBase(ToMessages(cycle, kSegwayChannelA)[2]),
              ElementsAre(0xF0, 0x55, 0xAA, 0, 0x80, 0x40, 0, 0, 0, 0x01, 0x91,
                          0xFE, 0x6F, 0x00, 0x4E, 0x12, 0x34, 0xB9));
}

TEST(SegwayCodec, LongsComeLowWordFirst) {
  SegwayCycle cycle;
  cycle.left_position = 0x12345678;
  cycle.right_position = -2;
  EXPECT_THAT(ToMessages(cycle, kSegwayChannelB)[3].data,
              ElementsAre(0x56, 0x78, 0x12, 0x34, 0xFF, 0xFE, 0xFF, 0xFF));
}

TEST(SegwayCodec, SettingsRideOnMotions) {
  const SegwayMotion motion = {.velocity_counts = -5,
                               .turn_counts = 6,
                               .setting = SegwaySetting::kResetIntegrators,
                               .value = kSegwayAllIntegrators};
  const SegwayMessage message = ToMessage(motion, {.transmit_channel = 0xBB});
  EXPECT_EQ(message.channel, 0xBB);
  EXPECT_THAT(message.data, ElementsAre(0xFF, 0xFB, 0, 6, 0, 50, 0, 15));
  EXPECT_EQ(ToMotion(message), motion);
  EXPECT_EQ(ToMotion({.id = kSegwayShutDown}), std::nullopt);
}

TEST(SegwayCodec, MessagesSurviveTheirFrames) {
  const SegwayMessage message = {.channel = kSegwayChannelB,
                                 .id = 0x688,
                                 .data = {1, 2, 3, 4, 5, 6, 7, 8}};
  EXPECT_EQ(DecodeFromBase(EncodeFromBase(message)), message);
  EXPECT_EQ(DecodeToBase(EncodeToBase(message)), message);
}

TEST(SegwayCodec, CyclesSurviveTheirMessages) {
  SegwayCycle cycle;
  for (const SegwayMessage& message :
       ToMessages(SomeCycle(), kSegwayChannelA)) {
    ReadInto(message, cycle);
  }
  EXPECT_EQ(cycle, SomeCycle());
}

TEST(SegwayCodec, ReadingsAreInSiUnits) {
  const core::BaseReading reading =
      ToReading(SomeCycle(), {.yaw_rate_sign = -1, .roll_sign = -1});
  EXPECT_DOUBLE_EQ(reading.forward_mps, -0.5);
  EXPECT_DOUBLE_EQ(reading.yaw_rate_radps, -100 * kDegree_rad);
  EXPECT_DOUBLE_EQ(reading.pitch_rad, -10 * kDegree_rad);
  EXPECT_DOUBLE_EQ(reading.pitch_rate_radps, 5 * kDegree_rad);
  EXPECT_DOUBLE_EQ(reading.roll_rad, -20 * kDegree_rad);
  EXPECT_DOUBLE_EQ(reading.battery_v, 72.5);
  EXPECT_DOUBLE_EQ(SegwayUiBattery_v(SomeCycle()), 11.4);
}

TEST(SegwayCodec, TurnScalesAndSigns) {
  using enum SegwayWire::TurnScale;
  EXPECT_EQ(SegwayTurnCounts(1, {.turn_scale = kPerDegree}), 446);
  EXPECT_EQ(SegwayTurnCounts(1, {.turn_scale = kPerHalfTurn}), 325);
  EXPECT_EQ(SegwayTurnCounts(1, {.turn_scale = kPerDegree, .turn_sign = -1}),
            -446);
  for (const SegwayWire& wire :
       {SegwayWire{.turn_scale = kPerHalfTurn, .turn_sign = -1},
        SegwayWire{.turn_scale = kPerDegree}}) {
    EXPECT_NEAR(SegwayTurn_radps(SegwayTurnCounts(0.7, wire), wire), 0.7,
                1 / 325.0);
  }
}

TEST(SegwayCodec, NeverFasterThanAskedAndNeverBeyondTheWire) {
  for (double speed = -2.9; speed < 2.9; speed += 0.0137) {
    const double sent = SegwayVelocity_mps(SegwayVelocityCounts(speed));
    EXPECT_LE(std::abs(sent), std::abs(speed) + 1e-8);
    EXPECT_NEAR(sent, speed, 1 / kSegwayCountsPerMps);
  }
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(SegwayVelocityCounts(kInfinity), kSegwayMaxVelocityCounts);
  EXPECT_EQ(SegwayVelocityCounts(-1e300), -kSegwayMaxVelocityCounts);
  EXPECT_EQ(SegwayTurnCounts(kInfinity, {.turn_sign = -1}),
            -kSegwayMaxTurnCounts);
  EXPECT_EQ(SegwayVelocityCounts(std::nan("")), 0);
}

TEST(SegwayCodec, SignsThatAreNoneAreRefused) {
  EXPECT_TRUE(SegwayWire{}.Validate().ok());
  EXPECT_EQ(SegwayWire{.turn_sign = 0}.Validate().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(SegwayWire{.pitch_sign = 2}.Validate().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(SegwayFrameParser, EverySplitPoint) {
  const Bytes bytes = CycleBytes(2);
  const std::vector<SegwayFrame> expected = FramesOf(bytes);
  ASSERT_EQ(expected.size(), 16u);
  for (size_t split = 0; split <= bytes.size(); ++split) {
    SegwayFrameParser parser(SegwayDirection::kFromBase);
    const std::span<const uint8_t> all = bytes;
    std::vector<SegwayFrame> frames = parser.Parse(all.first(split));
    EXPECT_EQ(frames.size(), split / kSegwayFrameBytes);
    for (const SegwayFrame& frame : parser.Parse(all.subspan(split))) {
      frames.push_back(frame);
    }
    EXPECT_EQ(frames, expected) << split;
    EXPECT_EQ(parser.discarded_bytes(), 0);
  }
}

TEST(SegwayFrameParser, ByteByByte) {
  const Bytes bytes = CycleBytes(1);
  SegwayFrameParser parser(SegwayDirection::kFromBase);
  std::vector<SegwayFrame> frames;
  for (const uint8_t byte : bytes) {
    for (const SegwayFrame& frame : parser.Parse({&byte, 1})) {
      frames.push_back(frame);
    }
  }
  EXPECT_EQ(frames, FramesOf(bytes));
}

// 00 and FF are the same to the checksum; every other change of one byte costs
// the frame that it is in, and no other.
TEST(SegwayFrameParser, EveryCorruptByteCostsItsFrameAlone) {
  const Bytes bytes = CycleBytes(2);
  const std::vector<SegwayFrame> good = FramesOf(bytes);
  for (size_t at = 0; at < bytes.size(); ++at) {
    for (const int change : {0x01, 0x80, 0x5A}) {
      Bytes corrupt = bytes;
      corrupt[at] = static_cast<uint8_t>(corrupt[at] ^ change);
      SegwayFrameParser parser(SegwayDirection::kFromBase);
      std::vector<SegwayFrame> expected = good;
      expected.erase(expected.begin() +
                     static_cast<int>(at / kSegwayFrameBytes));
      EXPECT_EQ(parser.Parse(corrupt), expected) << at;
      EXPECT_EQ(parser.discarded_bytes(), 18) << at;
      EXPECT_EQ(parser.discarded_runs(), 1) << at;
    }
  }
}

TEST(SegwayFrameParser, ZeroAndFullBytesCannotBeToldApart) {
  Bytes bytes(CycleBytes(1));
  ASSERT_EQ(bytes[3], 0x00);
  bytes[3] = 0xFF;
  EXPECT_EQ(FramesOf(bytes).size(), 8u);
}

TEST(SegwayFrameParser, EveryDroppedByteCostsItsFrameAlone) {
  const Bytes bytes = CycleBytes(2);
  const std::vector<SegwayFrame> good = FramesOf(bytes);
  for (size_t at = 0; at < bytes.size(); ++at) {
    Bytes shorter = bytes;
    shorter.erase(shorter.begin() + static_cast<int>(at));
    std::vector<SegwayFrame> expected = good;
    expected.erase(expected.begin() + static_cast<int>(at / kSegwayFrameBytes));
    EXPECT_EQ(FramesOf(shorter), expected) << at;
  }
}

TEST(SegwayFrameParser, FindsFramesBetweenNoise) {
  base::Random random(/*seed=*/5, /*stream=*/0);
  const std::vector<SegwayFrame> good = FramesOf(CycleBytes(1));
  Bytes bytes;
  for (const SegwayFrame& frame : good) {
    // No F0: what begins a frame by chance may swallow the next one's start.
    for (int i = 0; i < 50; ++i) {
      bytes.push_back(static_cast<uint8_t>(random.NextBelow(0xF0)));
    }
    bytes.insert(bytes.end(), frame.begin(), frame.end());
  }
  SegwayFrameParser parser(SegwayDirection::kFromBase);
  EXPECT_EQ(parser.Parse(bytes), good);
  EXPECT_EQ(parser.discarded_bytes(), 8 * 50);
  EXPECT_EQ(parser.discarded_runs(), 8);
}

// A start within a frame's data, and a false start right before a frame.
TEST(SegwayFrameParser, StartsWithinFramesDoNotMislead) {
  const SegwayFrame frame =
      EncodeFromBase({.channel = kSegwayChannelA,
                      .id = 0x403,
                      .data = {0xF0, 0x55, 0xF0, 0x55, 0xF0, 0xF0, 0x55, 0}});
  Bytes bytes = {0xF0, 0xF0, 0x55};
  bytes.insert(bytes.end(), frame.begin(), frame.end());
  bytes.insert(bytes.end(), frame.begin() + 4, frame.end());
  bytes.insert(bytes.end(), frame.begin(), frame.end());
  EXPECT_EQ(FramesOf(bytes), (std::vector<SegwayFrame>{frame, frame}));
}

TEST(SegwayFrameParser, ResetForgetsAHalfFrame) {
  const Bytes bytes = CycleBytes(1);
  SegwayFrameParser parser(SegwayDirection::kFromBase);
  EXPECT_THAT(parser.Parse(std::span<const uint8_t>(bytes).first(17)),
              IsEmpty());
  parser.Reset();
  EXPECT_EQ(parser.Parse(bytes).size(), 8u);
  EXPECT_EQ(parser.discarded_bytes(), 0);
}

}  // namespace
}  // namespace treeline::segway
