#include "server/app/service_metrics.h"

#include <map>
#include <utility>

#include "common/base/error_info.h"

namespace treeline::server_app {
namespace {

constexpr double kSecondsPerMillisecond = 1e-3;

// A label may not be left out: this is what stands for "there is none".
constexpr char kNone[] = "none";

std::string OrNone(const std::string& text) {
  return text.empty() ? std::string(kNone) : text;
}

std::string ToText(absl::string_view text) { return std::string(text); }

const char* StateName(repository::SceneState state) {
  switch (state) {
    case repository::SceneState::kUnloaded:
      return "UNLOADED";
    case repository::SceneState::kLoading:
      return "LOADING";
    case repository::SceneState::kReady:
      return "READY";
    case repository::SceneState::kFailed:
      break;
  }
  return "FAILED";
}

constexpr repository::SceneState kAllStates[] = {
    repository::SceneState::kUnloaded, repository::SceneState::kLoading,
    repository::SceneState::kReady, repository::SceneState::kFailed};

void WriteScenes(const std::vector<SceneFigures>& scenes,
                 metrics::Exposition& out) {
  out.Family("treeline_scene_loads_total",
             "Loads of models by scene and result: ok, failed.",
             metrics::MetricType::kCounter);
  for (const SceneFigures& scene : scenes) {
    out.Sample({{"scene", scene.scene}, {"result", "ok"}},
               static_cast<double>(scene.loads));
    out.Sample({{"scene", scene.scene}, {"result", "failed"}},
               static_cast<double>(scene.load_failures));
  }
  out.Family("treeline_scene_evictions_total",
             "Times a scene left memory to make room.",
             metrics::MetricType::kCounter);
  for (const SceneFigures& scene : scenes) {
    out.Sample({{"scene", scene.scene}}, static_cast<double>(scene.evictions));
  }
  out.Family("treeline_scene_resident_bytes",
             "Memory of a scene's loaded versions.",
             metrics::MetricType::kGauge);
  for (const SceneFigures& scene : scenes) {
    out.Sample({{"scene", scene.scene}},
               static_cast<double>(scene.resident_bytes));
  }
  std::map<repository::SceneState, int> by_state;
  for (const SceneFigures& scene : scenes) ++by_state[scene.state];
  out.Family("treeline_scenes",
             "Scenes by state: UNLOADED, LOADING, READY, FAILED.",
             metrics::MetricType::kGauge);
  for (const repository::SceneState state : kAllStates) {
    out.Sample({{"state", StateName(state)}}, by_state[state]);
  }
}

}  // namespace

ServiceMetrics::ServiceMetrics(metrics::Registry& registry,
                               WallClock wall_clock)
    : wall_clock_(std::move(wall_clock)),
      requests_(registry.AddCounter(
          "treeline_requests_total",
          "Finished calls, each once, by RPC, transport, status code and the "
          "error's reason.",
          {"rpc", "transport", "status", "reason"})),
      request_seconds_(registry.AddHistogram(
          "treeline_request_seconds",
          "Time from the arrival of the whole request to its answer.", {"rpc"},
          metrics::LatencyBuckets())),
      stage_seconds_(registry.AddHistogram(
          "treeline_stage_seconds",
          "Time of calls in each stage that they reached: queue, decode, "
          "sample, forest, pose.",
          {"stage", "method", "status"}, metrics::LatencyBuckets())),
      outcomes_(registry.AddCounter(
          "treeline_outcomes_total",
          "Answered queries by scene, outcome, and why they were not "
          "localized.",
          {"scene", "outcome", "reason"})),
      inlier_ratio_(registry.AddHistogram(
          "treeline_inlier_ratio",
          "Share of the samples that agree with an answer's pose.", {"scene"},
          metrics::ShareBuckets())),
      confidence_(registry.AddHistogram("treeline_confidence",
                                        "Confidence of answers: calibrated "
                                        "probability that the pose is right.",
                                        {"scene"}, metrics::ShareBuckets())),
      shed_(registry.AddCounter(
          "treeline_shed_total",
          "Calls turned away for too much load before any work, by reason; "
          "they are in treeline_requests_total too.",
          {"reason"})),
      cancelled_(registry
                     .AddCounter("treeline_cancelled_total",
                                 "Calls that ended because the client "
                                 "cancelled or went away; they are in "
                                 "treeline_requests_total too.",
                                 {})
                     .With({})),
      request_bytes_(registry
                         .AddCounter("treeline_request_bytes_total",
                                     "Bytes of all requests.", {})
                         .With({})) {}

void ServiceMetrics::OnCall(const service::CallRecord& record) {
  const std::string reason = base::ErrorInfoOf(record.status).reason;
  requests_
      .With({record.rpc, record.transport,
             ToText(absl::StatusCodeToString(record.status.code())),
             OrNone(reason)})
      .Add();
  Observe(record, record.timings.total_ms, request_seconds_.With({record.rpc}));
  request_bytes_.Add(record.request_bytes);
  if (record.shed) shed_.With({OrNone(reason)}).Add();
  if (absl::IsCancelled(record.status)) cancelled_.Add();
  CountStages(record);
  // The scene is one of ours: a version of it has answered.
  if (!record.outcome || record.model_version.empty()) return;
  outcomes_
      .With({record.scene, ToText(localizer::OutcomeName(*record.outcome)),
             ToText(localizer::ReasonName(record.reason))})
      .Add();
  if (record.samples > 0) {
    inlier_ratio_.With({record.scene})
        .Observe(static_cast<double>(record.inliers) / record.samples);
  }
  confidence_.With({record.scene}).Observe(record.confidence);
}

void ServiceMetrics::Observe(const service::CallRecord& record, double ms,
                             metrics::Histogram& seconds) const {
  const auto& trace = record.span.has_value() ? record.span : record.trace;
  if (!trace.has_value() || !trace->sampled) {
    seconds.Observe(ms * kSecondsPerMillisecond);
    return;
  }
  const double unix_s =
      std::chrono::duration<double>(wall_clock_().time_since_epoch()).count();
  seconds.Observe(metrics::Exemplar{.value = ms * kSecondsPerMillisecond,
                                    .trace_id = trace->trace_id,
                                    .unix_s = unix_s});
}

void ServiceMetrics::CountStages(const service::CallRecord& record) {
  const service::CallTimings& t = record.timings;
  const std::string method = OrNone(record.method);
  const std::string status =
      ToText(absl::StatusCodeToString(record.status.code()));
  const auto count = [&](const char* stage, double ms) {
    Observe(record, ms, stage_seconds_.With({stage, method, status}));
  };
  // Calls that only list scenes have no stages.
  if (t.queue_ms > 0) count("queue", t.queue_ms);
  if (t.decode_ms > 0) count("decode", t.decode_ms);
  if (!record.outcome) return;
  count("sample", t.localize.sample_ms);
  count("forest", t.localize.forest_ms);
  count("pose", t.localize.pose_ms);
  count("features", t.localize.features_ms);
  count("verify", t.localize.verify_ms);
}

void AddLoadMetrics(metrics::Registry& registry,
                    std::function<service::Load()> load) {
  registry.AddSource([load = std::move(load)](metrics::Exposition& out) {
    const service::Load now = load();
    const auto gauge = [&](const char* name, const char* help, int value) {
      out.Family(name, help, metrics::MetricType::kGauge);
      out.Sample({}, value);
    };
    gauge("treeline_queue_depth", "Queries that wait for a worker.",
          now.queued);
    gauge("treeline_queue_capacity", "Maximum number of queries that may wait.",
          now.queue_capacity);
    gauge("treeline_in_flight", "Queries that are being computed.",
          now.running);
    gauge("treeline_workers", "Queries that can be computed at the same time.",
          now.workers);
  });
}

void AddSceneMetrics(metrics::Registry& registry,
                     std::function<RepositoryFigures()> figures) {
  registry.AddSource([figures = std::move(figures)](metrics::Exposition& out) {
    const RepositoryFigures now = figures();
    WriteScenes(now.scenes, out);
    if (!now.load_seconds) return;
    out.Family("treeline_scene_load_seconds",
               "Duration of model loads, failed ones included.",
               metrics::MetricType::kHistogram);
    out.Histogram({}, *now.load_seconds);
  });
}

void AddBuildInfo(metrics::Registry& registry, const std::string& version) {
  registry
      .AddGauge("treeline_build_info", "Always 1; the version is its label.",
                {"version"})
      .With({version})
      .Set(1);
}

}  // namespace treeline::server_app
