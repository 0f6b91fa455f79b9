// How long it takes to tell scenes apart.
#include <benchmark/benchmark.h>

#include <string>

#include "common/base/random.h"
#include "server/core/recognition/appearance_words.h"
#include "server/core/recognition/scene_index.h"

namespace treeline::recognition {
namespace {

// Tiles: as many corners as an image may have.
image::ColorImage Picture(int width, int height) {
  image::ColorImage image{width, height, {}};
  const int tile = width / 40;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      base::Random random(1, static_cast<uint64_t>(y / tile * 1000 + x / tile));
      for (int c = 0; c < 3; ++c) {
        image.rgb.push_back(static_cast<uint8_t>(random.NextBelow(256)));
      }
    }
  }
  return image;
}

void BM_AppearanceWords(benchmark::State& state) {
  const int width = static_cast<int>(state.range(0));
  const image::ColorImage image = Picture(width, width * 3 / 4);
  AppearanceWords words;
  size_t count = 0;
  for (auto _ : state) count = words.Extract(image).size();
  state.counters["words"] = static_cast<double>(count);
}
BENCHMARK(BM_AppearanceWords)
    ->Arg(640)
    ->Arg(1280)
    ->Arg(1920)
    ->Unit(benchmark::kMicrosecond);

// Scenes with a seventh of all words each, as rooms of 270 frames have.
SceneDescriptor RandomScene(uint64_t seed) {
  base::Random random(seed, 0);
  std::vector<uint32_t> words(kWords / 7);
  for (uint32_t& word : words) word = random.NextBelow(kWords);
  SceneDescriptor descriptor;
  descriptor.Add(words);
  return descriptor;
}

void BM_Rank(benchmark::State& state) {
  SceneIndex index;
  for (int64_t s = 0; s < state.range(0); ++s) {
    index.Set(std::to_string(s), RandomScene(static_cast<uint64_t>(s)));
  }
  AppearanceWords extractor;
  const std::vector<uint32_t> words = extractor.Extract(Picture(640, 480));
  for (auto _ : state) benchmark::DoNotOptimize(index.RankWords(words));
  state.counters["words"] = static_cast<double>(words.size());
}
BENCHMARK(BM_Rank)->Arg(16)->Arg(64)->Arg(256)->Arg(512)->Unit(
    benchmark::kMicrosecond);

void BM_SetScene(benchmark::State& state) {
  SceneIndex index;
  const SceneDescriptor scene = RandomScene(1);
  for (auto _ : state) index.Set("scene", scene);
}
BENCHMARK(BM_SetScene)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace treeline::recognition

BENCHMARK_MAIN();
