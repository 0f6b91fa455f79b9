// The process as metrics, under the names that Prometheus' own clients use.
#ifndef SERVER_APP_PROCESS_METRICS_H_
#define SERVER_APP_PROCESS_METRICS_H_

#include "absl/strings/string_view.h"
#include "common/metrics/registry.h"

namespace treeline::server_app {

// What /proc/self/stat says.
struct ProcessStat {
  double cpu_s = 0;
  double start_after_boot_s = 0;
  int threads = 0;
  double virtual_bytes = 0;
  double resident_bytes = 0;
};

// False if `text` is no such line. The program's name in it may be anything.
bool ParseProcessStat(absl::string_view text, ProcessStat& stat);

// CPU time, memory, threads, file descriptors, start. What /proc does not tell
// is left out.
void AddProcessMetrics(metrics::Registry& registry);

}  // namespace treeline::server_app

#endif  // SERVER_APP_PROCESS_METRICS_H_
