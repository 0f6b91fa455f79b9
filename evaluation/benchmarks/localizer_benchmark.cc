// How long a query takes, stage by stage, beside OpenCV's SIFT extraction and
// the decoding of the same frames. Everything runs on one thread.
//
//   TREELINE_DATA             folder of the recordings; default ../shared/data
//   TREELINE_BENCHMARK_MODEL  model trained on the red kitchen's training
//                             frames; without it, what needs one is skipped
//
//   localizer_benchmark --benchmark_min_time=2
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "benchmark/benchmark.h"
#include "common/base/random.h"
#include "common/dataset/dataset.h"
#include "evaluation/yardsticks/opencv_threads.h"
#include "opencv2/core.hpp"
#include "opencv2/features2d.hpp"
#include "opencv2/imgproc.hpp"
#include "server/core/features/planar_image.h"
#include "server/core/features/rgbd_samples.h"
#include "server/core/features/walsh_hadamard.h"
#include "server/core/forest/backtracking.h"
#include "server/core/forest/model_file.h"
#include "server/core/localizer/localizer.h"
#include "server/core/pose/point_refinement.h"
#include "server/core/pose/point_solver.h"
#include "server/core/pose/preemptive_ransac.h"

namespace treeline::benchmarks {
namespace {

// Frames spread over the test list; every benchmark goes through all of them
// in turn.
constexpr int kFrames = 12;
constexpr const char* kNoData = "no recording below TREELINE_DATA";

struct Recording {
  std::optional<dataset::Dataset> dataset;
  std::vector<dataset::Dataset::Encoded> encoded;
  std::vector<image::Frame> frames;
};

// The frames, read once; empty if there is no recording.
const Recording& TestFrames() {
  static const Recording* const recording = [] {
    auto* r = new Recording;
    const char* data = std::getenv("TREELINE_DATA");
    const std::string folder =
        std::string(data != nullptr ? data : "../shared/data") +
        "/7scenes-redkitchen";
    dataset::DatasetOptions options;
    options.uri = "7scenes:" + folder;
    options.frame_list = folder + "/test.txt";
    absl::StatusOr<dataset::Dataset> dataset = dataset::Dataset::Open(options);
    if (!dataset.ok()) return r;
    r->dataset = *std::move(dataset);
    for (int k = 0; k < kFrames; ++k) {
      auto encoded = r->dataset->ReadEncoded(k * r->dataset->size() / kFrames);
      if (!encoded.ok()) continue;
      auto frame = r->dataset->Decode(*encoded);
      if (!frame.ok() || !frame->depth) continue;
      r->encoded.push_back(*std::move(encoded));
      r->frames.push_back(*std::move(frame));
    }
    return r;
  }();
  return *recording;
}

std::string ModelPath() {
  const char* path = std::getenv("TREELINE_BENCHMARK_MODEL");
  return path != nullptr ? path : "";
}

// Why there is no model to measure.
std::string NoModel(const absl::Status& status) {
  return "TREELINE_BENCHMARK_MODEL: " + std::string(status.message());
}

void BM_DecodeJpegAndPng(benchmark::State& state) {
  const Recording& recording = TestFrames();
  if (recording.frames.empty()) return state.SkipWithError(kNoData);
  size_t k = 0;
  for (auto _ : state) {
    const auto frame = recording.dataset->Decode(
        recording.encoded[k++ % recording.encoded.size()]);
    benchmark::DoNotOptimize(frame->color.rgb.data());
  }
}
BENCHMARK(BM_DecodeJpegAndPng)->Unit(benchmark::kMillisecond);

void BM_OpenCvSiftExtraction(benchmark::State& state) {
  const Recording& recording = TestFrames();
  if (recording.frames.empty()) return state.SkipWithError(kNoData);
  yardsticks::RunOpenCvOnCallingThread();
  std::vector<cv::Mat> grays;
  for (const image::Frame& frame : recording.frames) {
    const cv::Mat color(frame.color.height, frame.color.width, CV_8UC3,
                        const_cast<uint8_t*>(frame.color.rgb.data()));
    cv::cvtColor(color, grays.emplace_back(), cv::COLOR_RGB2GRAY);
  }
  const cv::Ptr<cv::SIFT> sift = cv::SIFT::create();
  size_t k = 0;
  double keypoints_found = 0;
  for (auto _ : state) {
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
    sift->detectAndCompute(grays[k++ % grays.size()], cv::noArray(), keypoints,
                           descriptors);
    keypoints_found += static_cast<double>(keypoints.size());
  }
  state.counters["keypoints"] =
      benchmark::Counter(keypoints_found, benchmark::Counter::kAvgIterations);
}
BENCHMARK(BM_OpenCvSiftExtraction)->Unit(benchmark::kMillisecond);

// From a stop request, at a moment anywhere in the query, to the return of
// Localize: how long a cancelled call holds its worker.
void BM_TimeToStop(benchmark::State& state) {
  const Recording& recording = TestFrames();
  if (recording.frames.empty()) return state.SkipWithError(kNoData);
  const auto localizer = localizer::OpenLocalizer(ModelPath());
  if (!localizer.ok()) {
    return state.SkipWithError(NoModel(localizer.status()).c_str());
  }
  using Time = std::chrono::steady_clock;
  // Longer than an ordinary query, so that the last stages are met too.
  const auto whole = [&] {
    const Time::time_point start = Time::now();
    for (const image::Frame& frame : recording.frames) {
      benchmark::DoNotOptimize((*localizer)->Localize(frame, {}).ok());
    }
    return (Time::now() - start) / static_cast<int>(recording.frames.size());
  }();
  std::vector<double> stopped_ms;
  uint64_t k = 0;
  for (auto _ : state) {
    const double part = base::Random(1, k).NextUnit();
    std::stop_source stop;
    Time::time_point asked;
    std::jthread asker([&] {
      std::this_thread::sleep_for(whole * part);
      asked = Time::now();
      stop.request_stop();
    });
    const image::Frame& frame = recording.frames[k++ % recording.frames.size()];
    const auto estimate =
        (*localizer)->Localize(frame, {.stop = stop.get_token()});
    const Time::time_point returned = Time::now();
    asker.join();
    const double ms = std::max(
        0.0,
        std::chrono::duration<double, std::milli>(returned - asked).count());
    if (!estimate.ok()) stopped_ms.push_back(ms);
    state.SetIterationTime(ms / 1e3);
  }
  if (stopped_ms.empty()) return;
  std::sort(stopped_ms.begin(), stopped_ms.end());
  state.counters["p99_ms"] = stopped_ms[stopped_ms.size() * 99 / 100];
  state.counters["max_ms"] = stopped_ms.back();
  state.counters["stopped"] = static_cast<double>(stopped_ms.size());
}
BENCHMARK(BM_TimeToStop)
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime()
    ->Iterations(400);

// Arguments: samples, leaves visited in each tree.
void BM_Localize(benchmark::State& state) {
  const Recording& recording = TestFrames();
  if (recording.frames.empty()) return state.SkipWithError(kNoData);
  localizer::QueryOptions options;
  options.samples = static_cast<int>(state.range(0));
  options.backtracking_leaves = static_cast<int>(state.range(1));
  const auto localizer = localizer::OpenLocalizer(ModelPath(), options);
  if (!localizer.ok()) {
    return state.SkipWithError(NoModel(localizer.status()).c_str());
  }
  size_t k = 0;
  double localized = 0;
  for (auto _ : state) {
    const auto estimate =
        (*localizer)
            ->Localize(recording.frames[k++ % recording.frames.size()], {});
    if (!estimate.ok()) return state.SkipWithError("the frame was refused");
    localized += estimate->outcome == localizer::Outcome::kLocalized;
  }
  state.counters["localized"] =
      benchmark::Counter(localized, benchmark::Counter::kAvgIterations);
}
BENCHMARK(BM_Localize)
    ->ArgNames({"samples", "leaves"})
    ->Args({localizer::QueryOptions().samples,
            localizer::QueryOptions().backtracking_leaves})
    ->Args({1000, 16})
    ->Args({500, 4})
    ->Args({300, 4})
    ->Unit(benchmark::kMillisecond);

void BM_PlanarImage(benchmark::State& state) {
  const Recording& recording = TestFrames();
  if (recording.frames.empty()) return state.SkipWithError(kNoData);
  features::PlanarImage image;
  size_t k = 0;
  for (auto _ : state) {
    image.Assign(recording.frames[k++ % recording.frames.size()].color);
    benchmark::DoNotOptimize(image.data());
  }
}
BENCHMARK(BM_PlanarImage)->Unit(benchmark::kMicrosecond);

// The samples of one frame and their descriptors.
struct Sampled {
  features::PlanarImage image;
  features::RgbdSamples samples;
  std::vector<features::WhtDescriptor> descriptors;
};

std::vector<Sampled> SampleFrames(const Recording& recording, int count) {
  std::vector<Sampled> sampled;
  const features::DepthGeometry geometry(recording.dataset->calibration());
  for (const image::Frame& frame : recording.frames) {
    Sampled& s = sampled.emplace_back();
    s.image.Assign(frame.color);
    features::DrawSamples(geometry, *frame.depth, count,
                          base::Random(1, sampled.size()), s.samples);
    s.descriptors.resize(s.samples.size());
    features::ComputeWht(s.image, s.samples.x, s.samples.y, s.descriptors);
  }
  return sampled;
}

void BM_DrawSamples(benchmark::State& state) {
  const Recording& recording = TestFrames();
  if (recording.frames.empty()) return state.SkipWithError(kNoData);
  const features::DepthGeometry geometry(recording.dataset->calibration());
  features::RgbdSamples samples;
  size_t k = 0;
  for (auto _ : state) {
    const image::Frame& frame = recording.frames[k++ % recording.frames.size()];
    features::DrawSamples(geometry, *frame.depth,
                          static_cast<int>(state.range(0)), base::Random(1, k),
                          samples);
    benchmark::DoNotOptimize(samples.x.data());
  }
}
BENCHMARK(BM_DrawSamples)
    ->ArgName("samples")
    ->Arg(localizer::QueryOptions().samples)
    ->Unit(benchmark::kMicrosecond);

void BM_WalshHadamardDescriptors(benchmark::State& state) {
  const Recording& recording = TestFrames();
  if (recording.frames.empty()) return state.SkipWithError(kNoData);
  std::vector<Sampled> sampled =
      SampleFrames(recording, static_cast<int>(state.range(0)));
  size_t k = 0;
  for (auto _ : state) {
    Sampled& s = sampled[k++ % sampled.size()];
    features::ComputeWht(s.image, s.samples.x, s.samples.y, s.descriptors);
    benchmark::DoNotOptimize(s.descriptors.data());
  }
}
BENCHMARK(BM_WalshHadamardDescriptors)
    ->ArgName("samples")
    ->Arg(localizer::QueryOptions().samples)
    ->Unit(benchmark::kMicrosecond);

void BM_PredictLeaves(benchmark::State& state) {
  const Recording& recording = TestFrames();
  if (recording.frames.empty()) return state.SkipWithError(kNoData);
  const auto model = forest::ModelFile::Open(ModelPath());
  if (!model.ok()) {
    return state.SkipWithError(NoModel(model.status()).c_str());
  }
  const forest::ForestView& forest = (*model)->forest();
  const std::vector<Sampled> sampled =
      SampleFrames(recording, static_cast<int>(state.range(0)));
  forest::BacktrackingScratch scratch;
  std::vector<forest::LeafMatch> matches;
  size_t k = 0;
  for (auto _ : state) {
    const Sampled& s = sampled[k++ % sampled.size()];
    matches.resize(s.samples.size() * static_cast<size_t>(forest.trees()));
    forest::PredictLeaves(
        forest, s.image,
        {s.samples.x, s.samples.y, s.samples.inverse_depth_q12}, s.descriptors,
        {.leaves = static_cast<int>(state.range(1))}, {}, scratch, matches);
    benchmark::DoNotOptimize(matches.data());
  }
}
BENCHMARK(BM_PredictLeaves)
    ->ArgNames({"samples", "leaves"})
    ->Args({localizer::QueryOptions().samples,
            localizer::QueryOptions().backtracking_leaves})
    ->Args({500, 16})
    ->Args({500, 4})
    ->Args({500, 1})
    ->Unit(benchmark::kMicrosecond);

// A room of 4 m, seen in 500 points of which `inlier_percent` per cent have one
// good prediction (2 cm of noise) among five, and the others none.
pose::PointPredictions MakePredictions(int inlier_percent) {
  base::Random random(1, 1);
  const geometry::Rigid3 world_from_camera{
      geometry::Rotation3::FromAxisAngle({0.3, 0.4, -0.2}), {1, 0.5, -0.3}};
  const auto anywhere = [&] {
    return geometry::Vec3{random.NextUniform(-2, 2), random.NextUniform(-2, 2),
                          random.NextUniform(0.5, 4)};
  };
  pose::PointPredictions scene;
  scene.per_sample = 5;
  for (int i = 0; i < localizer::QueryOptions().samples; ++i) {
    const geometry::Vec3 in_camera = anywhere();
    scene.point_in_camera.push_back(in_camera);
    scene.depth_sigma_m.push_back(features::DepthSigma_m(in_camera.z));
    const bool inlier =
        random.NextBelow(100) < static_cast<uint32_t>(inlier_percent);
    const int good =
        inlier ? static_cast<int>(random.NextBelow(5)) : scene.per_sample;
    for (int k = 0; k < scene.per_sample; ++k) {
      const geometry::Vec3 noise{0.02 * random.NextGaussian(),
                                 0.02 * random.NextGaussian(),
                                 0.02 * random.NextGaussian()};
      scene.predictions.push_back(
          {k == good ? world_from_camera * in_camera + noise : anywhere(),
           {4e-4, 0, 0, 4e-4, 0, 4e-4}});
    }
  }
  return scene;
}

void BM_PreemptiveRansac(benchmark::State& state) {
  const pose::PointPredictions scene =
      MakePredictions(static_cast<int>(state.range(0)));
  pose::RansacOptions options;
  options.hypotheses = localizer::QueryOptions().hypotheses;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        pose::PreemptiveRansac(pose::PointSolver(scene, {}), options, {}));
    ++options.seed;
  }
}
BENCHMARK(BM_PreemptiveRansac)
    ->ArgName("inlier_percent")
    ->Arg(30)
    ->Arg(60)
    ->Unit(benchmark::kMicrosecond);

void BM_RefinePoints(benchmark::State& state) {
  const pose::PointPredictions scene =
      MakePredictions(static_cast<int>(state.range(0)));
  pose::RansacOptions options;
  options.hypotheses = localizer::QueryOptions().hypotheses;
  const auto start =
      pose::PreemptiveRansac(pose::PointSolver(scene, {}), options, {});
  if (!start) return state.SkipWithError("no hypothesis");
  for (auto _ : state) {
    benchmark::DoNotOptimize(pose::RefinePoints(scene, *start, {}));
  }
}
BENCHMARK(BM_RefinePoints)
    ->ArgName("inlier_percent")
    ->Arg(60)
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace treeline::benchmarks

BENCHMARK_MAIN();
