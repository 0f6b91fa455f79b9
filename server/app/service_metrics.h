// Calls, load and scenes as metrics. docs/reference/operations.md explains each
// of them.
#ifndef SERVER_APP_SERVICE_METRICS_H_
#define SERVER_APP_SERVICE_METRICS_H_

#include <chrono>
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

namespace treeline::server_app {

// Counts every call exactly once in treeline_requests_total. What a client
// chose becomes a label only where it is known to be ours: a scene, once a
// version of it has answered. Times of calls that belong to a trace which is
// recorded, here or by the caller, become exemplars. Thread-safe.
class ServiceMetrics final : public service::CallObserver {
 public:
  using WallClock = std::function<std::chrono::system_clock::time_point()>;

  // `registry` must outlive this. The clock is for exemplars.
  explicit ServiceMetrics(
      metrics::Registry& registry,
      WallClock wall_clock = [] { return std::chrono::system_clock::now(); });
  void OnCall(const service::CallRecord& record) override;

 private:
  void CountStages(const service::CallRecord& record);
  void Observe(const service::CallRecord& record, double ms,
               metrics::Histogram& seconds) const;

  const WallClock wall_clock_;
  metrics::MetricFamily<metrics::Counter>& requests_;
  metrics::MetricFamily<metrics::Histogram>& request_seconds_;
  metrics::MetricFamily<metrics::Histogram>& stage_seconds_;
  metrics::MetricFamily<metrics::Counter>& outcomes_;
  metrics::MetricFamily<metrics::Histogram>& inlier_ratio_;
  metrics::MetricFamily<metrics::Histogram>& confidence_;
  metrics::MetricFamily<metrics::Counter>& shed_;
  metrics::Counter& cancelled_;
  metrics::Counter& request_bytes_;
};

// What the repository knows of one scene, for metrics.
struct SceneFigures {
  std::string scene;
  repository::SceneState state = repository::SceneState::kUnloaded;
  uint64_t resident_bytes = 0;
  // Since the start.
  uint64_t loads = 0;  // that succeeded
  uint64_t load_failures = 0;
  uint64_t evictions = 0;
};

struct RepositoryFigures {
  std::vector<SceneFigures> scenes;
  // How long loads took, s; absent: not known.
  std::optional<metrics::HistogramCounts> load_seconds;
};

// Asked each time the metrics are; from any thread.
void AddLoadMetrics(metrics::Registry& registry,
                    std::function<service::Load()> load);
void AddSceneMetrics(metrics::Registry& registry,
                     std::function<RepositoryFigures()> figures);
// treeline_build_info.
void AddBuildInfo(metrics::Registry& registry, const std::string& version);

// Hands each call to several.
class CallObservers final : public service::CallObserver {
 public:
  // They must outlive this.
  explicit CallObservers(std::vector<service::CallObserver*> observers)
      : observers_(std::move(observers)) {}
  void OnCall(const service::CallRecord& record) override {
    for (service::CallObserver* observer : observers_) observer->OnCall(record);
  }

 private:
  const std::vector<service::CallObserver*> observers_;
};

}  // namespace treeline::server_app

#endif  // SERVER_APP_SERVICE_METRICS_H_
