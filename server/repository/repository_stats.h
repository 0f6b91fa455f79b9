// Figures of the repository, for metrics.
#ifndef SERVER_REPOSITORY_REPOSITORY_STATS_H_
#define SERVER_REPOSITORY_REPOSITORY_STATS_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "server/repository/scene.h"

namespace treeline::repository {

// How long loads took, those that failed included; s.
struct LoadTimes {
  static constexpr std::array<double, 12> kUpperBounds_s = {
      0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30};

  void Add(double seconds) {
    const auto bucket = std::ranges::lower_bound(kUpperBounds_s, seconds) -
                        kUpperBounds_s.begin();
    ++counts[static_cast<size_t>(bucket)];
    ++count;
    sum_s += seconds;
    last_s = seconds;
  }

  // counts[i]: of those at most kUpperBounds_s[i] and above the bound before;
  // the last: of the rest. Not cumulative.
  std::array<uint64_t, kUpperBounds_s.size() + 1> counts{};
  uint64_t count = 0;
  double sum_s = 0;
  double last_s = 0;
};

// Counts since the start.
struct LoadCounts {
  uint64_t loads = 0;  // that succeeded
  uint64_t load_failures = 0;
  // Taken out of memory to make room.
  uint64_t evictions = 0;
};

struct SceneStats {
  std::string name;
  SceneState state = SceneState::kUnloaded;
  LoadCounts counts;
  uint64_t resident_bytes = 0;
};

struct RepositoryStats {
  LoadCounts counts;
  LoadTimes load_times;
  // Another version, or another file of the same one, took over.
  uint64_t swaps = 0;
  uint64_t rescans = 0;  // that succeeded
  uint64_t rescan_failures = 0;
  // How the last one ended.
  absl::Status last_rescan = {};
  // Loads queued or at work.
  uint64_t pending_loads = 0;
  // Of all models in memory, those included that were let go and are still used
  // by a query.
  uint64_t resident_bytes = 0;
  // 0: none.
  uint64_t memory_budget_bytes = 0;
  // By SceneState.
  std::array<uint64_t, kSceneStates> scenes_by_state{};
  // By name.
  std::vector<SceneStats> scenes;
};

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_REPOSITORY_STATS_H_
