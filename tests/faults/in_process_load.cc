// What the localizer does without a service: the yardstick of its overhead.
//
//   in-process-load MODEL DATASET LIST FRAMES THREADS SECONDS
//
// Decodes and localizes the first FRAMES frames of the list over and over, from
// the bytes that a client would send, and prints one JSON object.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "common/dataset/dataset.h"
#include "common/wire/frame.h"
#include "server/core/localizer/localizer.h"

namespace treeline {
namespace {

struct Worker {
  std::vector<double> latencies_ms;
  int failed = 0;
};

std::vector<v1::Frame> ReadFrames(const dataset::Dataset& dataset, int count) {
  std::vector<v1::Frame> frames;
  for (int i = 0; i < std::min(count, dataset.size()); ++i) {
    absl::StatusOr<dataset::Dataset::Encoded> encoded = dataset.ReadEncoded(i);
    if (!encoded.ok()) continue;
    wire::QueryFrame frame;
    frame.color = wire::EncodedImage{std::move(encoded->color)};
    if (!encoded->depth.empty()) {
      frame.depth = wire::QueryDepth{
          .image = wire::EncodedImage{std::move(encoded->depth)},
          .unit_m = dataset.depth_unit_m()};
    }
    frames.push_back(wire::ToProto(frame));
  }
  return frames;
}

double ProcessorSeconds() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec +
                                    usage.ru_stime.tv_usec);
}

Worker Work(const localizer::Localizer& localizer,
            const std::vector<v1::Frame>& frames, base::MonotonicTime end) {
  const base::SteadyClock clock;
  Worker worker;
  base::MonotonicTime start = clock.Now();
  for (size_t i = 0; start < end; ++i) {
    const absl::StatusOr<image::Frame> frame = wire::FromProto(
        frames[i % frames.size()], localizer.info().calibration, {}, "frame");
    const bool good = frame.ok() && localizer.Localize(*frame, {}).ok();
    const base::MonotonicTime now = clock.Now();
    worker.latencies_ms.push_back(base::MillisecondsBetween(start, now));
    worker.failed += !good;
    start = now;
  }
  return worker;
}

int Run(char** argv) {
  const auto localizer = localizer::OpenLocalizer(argv[1]);
  const auto dataset =
      dataset::Dataset::Open({.uri = argv[2], .frame_list = argv[3]});
  if (!localizer.ok() || !dataset.ok()) {
    std::fprintf(stderr, "%s %s\n", localizer.status().ToString().c_str(),
                 dataset.status().ToString().c_str());
    return 1;
  }
  const std::vector<v1::Frame> frames =
      ReadFrames(*dataset, std::atoi(argv[4]));
  if (frames.empty()) return 1;
  const size_t threads = static_cast<size_t>(std::max(1, std::atoi(argv[5])));
  const double seconds = std::atof(argv[6]);
  std::vector<Worker> workers(threads);
  const double cpu_s = ProcessorSeconds();
  const base::MonotonicTime end =
      base::SteadyClock().Now() +
      std::chrono::milliseconds(static_cast<int64_t>(seconds * 1e3));
  {
    std::vector<std::jthread> running;
    for (Worker& worker : workers) {
      running.emplace_back([&] { worker = Work(**localizer, frames, end); });
    }
  }
  std::vector<double> all_ms;
  int failed = 0;
  for (const Worker& worker : workers) {
    all_ms.insert(all_ms.end(), worker.latencies_ms.begin(),
                  worker.latencies_ms.end());
    failed += worker.failed;
  }
  std::sort(all_ms.begin(), all_ms.end());
  std::printf(
      "{\"queries\": %zu, \"failed\": %d, \"per_s\": %.2f, "
      "\"cpus\": %.3f, \"p50_ms\": %.3f, \"p99_ms\": %.3f}\n",
      all_ms.size(), failed, static_cast<double>(all_ms.size()) / seconds,
      (ProcessorSeconds() - cpu_s) / seconds, all_ms[all_ms.size() / 2],
      all_ms[all_ms.size() * 99 / 100]);
  return failed > 0 ? 1 : 0;
}

}  // namespace
}  // namespace treeline

int main(int argc, char** argv) {
  if (argc != 7) {
    std::fprintf(stderr,
                 "usage: %s MODEL DATASET LIST FRAMES THREADS SECONDS\n",
                 argv[0]);
    return 2;
  }
  return treeline::Run(argv);
}
