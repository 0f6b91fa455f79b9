// Reading full scans of a UTM-30LX-EW: 1081 steps, with and without
// intensities, in chunks as a network delivers them.
#include <string>

#include "benchmark/benchmark.h"
#include "nav_agent/drivers/hokuyo/scip_parser.h"
#include "nav_agent/drivers/hokuyo/scip_replies.h"
#include "nav_agent/drivers/hokuyo/testing_scip.h"
#include "nav_agent/drivers/stream/byte_stream.h"

namespace treeline::hokuyo {
namespace {

constexpr size_t kChunk = 1460;

void BM_ParseScan(benchmark::State& state, ScanContent content) {
  const ScanCommand command = FullScan(content);
  const std::string text = ScanText(command, ExampleScan(content));
  const auto bytes = stream::AsBytes(text);
  ScipParser parser;
  ScipScan scan;
  int64_t good = 0;
  for (auto _ : state) {
    for (size_t at = 0; at < bytes.size(); at += kChunk) {
      const size_t size = std::min(kChunk, bytes.size() - at);
      parser.Parse(bytes.subspan(at, size), [&](const ScipReply& reply) {
        good += DecodeScan(reply, command, scan).ok() ? 1 : 0;
      });
    }
    benchmark::DoNotOptimize(scan.codes.data());
  }
  if (good != state.iterations()) return state.SkipWithError("a broken scan");
  state.SetBytesProcessed(state.iterations() *
                          static_cast<int64_t>(text.size()));
  state.counters["bytes"] = static_cast<double>(text.size());
}
BENCHMARK_CAPTURE(BM_ParseScan, md, ScanContent::kDistance)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_ParseScan, me, ScanContent::kDistanceAndIntensity)
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace treeline::hokuyo

BENCHMARK_MAIN();
