#include "server/app/process_metrics.h"

#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"

namespace treeline::server_app {
namespace {

// /proc's files have no size: they are read to their end.
std::string ReadProc(const char* path) {
  std::ifstream file(path);
  return std::string(std::istreambuf_iterator<char>(file),
                     std::istreambuf_iterator<char>());
}

// Seconds since 1970 when the machine started; from /proc/stat's "btime N".
std::optional<double> BootTime_s() {
  const std::string text = ReadProc("/proc/stat");
  for (const absl::string_view line : absl::StrSplit(text, '\n')) {
    const std::vector<absl::string_view> words = absl::StrSplit(line, ' ');
    double seconds = 0;
    if (words.size() == 2 && words[0] == "btime" &&
        absl::SimpleAtod(words[1], &seconds)) {
      return seconds;
    }
  }
  return std::nullopt;
}

std::optional<double> OpenDescriptors() {
  std::error_code error;
  double count = 0;
  std::filesystem::directory_iterator entry("/proc/self/fd", error);
  for (; !error && entry != std::filesystem::directory_iterator();
       entry.increment(error)) {
    ++count;
  }
  if (error) return std::nullopt;
  return count;
}

void Write(const char* name, const char* help, metrics::MetricType type,
           double value, metrics::Exposition& out) {
  out.Family(name, help, type);
  out.Sample({}, value);
}

}  // namespace

bool ParseProcessStat(absl::string_view text, ProcessStat& stat) {
  // "PID (NAME) STATE PPID ...": NAME may hold blanks and brackets.
  const size_t name_end = text.rfind(')');
  if (name_end == absl::string_view::npos || text.size() < name_end + 2) {
    return false;
  }
  const std::vector<absl::string_view> fields =
      absl::StrSplit(text.substr(name_end + 2), ' ');
  // proc(5) counts from 1 and has PID and NAME in front.
  const auto field = [&](size_t number, double& value) {
    return number - 3 < fields.size() &&
           absl::SimpleAtod(fields[number - 3], &value);
  };
  double user = 0;
  double system = 0;
  double threads = 0;
  double start = 0;
  double pages = 0;
  if (!field(14, user) || !field(15, system) || !field(20, threads) ||
      !field(22, start) || !field(23, stat.virtual_bytes) ||
      !field(24, pages)) {
    return false;
  }
  const auto ticks_per_s = static_cast<double>(sysconf(_SC_CLK_TCK));
  stat.cpu_s = (user + system) / ticks_per_s;
  stat.start_after_boot_s = start / ticks_per_s;
  stat.threads = static_cast<int>(threads);
  stat.resident_bytes = pages * static_cast<double>(sysconf(_SC_PAGESIZE));
  return true;
}

void AddProcessMetrics(metrics::Registry& registry) {
  registry.AddSource([](metrics::Exposition& out) {
    ProcessStat stat;
    if (ParseProcessStat(ReadProc("/proc/self/stat"), stat)) {
      Write("process_cpu_seconds_total", "CPU time, user and system.",
            metrics::MetricType::kCounter, stat.cpu_s, out);
      Write("process_resident_memory_bytes", "Memory in use.",
            metrics::MetricType::kGauge, stat.resident_bytes, out);
      Write("process_virtual_memory_bytes", "Address space in use.",
            metrics::MetricType::kGauge, stat.virtual_bytes, out);
      Write("process_threads", "Threads.", metrics::MetricType::kGauge,
            stat.threads, out);
      if (const auto boot_s = BootTime_s()) {
        Write("process_start_time_seconds", "Start, in seconds since 1970.",
              metrics::MetricType::kGauge, *boot_s + stat.start_after_boot_s,
              out);
      }
    }
    if (const auto open = OpenDescriptors()) {
      Write("process_open_fds", "File descriptors in use.",
            metrics::MetricType::kGauge, *open, out);
    }
    rlimit limit{};
    if (getrlimit(RLIMIT_NOFILE, &limit) == 0) {
      Write("process_max_fds", "File descriptors allowed.",
            metrics::MetricType::kGauge, static_cast<double>(limit.rlim_cur),
            out);
    }
  });
}

}  // namespace treeline::server_app
