// How long features take to be found and to be matched.
#include <benchmark/benchmark.h>

#include <vector>

#include "common/base/random.h"
#include "server/core/features/blob_picture.h"
#include "server/core/features/fast_sift.h"
#include "server/core/features/gray_pyramid.h"
#include "server/core/features/line_segment_detector.h"
#include "server/core/features/sift_extractor.h"
#include "server/core/features/sift_matching.h"

namespace treeline::features {
namespace {

// As many blobs as a cluttered room has features.
image::ColorImage Picture(int width) {
  const int height = width * 3 / 4;
  return PaintBlobs(RandomBlobs(width * height / 150, width, height), width,
                    height);
}

void BM_FastSift(benchmark::State& state) {
  const image::ColorImage picture = Picture(static_cast<int>(state.range(0)));
  FastSift sift;
  size_t count = 0;
  for (auto _ : state) count = sift.Extract(picture).size();
  state.counters["features"] = static_cast<double>(count);
}
BENCHMARK(BM_FastSift)
    ->Arg(320)
    ->Arg(640)
    ->Arg(1280)
    ->Arg(1920)
    ->Unit(benchmark::kMillisecond);

void BM_ExtractSift(benchmark::State& state) {
  const image::ColorImage picture = Picture(static_cast<int>(state.range(0)));
  SiftExtractor sift;
  size_t count = 0;
  for (auto _ : state) count = sift.Extract(picture, {}).size();
  state.counters["features"] = static_cast<double>(count);
}
BENCHMARK(BM_ExtractSift)->Arg(320)->Arg(640)->Unit(benchmark::kMillisecond);

void BM_FindLineSegments(benchmark::State& state) {
  GrayPyramid pyramid;
  pyramid.Assign(PlanarImage(Picture(static_cast<int>(state.range(0)))));
  size_t count = 0;
  for (auto _ : state) count = FindLineSegments(pyramid.level(0)).size();
  state.counters["segments"] = static_cast<double>(count);
}
BENCHMARK(BM_FindLineSegments)
    ->Arg(320)
    ->Arg(640)
    ->Unit(benchmark::kMillisecond);

void BM_FindNearestSift(benchmark::State& state) {
  base::Random random(1, 0);
  const auto draw = [&](size_t count) {
    std::vector<SiftDescriptor> descriptors(count);
    for (SiftDescriptor& d : descriptors) {
      for (uint8_t& v : d.values) {
        v = static_cast<uint8_t>(random.NextBelow(91));
      }
    }
    return descriptors;
  };
  const std::vector<SiftDescriptor> queries = draw(400);
  const std::vector<SiftDescriptor> known = draw(2000);
  std::vector<NearestSift> nearest(queries.size());
  for (auto _ : state) {
    FindNearestSift(queries,
                    {.data = known[0].values.data(), .size = known.size()},
                    nearest);
    benchmark::DoNotOptimize(nearest.data());
  }
}
BENCHMARK(BM_FindNearestSift)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace treeline::features

BENCHMARK_MAIN();
