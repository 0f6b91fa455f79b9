// Decoding one 640 x 480 RGB-D frame of the red kitchen (TREELINE_DATA).
#include <cstdlib>
#include <string>

#include "benchmark/benchmark.h"
#include "common/base/file.h"
#include "common/image/decode.h"

namespace treeline::image {
namespace {

std::string ReadFrameFile(const char* ending) {
  const char* data = std::getenv("TREELINE_DATA");
  const std::string path =
      std::string(data != nullptr ? data : "../shared/data") +
      "/7scenes-redkitchen/seq-01/frame-000120" + ending;
  auto bytes = base::ReadFile(path);
  return bytes.ok() ? *std::move(bytes) : std::string();
}

void BM_DecodeColorJpeg(benchmark::State& state) {
  const std::string bytes = ReadFrameFile(".color.jpg");
  if (bytes.empty()) return state.SkipWithError("no recording");
  for (auto _ : state) {
    auto image = DecodeColor(bytes);
    if (!image.ok()) return state.SkipWithError("does not decode");
    benchmark::DoNotOptimize(image->rgb.data());
  }
}
BENCHMARK(BM_DecodeColorJpeg)->Unit(benchmark::kMillisecond);

void BM_DecodeDepthPng(benchmark::State& state) {
  const std::string bytes = ReadFrameFile(".depth.png");
  if (bytes.empty()) return state.SkipWithError("no recording");
  for (auto _ : state) {
    auto image = DecodeDepthPng(bytes, 0.001);
    if (!image.ok()) return state.SkipWithError("does not decode");
    benchmark::DoNotOptimize(image->values.data());
  }
}
BENCHMARK(BM_DecodeDepthPng)->Unit(benchmark::kMillisecond);

void BM_EncodeDepthPng(benchmark::State& state) {
  const auto image = DecodeDepthPng(ReadFrameFile(".depth.png"), 0.001);
  if (!image.ok()) return state.SkipWithError("no recording");
  size_t size = 0;
  for (auto _ : state) {
    const auto bytes = EncodeDepthPng(*image);
    size = bytes->size();
    benchmark::DoNotOptimize(size);
  }
  state.counters["bytes"] = static_cast<double>(size);
}
BENCHMARK(BM_EncodeDepthPng)->Unit(benchmark::kMillisecond);

void BM_EncodeColorJpeg(benchmark::State& state) {
  const auto image = DecodeColor(ReadFrameFile(".color.jpg"));
  if (!image.ok()) return state.SkipWithError("no recording");
  size_t size = 0;
  for (auto _ : state) {
    const auto bytes = EncodeJpeg(*image, 92);
    size = bytes->size();
    benchmark::DoNotOptimize(size);
  }
  state.counters["bytes"] = static_cast<double>(size);
}
BENCHMARK(BM_EncodeColorJpeg)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace treeline::image

BENCHMARK_MAIN();
