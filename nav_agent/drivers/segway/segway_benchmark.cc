// How long it takes to understand a base.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <span>
#include <vector>

#include "nav_agent/drivers/segway/segway_codec.h"
#include "nav_agent/drivers/segway/segway_protocol.h"

namespace treeline::segway {
namespace {

std::vector<uint8_t> CycleBytes(uint16_t index) {
  SegwayCycle cycle;
  cycle.servo_frames = index;
  cycle.left_position = 40 * index;
  cycle.mode = static_cast<uint16_t>(SegwayMode::kTractor);
  std::vector<uint8_t> bytes;
  for (const SegwayMessage& message : ToMessages(cycle, kSegwayChannelA)) {
    const SegwayFrame frame = EncodeFromBase(message);
    bytes.insert(bytes.end(), frame.begin(), frame.end());
  }
  return bytes;
}

// Frames out of a clean line, in pieces of 64 bytes as USB delivers them.
void BM_ParseFrames(benchmark::State& state) {
  std::vector<uint8_t> bytes;
  for (uint16_t i = 0; i < 100; ++i) {
    const auto cycle = CycleBytes(i);
    bytes.insert(bytes.end(), cycle.begin(), cycle.end());
  }
  SegwayFrameParser parser(SegwayDirection::kFromBase);
  for (auto _ : state) {
    for (size_t at = 0; at < bytes.size(); at += 64) {
      const size_t count = std::min<size_t>(64, bytes.size() - at);
      benchmark::DoNotOptimize(
          parser.Parse(std::span<const uint8_t>(bytes).subspan(at, count)));
    }
  }
  state.SetBytesProcessed(static_cast<int64_t>(state.iterations()) *
                          static_cast<int64_t>(bytes.size()));
}
BENCHMARK(BM_ParseFrames);

// The worst line: every byte may begin a frame.
void BM_ParseNoise(benchmark::State& state) {
  std::vector<uint8_t> bytes;
  for (int i = 0; i < 4800; ++i) {
    bytes.insert(bytes.end(), {0xF0, 0x55, 0xAA});
  }
  SegwayFrameParser parser(SegwayDirection::kFromBase);
  for (auto _ : state) benchmark::DoNotOptimize(parser.Parse(bytes));
  state.SetBytesProcessed(static_cast<int64_t>(state.iterations()) *
                          static_cast<int64_t>(bytes.size()));
}
BENCHMARK(BM_ParseNoise);

// A status cycle through the whole protocol, as 100 times a second.
void BM_Cycle(benchmark::State& state) {
  SegwayProtocol protocol({});
  base::MonotonicTime now{std::chrono::hours(1)};
  protocol.Connected(now);
  uint16_t index = 0;
  for (auto _ : state) {
    now += std::chrono::milliseconds(10);
    protocol.Receive(CycleBytes(index++), now);
    benchmark::DoNotOptimize(protocol.Send(now));
    benchmark::DoNotOptimize(protocol.TakeReadings());
  }
}
BENCHMARK(BM_Cycle);

}  // namespace
}  // namespace treeline::segway

BENCHMARK_MAIN();
