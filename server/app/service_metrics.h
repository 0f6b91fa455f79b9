// Calls, load and scenes as metrics. docs/operations.md explains each of them.
#ifndef SERVER_APP_SERVICE_METRICS_H_
#define SERVER_APP_SERVICE_METRICS_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/metrics/registry.h"
#include "server/repository/scene_repository.h"
#include "server/service/call_observer.h"
#include "server/service/dispatcher.h"

namespace treeline {

// Counts every call exactly once in treeline_requests_total. What a client
// chose becomes a label only where it is known to be ours: a scene, once a
// version of it has answered. Thread-safe.
class ServiceMetrics final : public CallObserver {
 public:
  // `registry` must outlive this.
  explicit ServiceMetrics(Registry& registry);
  void OnCall(const CallRecord& record) override;

 private:
  void CountStages(const CallRecord& record);

  MetricFamily<Counter>& requests_;
  MetricFamily<Histogram>& request_seconds_;
  MetricFamily<Histogram>& stage_seconds_;
  MetricFamily<Counter>& outcomes_;
  MetricFamily<Histogram>& inlier_ratio_;
  MetricFamily<Histogram>& confidence_;
  MetricFamily<Counter>& shed_;
  Counter& cancelled_;
  Counter& request_bytes_;
};

// What the repository knows of one scene, for metrics.
struct SceneFigures {
  std::string scene;
  SceneState state = SceneState::kUnloaded;
  uint64_t resident_bytes = 0;
  // Since the start.
  uint64_t loads = 0;  // that succeeded
  uint64_t load_failures = 0;
  uint64_t evictions = 0;
};

struct RepositoryFigures {
  std::vector<SceneFigures> scenes;
  // How long loads took, s; absent: not known.
  std::optional<HistogramCounts> load_seconds;
};

// Asked each time the metrics are; from any thread.
void AddLoadMetrics(Registry& registry, std::function<Load()> load);
void AddSceneMetrics(Registry& registry,
                     std::function<RepositoryFigures()> figures);
// treeline_build_info.
void AddBuildInfo(Registry& registry, const std::string& version);

// Hands each call to several.
class CallObservers final : public CallObserver {
 public:
  // They must outlive this.
  explicit CallObservers(std::vector<CallObserver*> observers)
      : observers_(std::move(observers)) {}
  void OnCall(const CallRecord& record) override {
    for (CallObserver* observer : observers_) observer->OnCall(record);
  }

 private:
  const std::vector<CallObserver*> observers_;
};

}  // namespace treeline

#endif  // SERVER_APP_SERVICE_METRICS_H_
