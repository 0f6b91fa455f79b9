// The cost of fusion; figures: docs/research/octomap-fusion.md.
#include "benchmark/benchmark.h"
#include "nav_agent/fusion/octomap_builder.h"
#include "nav_agent/fusion/testing_views.h"

namespace treeline::fusion {
namespace {

constexpr int kViews = 16;

struct RoomViews {
  camera::Camera camera;
  std::vector<image::DepthImage> images;
  std::vector<geometry::Rigid3> poses;
};

// 640 x 480, turning about once in a room of 6 x 5 m.
const RoomViews& Views() {
  static const RoomViews views = [] {
    RoomViews made;
    for (int i = 0; i < kViews; ++i) {
      made.poses.push_back(LevelCamera({-1, 0.2, 1.1}, 6.28 * i / kViews));
      made.images.push_back(
          MakeRoomDepth(made.camera, made.poses.back(), uint64_t(i)));
    }
    return made;
  }();
  return views;
}

void BM_MakeDepthCloud(benchmark::State& state) {
  const RoomViews& views = Views();
  size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        MakeDepthCloud(views.images[i++ % kViews], views.camera, {})->hits);
  }
}
BENCHMARK(BM_MakeDepthCloud)->Unit(benchmark::kMillisecond);

OctomapBuilder BuildRoom() {
  const RoomViews& views = Views();
  OctomapBuilder builder = *OctomapBuilder::Make();
  for (size_t i = 0; i < kViews; ++i) {
    benchmark::DoNotOptimize(builder
                                 .InsertDepth(int64_t(i), views.images[i],
                                              views.camera, views.poses[i])
                                 .ok());
  }
  return builder;
}

// A whole insertion: cloud, rays, update. Views of a room that is known.
void BM_InsertDepth(benchmark::State& state) {
  const RoomViews& views = Views();
  OctomapBuilder builder = BuildRoom();
  int64_t id = kViews;
  for (auto _ : state) {
    const auto i = static_cast<size_t>(id % kViews);
    if (!builder
             .InsertDepth(id++, views.images[i], views.camera, views.poses[i])
             .ok()) {
      state.SkipWithError("a view was refused");
    }
  }
}
BENCHMARK(BM_InsertDepth)->Unit(benchmark::kMillisecond)->Iterations(200);

// Of 16 views.
void BM_SetPoses(benchmark::State& state) {
  OctomapBuilder builder = BuildRoom();
  const ViewPose pose{.id = 0, .map_from_sensor = Views().poses[0]};
  for (auto _ : state) {
    if (!builder.SetPoses({&pose, 1}).ok()) state.SkipWithError("refused");
  }
}
BENCHMARK(BM_SetPoses)->Unit(benchmark::kMillisecond);

void BM_Map(benchmark::State& state) {
  const OctomapBuilder builder = BuildRoom();
  for (auto _ : state) benchmark::DoNotOptimize(builder.Map()->words());
}
BENCHMARK(BM_Map)->Unit(benchmark::kMillisecond);

void BM_FormatOt(benchmark::State& state) {
  const OctomapBuilder builder = BuildRoom();
  for (auto _ : state) benchmark::DoNotOptimize(builder.FormatOt()->size());
}
BENCHMARK(BM_FormatOt)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace treeline::fusion

BENCHMARK_MAIN();
