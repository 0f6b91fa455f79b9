// SIFT features of photographs: ours beside OpenCV's, of the same pictures, on
// one thread.
//
//   TREELINE_DATA   folder of the recordings; default ../shared/data
//
//   sift_benchmark --benchmark_min_time=1
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "benchmark/benchmark.h"
#include "common/dataset/dataset.h"
#include "evaluation/yardsticks/opencv_sift.h"
#include "server/core/features/fast_sift.h"
#include "server/core/features/sift_extractor.h"

namespace treeline::benchmarks {
namespace {

// Photographs spread over the training images of South Building.
constexpr int kPhotographs = 6;
constexpr const char* kNoData = "no South Building below TREELINE_DATA";

// Read once; empty if they are not there.
const std::vector<image::ColorImage>& Photographs() {
  static const auto* const photographs = [] {
    auto* read = new std::vector<image::ColorImage>;
    const char* data = std::getenv("TREELINE_DATA");
    const std::string folder =
        std::string(data != nullptr ? data : "../shared/data") +
        "/south-building";
    dataset::DatasetOptions options;
    options.uri = "colmap:" + folder + "/sparse," + folder + "/images";
    const auto dataset = dataset::Dataset::Open(options);
    if (!dataset.ok()) return read;
    for (int k = 0; k < kPhotographs; ++k) {
      auto frame = dataset->Load(k * dataset->size() / kPhotographs);
      if (frame.ok()) read->push_back(std::move(frame->color));
    }
    return read;
  }();
  return *photographs;
}

template <typename Extract>
void Time(benchmark::State& state, const Extract& extract) {
  const std::vector<image::ColorImage>& photographs = Photographs();
  if (photographs.empty()) return state.SkipWithError(kNoData);
  size_t k = 0;
  double features = 0;
  for (auto _ : state) {
    features += static_cast<double>(
        extract(photographs[k++ % photographs.size()]).size());
  }
  state.counters["features"] =
      benchmark::Counter(features, benchmark::Counter::kAvgIterations);
}

features::SiftOptions Most(const benchmark::State& state) {
  return {.max_features = static_cast<int>(state.range(0))};
}

void BM_OpenCvSift(benchmark::State& state) {
  Time(state, [&](const image::ColorImage& image) {
    return *yardsticks::ExtractOpenCvSift(image, Most(state));
  });
}
BENCHMARK(BM_OpenCvSift)->Arg(3000)->Unit(benchmark::kMillisecond);

// 0: all. Those that 3000 do not need take the doubled image.
void BM_Sift(benchmark::State& state) {
  features::SiftExtractor sift;
  Time(state, [&](const image::ColorImage& image) {
    return sift.Extract(image, Most(state));
  });
}
BENCHMARK(BM_Sift)->Arg(3000)->Arg(4000)->Arg(0)->Unit(benchmark::kMillisecond);

void BM_FastSift(benchmark::State& state) {
  features::FastSift sift;
  Time(state,
       [&](const image::ColorImage& image) { return sift.Extract(image); });
}
BENCHMARK(BM_FastSift)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace treeline::benchmarks

BENCHMARK_MAIN();
