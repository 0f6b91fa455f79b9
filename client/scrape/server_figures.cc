#include "client/scrape/server_figures.h"

#include <algorithm>
#include <limits>

namespace treeline::scrape {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kRpcs[] = {"Localize", "LocalizeStream"};

// Of counters: what was added. A server that began anew counts from 0.
double Grown(double before, double after) {
  return after >= before ? after - before : after;
}

double Grown(const MetricsSnapshot& before, const MetricsSnapshot& after,
             const std::string& name, const Labels& match = {}) {
  return Grown(before.Sum(name, match), after.Sum(name, match));
}

std::map<double, double> RequestBuckets(const MetricsSnapshot& before,
                                        const MetricsSnapshot& after) {
  std::map<double, double> buckets;
  for (const char* rpc : kRpcs) {
    const std::map<double, double> then =
        before.Buckets("treeline_request_seconds", {{"rpc", rpc}});
    for (const auto& [bound, count] :
         after.Buckets("treeline_request_seconds", {{"rpc", rpc}})) {
      const auto old = then.find(bound);
      buckets[bound] += Grown(old == then.end() ? 0 : old->second, count);
    }
  }
  return buckets;
}

}  // namespace

bool IsServer(const MetricsSnapshot& metrics) {
  return metrics.Has("treeline_workers") && metrics.Has("treeline_queue_depth");
}

ServerFigures FiguresBetween(const MetricsSnapshot& before,
                             const MetricsSnapshot& after, double between_s,
                             double now_unix_s) {
  ServerFigures figures;
  const auto per_s = [&](const std::string& name, const Labels& match = {}) {
    return Grown(before, after, name, match) / between_s;
  };
  figures.answers_per_s = per_s("treeline_outcomes_total");
  const double localized =
      per_s("treeline_outcomes_total", {{"outcome", "LOCALIZED"}});
  figures.localized_share =
      figures.answers_per_s > 0 ? localized / figures.answers_per_s : kNothing;
  figures.shed_per_s = per_s("treeline_shed_total");
  for (const char* rpc : kRpcs) {
    figures.failed_per_s +=
        per_s("treeline_requests_total", {{"rpc", rpc}}) -
        per_s("treeline_requests_total", {{"rpc", rpc}, {"status", "OK"}});
  }
  figures.failed_per_s =
      std::max(0.0, figures.failed_per_s - figures.shed_per_s);

  const std::map<double, double> buckets = RequestBuckets(before, after);
  figures.p50_ms = 1e3 * HistogramQuantile(0.5, buckets);
  figures.p99_ms = 1e3 * HistogramQuantile(0.99, buckets);
  for (const auto& [stage, count] :
       after.SumBy("treeline_stage_seconds_count", "stage")) {
    const Labels of = {{"stage", stage}};
    const double calls =
        Grown(before.Sum("treeline_stage_seconds_count", of), count);
    const double took_s =
        Grown(before, after, "treeline_stage_seconds_sum", of);
    figures.stage_ms[stage] = calls > 0 ? 1e3 * took_s / calls : kNothing;
  }

  figures.queue_depth = after.Sum("treeline_queue_depth");
  figures.queue_capacity = after.Sum("treeline_queue_capacity");
  figures.in_flight = after.Sum("treeline_in_flight");
  figures.workers = after.Sum("treeline_workers");
  figures.resident_bytes = after.Sum("process_resident_memory_bytes");
  figures.processors = per_s("process_cpu_seconds_total");
  figures.scenes = after.SumBy("treeline_scenes", "state");
  const std::map<std::string, double> then =
      before.SumBy("treeline_outcomes_total", "scene");
  for (const auto& [scene, count] :
       after.SumBy("treeline_outcomes_total", "scene")) {
    const auto old = then.find(scene);
    figures.answers_per_s_by_scene[scene] =
        Grown(old == then.end() ? 0 : old->second, count) / between_s;
  }
  const auto versions = after.SumBy("treeline_build_info", "version");
  if (!versions.empty()) figures.version = versions.begin()->first;
  const double started = after.Sum("process_start_time_seconds");
  if (started > 0) figures.up_s = std::max(0.0, now_unix_s - started);
  return figures;
}

}  // namespace treeline::scrape
