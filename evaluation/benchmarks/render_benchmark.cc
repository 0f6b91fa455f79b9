// RGB-D frames of worlds, from pose to encoded files.
#include "benchmark/benchmark.h"
#include "common/base/parallel_for.h"
#include "common/image/decode.h"
#include "simulation/recorder/tour_walk.h"
#include "simulation/recorder/walk.h"
#include "simulation/sensors/synthetic_camera.h"

namespace treeline::benchmarks {
namespace {

const renderer::Renderer& RoomRenderer() {
  static const renderer::Renderer& renderer =
      *renderer::Renderer::Create(*worlds::MakeWorld("room", {}), 0)->release();
  return renderer;
}

sensors::SyntheticCamera RoomCamera() {
  const std::shared_ptr<const renderer::Renderer> renderer(
      &RoomRenderer(), [](const renderer::Renderer*) {});
  return *sensors::SyntheticCamera::Create(renderer, {});
}

// Frames a second of a live camera: one at a time, on all threads.
void BM_Capture(benchmark::State& state) {
  const sensors::SyntheticCamera camera = RoomCamera();
  const recorder::Walk walk(RoomRenderer().world().walk_area, 0);
  uint64_t frame = 0;
  for (auto _ : state) {
    const image::Frame captured =
        camera.Capture(walk.WorldFromCameraAt(static_cast<double>(frame)),
                       frame, static_cast<int>(state.range(0)));
    benchmark::DoNotOptimize(captured.color.rgb.data());
    ++frame;
  }
  state.counters["frames/s"] = benchmark::Counter(static_cast<double>(frame),
                                                  benchmark::Counter::kIsRate);
}
BENCHMARK(BM_Capture)
    ->Arg(1)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// The same in a building, with people about.
void CaptureCafe(benchmark::State& state, building::Lighting lighting) {
  const std::shared_ptr<const renderer::Renderer> renderer =
      *renderer::Renderer::Create(
          *worlds::MakeWorld("cafe", {.lighting = lighting}), 0);
  sensors::SyntheticCamera::Options options;
  options.color = sensors::ColorSensorFor(lighting);
  const sensors::SyntheticCamera camera =
      *sensors::SyntheticCamera::Create(renderer, options);
  const recorder::CameraPath path =
      *recorder::MakeCameraPath(renderer->world(), renderer->caster(), 0);
  uint64_t frame = 0;
  for (auto _ : state) {
    const double time_s = static_cast<double>(frame);
    const renderer::WorldSnapshot snapshot =
        renderer->caster().At(renderer->world().InstancesAt(time_s));
    const image::Frame captured = camera.Capture(
        snapshot, path(time_s), frame, static_cast<int>(state.range(0)));
    benchmark::DoNotOptimize(captured.color.rgb.data());
    ++frame;
  }
  state.counters["frames/s"] = benchmark::Counter(static_cast<double>(frame),
                                                  benchmark::Counter::kIsRate);
}
void BM_CaptureCafe(benchmark::State& state) {
  CaptureCafe(state, building::Lighting::kDay);
}
BENCHMARK(BM_CaptureCafe)
    ->Arg(1)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// With exposure, white balance and noise of each picture.
void BM_CaptureCafeInEvening(benchmark::State& state) {
  CaptureCafe(state, building::Lighting::kEvening);
}
BENCHMARK(BM_CaptureCafeInEvening)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// Light of a world, on all threads.
void BM_BakeLight(benchmark::State& state, const char* name,
                  building::Lighting lighting = building::Lighting::kDay) {
  const worlds::World world = *worlds::MakeWorld(name, {.lighting = lighting});
  for (auto _ : state) {
    benchmark::DoNotOptimize(*renderer::Renderer::Create(world, 0));
  }
}
BENCHMARK_CAPTURE(BM_BakeLight, room, "room")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(BM_BakeLight, room_in_the_sun, "room",
                  building::Lighting::kSunny)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(BM_BakeLight, office_floor, "office-floor")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// Frames a second of a recording: each thread has its own frame, encoded too.
void BM_CaptureAndEncode(benchmark::State& state) {
  constexpr int64_t kFrames = 16;
  const sensors::SyntheticCamera camera = RoomCamera();
  const recorder::Walk walk(RoomRenderer().world().walk_area, 0);
  for (auto _ : state) {
    base::ParallelFor(
        kFrames, static_cast<int>(state.range(0)), [&](int64_t i) {
          const image::Frame captured = camera.Capture(
              walk.WorldFromCameraAt(2.0 * static_cast<double>(i)),
              static_cast<uint64_t>(i), 1);
          benchmark::DoNotOptimize(
              image::EncodeJpeg(captured.color, 92)->size());
          benchmark::DoNotOptimize(
              image::EncodeDepthPng(*captured.depth)->size());
        });
  }
  state.counters["frames/s"] =
      benchmark::Counter(static_cast<double>(kFrames),
                         benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(BM_CaptureAndEncode)
    ->Arg(1)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace treeline::benchmarks

BENCHMARK_MAIN();
