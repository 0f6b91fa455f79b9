// How long a model takes to load, cold and warm, and where that time goes; and
// what a second process that serves the same model adds to memory.
//
//   TREELINE_BENCHMARK_MODEL  the model file; without it, all is skipped
//
//   model_load_benchmark --benchmark_min_time=2
//
// Cold: its pages are dropped from the page cache before every load, as far as
// the system lets a program do so (no other process may map the file).
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "benchmark/benchmark.h"
#include "common/base/clock.h"
#include "common/base/file.h"
#include "server/core/forest/model_file.h"
#include "server/core/localizer/localizer.h"

namespace treeline::benchmarks {
namespace {

std::string ModelPath() {
  const char* path = std::getenv("TREELINE_BENCHMARK_MODEL");
  return path == nullptr ? "" : path;
}

void DropFromPageCache(const std::string& path) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return;
  posix_fadvise(fd, 0, 0, POSIX_FADV_DONTNEED);
  close(fd);
}

// Times `load` alone, on a cold or a warm file.
template <typename Load>
void TimeLoads(benchmark::State& state, bool is_cold, const Load& load) {
  const std::string path = ModelPath();
  if (path.empty()) {
    state.SkipWithError("no TREELINE_BENCHMARK_MODEL");
    return;
  }
  const base::SteadyClock clock;
  if (!is_cold) load(path);
  double min_ms = std::numeric_limits<double>::infinity();
  for (auto _ : state) {
    if (is_cold) DropFromPageCache(path);
    const base::MonotonicTime start = clock.Now();
    const uint64_t bytes = load(path);
    const double took_ms = base::MillisecondsBetween(start, clock.Now());
    state.SetIterationTime(1e-3 * took_ms);
    min_ms = std::min(min_ms, took_ms);
    if (bytes == 0) {
      state.SkipWithError("the model cannot be loaded");
      return;
    }
    state.counters["MB"] = static_cast<double>(bytes) / 1e6;
  }
  // The mean suffers from whatever else the machine does.
  state.counters["min_ms"] = min_ms;
}

// What the storage, or the page cache, can do at best.
uint64_t ReadAll(const std::string& path) {
  std::vector<char> buffer(1 << 20);
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  uint64_t bytes = 0;
  ssize_t got = 0;
  while ((got = read(fd, buffer.data(), buffer.size())) > 0) {
    bytes += static_cast<uint64_t>(got);
  }
  close(fd);
  return bytes;
}

uint64_t MapAndHash(const std::string& path) {
  const auto file = base::MappedFile::Open(path);
  if (!file.ok()) return 0;
  benchmark::DoNotOptimize(XXH3_64bits(file->data(), file->size()));
  return file->size();
}

uint64_t OpenFile(const std::string& path) {
  const auto model = forest::ModelFile::Open(path);
  return model.ok() ? (*model)->info().file_bytes : 0;
}

uint64_t OpenWhole(const std::string& path) {
  const auto localizer = localizer::OpenLocalizer(path);
  return localizer.ok() ? (*localizer)->info().file_bytes : 0;
}

void ReadCold(benchmark::State& state) { TimeLoads(state, true, ReadAll); }
void ReadWarm(benchmark::State& state) { TimeLoads(state, false, ReadAll); }
void HashCold(benchmark::State& state) { TimeLoads(state, true, MapAndHash); }
void HashWarm(benchmark::State& state) { TimeLoads(state, false, MapAndHash); }
void ModelFileCold(benchmark::State& state) {
  TimeLoads(state, true, OpenFile);
}
void ModelFileWarm(benchmark::State& state) {
  TimeLoads(state, false, OpenFile);
}
void LocalizerCold(benchmark::State& state) {
  TimeLoads(state, true, OpenWhole);
}
void LocalizerWarm(benchmark::State& state) {
  TimeLoads(state, false, OpenWhole);
}

// MB of one line of smaps ("Pss:"), summed over mappings of files whose path
// holds `path`; of all mappings if it is "".
double Mapped_mb(const std::string& field, const std::string& path) {
  std::ifstream smaps("/proc/self/smaps");
  double kilobytes = 0;
  bool is_wanted = false;
  for (std::string line; std::getline(smaps, line);) {
    std::istringstream words(line);
    std::string first;
    words >> first;
    if (first.find('-') != std::string::npos) {
      is_wanted = path.empty() || line.find(path) != std::string::npos;
    } else if (is_wanted && first == field) {
      double value = 0;
      words >> value;
      kilobytes += value;
    }
  }
  return kilobytes * 1024 / 1e6;
}

// Two processes with the model loaded: what one of them has of it.
void TwoProcesses(benchmark::State& state) {
  const std::string path = ModelPath();
  if (path.empty()) {
    state.SkipWithError("no TREELINE_BENCHMARK_MODEL");
    return;
  }
  for (auto _ : state) {
    int to_child[2];
    int to_parent[2];
    if (pipe(to_child) != 0 || pipe(to_parent) != 0) std::abort();
    const pid_t child = fork();
    char byte = 0;
    if (child == 0) {
      close(to_child[1]);
      const auto localizer = localizer::OpenLocalizer(path);
      if (write(to_parent[1], &byte, 1) != 1) _exit(1);
      (void)!read(to_child[0], &byte, 1);
      _exit(0);
    }
    const double heap_before_mb =
        Mapped_mb("Private_Dirty:", "") + Mapped_mb("Swap:", "");
    const auto localizer = localizer::OpenLocalizer(path);
    if (!localizer.ok() || read(to_parent[0], &byte, 1) != 1) std::abort();
    state.counters["file_rss_MB"] = Mapped_mb("Rss:", path);
    state.counters["file_pss_MB"] = Mapped_mb("Pss:", path);
    state.counters["file_private_MB"] =
        Mapped_mb("Private_Clean:", path) + Mapped_mb("Private_Dirty:", path);
    state.counters["heap_MB"] = Mapped_mb("Private_Dirty:", "") +
                                Mapped_mb("Swap:", "") - heap_before_mb;
    close(to_child[0]);
    close(to_child[1]);
    close(to_parent[0]);
    close(to_parent[1]);
    waitpid(child, nullptr, 0);
  }
}

BENCHMARK(ReadCold)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(ReadWarm)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(HashCold)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(HashWarm)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(ModelFileCold)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(ModelFileWarm)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(LocalizerCold)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(LocalizerWarm)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(TwoProcesses)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace treeline::benchmarks

BENCHMARK_MAIN();
