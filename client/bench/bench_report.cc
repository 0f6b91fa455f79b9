#include "client/bench/bench_report.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "nlohmann/json.hpp"

namespace treeline::bench {
namespace {

using Json = nlohmann::ordered_json;

// Measured to a microsecond; further digits are noise.
double Rounded(double value) { return std::round(value * 1e3) / 1e3; }

Json HistogramJson(const LatencyHistogram& histogram) {
  if (histogram.count() == 0) return nullptr;
  return {{"count", histogram.count()},
          {"mean", Rounded(histogram.mean_ms())},
          {"p50", Rounded(histogram.Percentile_ms(50))},
          {"p90", Rounded(histogram.Percentile_ms(90))},
          {"p95", Rounded(histogram.Percentile_ms(95))},
          {"p99", Rounded(histogram.Percentile_ms(99))},
          {"p99.9", Rounded(histogram.Percentile_ms(99.9))},
          {"max", Rounded(histogram.max_ms())}};
}

Json OutcomesJson(const TallyState& tally) {
  Json outcomes = Json::array();
  for (const auto& [key, latencies] : tally.outcomes) {
    const auto message = tally.messages.find(key);
    outcomes.push_back(
        {{"code", absl::StatusCodeToString(key.first)},
         {"reason", key.second.empty() ? Json(nullptr) : Json(key.second)},
         {"count", latencies.from_send.count()},
         {"example", message == tally.messages.end() ? Json(nullptr)
                                                     : Json(message->second)},
         {"latency_ms", HistogramJson(latencies.from_schedule)},
         {"from_send_ms", HistogramJson(latencies.from_send)}});
  }
  return outcomes;
}

Json ServerJson(const ServerSplit& server) {
  return {{"queue_ms", HistogramJson(server.queue)},
          {"decode_ms", HistogramJson(server.decode)},
          {"sample_ms", HistogramJson(server.sample)},
          {"forest_ms", HistogramJson(server.forest)},
          {"pose_ms", HistogramJson(server.pose)},
          {"features_ms", HistogramJson(server.features)},
          {"verify_ms", HistogramJson(server.verify)},
          {"localize_ms", HistogramJson(server.localize)},
          {"total_ms", HistogramJson(server.total)},
          {"outside_ms", HistogramJson(server.outside)},
          {"overhead_ms", HistogramJson(server.overhead)}};
}

Json ChecksJson(const Checks& checks) {
  return {{"as_before_load", checks.as_before_load},
          {"as_first_under_load", checks.as_first_under_load},
          {"first_of_a_version", checks.first_of_a_version},
          {"different", checks.different},
          {"with_truth", checks.with_truth},
          {"within_tolerance", checks.within_tolerance},
          {"wrong_poses", checks.wrong_poses}};
}

Json CountsJson(const CallCounts& counts) {
  Json json;
  for (size_t kind = 0; kind < counts.size(); ++kind) {
    json[Name(static_cast<CallKind>(kind))] = counts[kind];
  }
  return json;
}

Json IntervalsJson(const TallyState& tally, double interval_s) {
  Json intervals = Json::array();
  for (size_t i = 0; i < tally.intervals.size(); ++i) {
    const Interval& interval = tally.intervals[i];
    Json json = CountsJson(interval.counts);
    json["at_s"] = static_cast<double>(i) * interval_s;
    json["p50_ms"] = Rounded(interval.ok.Percentile_ms(50));
    json["p99_ms"] = Rounded(interval.ok.Percentile_ms(99));
    json["max_ms"] = Rounded(interval.ok.max_ms());
    intervals.push_back(std::move(json));
  }
  return intervals;
}

double UnixSeconds(std::chrono::system_clock::time_point time) {
  return std::chrono::duration<double>(time.time_since_epoch()).count();
}

Json RunJson(const LoadRun& run, const std::vector<FailCondition>& conditions) {
  const TallyState& tally = run.tally;
  const LoadOptions& options = run.options;
  const bool open = options.rate_per_s > 0;
  const auto of = [&](CallKind kind) -> const Latencies& {
    return tally.latencies[static_cast<size_t>(kind)];
  };
  Json json = {
      {"loop", open ? "open" : "closed"},
      {"rate_per_s", open ? Json(options.rate_per_s) : Json(nullptr)},
      {"concurrency", open ? Json(nullptr) : Json(options.concurrency)},
      {"stream_window", options.stream_window},
      {"deadline_ms", options.deadline_ms},
      {"warm_up_s", options.warm_up_s},
      {"measured_from_unix_s", UnixSeconds(run.measured_from)},
      {"measured_s", Rounded(run.measured_s)},
      {"wall_s", Rounded(run.wall_s)},
      {"interrupted", run.interrupted},
      {"abandoned", run.abandoned},
      {"calls", tally.total()},
      {"counts", CountsJson(tally.counts)},
      {"localized", tally.localized},
      {"answers_per_s",
       run.measured_s > 0
           ? Rounded(static_cast<double>(tally.counts[0]) / run.measured_s)
           : 0},
      {"goodput_per_s", Rounded(Goodput_per_s(run))},
      {"latency_ms", HistogramJson(of(CallKind::kOk).from_schedule)},
      {"from_send_ms", HistogramJson(of(CallKind::kOk).from_send)},
      {"shed_from_send_ms", HistogramJson(of(CallKind::kShed).from_send)},
      {"outcomes", OutcomesJson(tally)},
      {"server", ServerJson(tally.server)},
      {"checks", ChecksJson(tally.checks)},
      {"answered_by", tally.answered_by},
      {"generator",
       {{"saturated", run.saturated()},
        {"not_sent", run.not_sent},
        {"send_lag_ms", HistogramJson(run.send_lag)},
        {"cpus", Rounded(run.generator_cpus)}}},
      {"failures", Failures(conditions, run)},
      {"intervals", IntervalsJson(tally, options.interval_s)}};
  return json;
}

Json WorkloadJson(const std::vector<WorkloadSummary>& workload) {
  Json json = Json::array();
  for (const WorkloadSummary& part : workload) {
    json.push_back({{"scene", part.scene},
                    {"encoding", part.encoding},
                    {"queries", part.queries},
                    {"with_truth", part.with_truth},
                    {"mean_bytes", std::round(part.mean_bytes)}});
  }
  return json;
}

// JSON has no NaN.
Json Figure(double value) {
  return std::isfinite(value) ? Json(Rounded(value)) : Json(nullptr);
}

Json CourseJson(const BenchReport& report) {
  if (!report.course) return nullptr;
  Json points = Json::array();
  for (const CoursePoint& point : report.course->points) {
    const scrape::ServerFigures& figures = point.figures;
    Json stages = Json::object();
    for (const auto& [stage, ms] : figures.stage_ms) stages[stage] = Figure(ms);
    points.push_back({{"at_unix_s", point.at_unix_s},
                      {"answers_per_s", Figure(figures.answers_per_s)},
                      {"shed_per_s", Figure(figures.shed_per_s)},
                      {"failed_per_s", Figure(figures.failed_per_s)},
                      {"p50_ms", Figure(figures.p50_ms)},
                      {"p99_ms", Figure(figures.p99_ms)},
                      {"queue_depth", Figure(figures.queue_depth)},
                      {"in_flight", Figure(figures.in_flight)},
                      {"processors", Figure(figures.processors)},
                      {"resident_bytes", Figure(figures.resident_bytes)},
                      {"stage_ms", std::move(stages)}});
  }
  const bool any = !report.course->points.empty();
  const scrape::ServerFigures last =
      any ? report.course->points.back().figures : scrape::ServerFigures{};
  return {{"url", report.metrics_url},
          {"missed", report.course->missed},
          {"last_error", report.course->last_error},
          {"version", last.version},
          {"workers", Figure(last.workers)},
          {"queue_capacity", Figure(last.queue_capacity)},
          {"points", std::move(points)}};
}

Json ConditionsJson(const std::vector<FailCondition>& conditions) {
  Json texts = Json::array();
  for (const FailCondition& condition : conditions) {
    texts.push_back(condition.text);
  }
  return texts;
}

std::string HistogramText(const LatencyHistogram& histogram) {
  return absl::StrFormat(
      "p50 %8.2f  p90 %8.2f  p99 %8.2f  p99.9 %8.2f  max %8.2f ms",
      histogram.Percentile_ms(50), histogram.Percentile_ms(90),
      histogram.Percentile_ms(99), histogram.Percentile_ms(99.9),
      histogram.max_ms());
}

void AppendHistogram(std::string& text, const char* name,
                     const LatencyHistogram& histogram) {
  if (histogram.count() == 0) return;
  absl::StrAppendFormat(&text, "  %-16s %s\n", name, HistogramText(histogram));
}

void AppendOutcomes(std::string& text, const TallyState& tally) {
  for (const auto& [key, latencies] : tally.outcomes) {
    if (key.first == absl::StatusCode::kOk) continue;
    const auto message = tally.messages.find(key);
    absl::StrAppendFormat(
        &text, "  %8d %s %s, from sending p50 %.2f, p99 %.2f ms\n",
        latencies.from_send.count(), absl::StatusCodeToString(key.first),
        !key.second.empty() ? key.second
        : message != tally.messages.end()
            ? absl::StrCat("(", message->second, ")")
            : "",
        latencies.from_send.Percentile_ms(50),
        latencies.from_send.Percentile_ms(99));
  }
}

void AppendChecks(std::string& text, const Checks& checks) {
  absl::StrAppendFormat(
      &text,
      "  answers: %d bit for bit as before the load, %d as the first under "
      "load, %d the first of their version, %d different\n",
      checks.as_before_load, checks.as_first_under_load,
      checks.first_of_a_version, checks.different);
  if (checks.with_truth > 0) {
    absl::StrAppendFormat(
        &text, "  poses: %d of %d within tolerance of the truth, %d wrong\n",
        checks.within_tolerance, checks.with_truth, checks.wrong_poses);
  }
}

std::string RunText(const LoadRun& run,
                    const std::vector<FailCondition>& conditions) {
  const TallyState& tally = run.tally;
  const auto count = [&](CallKind kind) {
    return tally.counts[static_cast<size_t>(kind)];
  };
  std::string text =
      run.options.rate_per_s > 0
          ? absl::StrFormat("open loop, %.1f/s", run.options.rate_per_s)
          : absl::StrFormat("closed loop, %d at a time",
                            run.options.concurrency);
  if (run.options.stream_window > 0) {
    absl::StrAppendFormat(&text, " with streams of %d frames",
                          run.options.stream_window);
  }
  absl::StrAppendFormat(
      &text,
      ", %.1f s%s\n  goodput %.1f/s: %d answered, %d shed, %d past the "
      "deadline, %d cancelled, %d failed\n",
      run.measured_s, run.interrupted ? " (interrupted)" : "",
      Goodput_per_s(run), count(CallKind::kOk), count(CallKind::kShed),
      count(CallKind::kDeadline), count(CallKind::kCancelled),
      count(CallKind::kFailed));
  AppendHistogram(
      text, "latency",
      tally.latencies[static_cast<size_t>(CallKind::kOk)].from_schedule);
  AppendHistogram(text, "server: queue", tally.server.queue);
  AppendHistogram(text, "decode", tally.server.decode);
  AppendHistogram(text, "sample", tally.server.sample);
  AppendHistogram(text, "forest", tally.server.forest);
  AppendHistogram(text, "pose", tally.server.pose);
  AppendHistogram(text, "  features", tally.server.features);
  AppendHistogram(text, "  verification", tally.server.verify);
  AppendHistogram(text, "outside it", tally.server.outside);
  AppendOutcomes(text, tally);
  AppendChecks(text, tally.checks);
  absl::StrAppendFormat(&text, "  the generator took %.2f processors",
                        run.generator_cpus);
  if (run.options.rate_per_s > 0) {
    absl::StrAppendFormat(&text, " and was %.2f ms late (p99)",
                          run.send_lag.Percentile_ms(99));
  }
  text.push_back('\n');
  if (run.saturated()) {
    absl::StrAppendFormat(
        &text,
        "  SATURATED: the generator could not keep its schedule (%d calls not "
        "sent); these figures are its own\n",
        run.not_sent);
  }
  for (const std::string& failure : Failures(conditions, run)) {
    absl::StrAppend(&text, "  FAILS: ", failure, "\n");
  }
  return text;
}

}  // namespace

std::vector<WorkloadSummary> Summarize(const std::vector<WorkItem>& items) {
  std::map<std::pair<std::string, std::string>, WorkloadSummary> parts;
  for (const WorkItem& item : items) {
    WorkloadSummary& part = parts[{item.scene, item.encoding}];
    part.scene = item.scene;
    part.encoding = item.encoding;
    ++part.queries;
    part.with_truth += item.world_from_camera.has_value();
    part.mean_bytes += static_cast<double>(item.request.Length());
  }
  std::vector<WorkloadSummary> summary;
  for (auto& [name, part] : parts) {
    part.mean_bytes /= part.queries;
    summary.push_back(std::move(part));
  }
  return summary;
}

double Goodput_per_s(const LoadRun& run) {
  if (run.measured_s <= 0) return 0;
  const int64_t right = run.tally.counts[static_cast<size_t>(CallKind::kOk)] -
                        run.tally.checks.different;
  return static_cast<double>(right) / run.measured_s;
}

std::string BenchJson(const BenchReport& report) {
  Json runs = Json::array();
  for (const LoadRun& run : report.runs) {
    runs.push_back(RunJson(run, report.conditions));
  }
  Json all_calls = Json::array();
  for (const auto& [key, count] : report.all_calls) {
    all_calls.push_back(
        {{"code", absl::StatusCodeToString(key.first)},
         {"reason", key.second.empty() ? Json(nullptr) : Json(key.second)},
         {"count", count}});
  }
  const Json json = {
      {"kind", "bench"},
      {"server", report.server},
      {"target", report.target},
      {"processes", report.processes},
      {"machine",
       {{"cpu", report.machine.cpu_model},
        {"cores", report.machine.cores},
        {"system", report.machine.system},
        {"load_average_before", report.load_before},
        {"load_average_after", report.load_after},
        {"client_version", report.machine.client_version},
        {"grpc_version", report.machine.grpc_version}}},
      {"workload", WorkloadJson(report.workload)},
      {"reference_answers", report.reference_answers < 0
                                ? Json(nullptr)
                                : Json(report.reference_answers)},
      {"capacity_per_s", report.capacity_per_s > 0
                             ? Json(Rounded(report.capacity_per_s))
                             : Json(nullptr)},
      {"fail_if", ConditionsJson(report.conditions)},
      {"runs", std::move(runs)},
      {"server_metrics", CourseJson(report)},
      {"all_calls", std::move(all_calls)}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace);
}

std::string BenchText(const BenchReport& report) {
  std::string text = absl::StrFormat(
      "%s, %d cores, load average %.2f\n", report.machine.cpu_model,
      report.machine.cores, report.load_before[0]);
  for (const WorkloadSummary& part : report.workload) {
    absl::StrAppendFormat(&text, "%s: %d queries as %s, %.0f kB each\n",
                          part.scene, part.queries, part.encoding,
                          part.mean_bytes * 1e-3);
  }
  if (report.capacity_per_s > 0) {
    absl::StrAppendFormat(&text, "capacity: %.1f/s\n", report.capacity_per_s);
  }
  for (const LoadRun& run : report.runs) {
    absl::StrAppend(&text, RunText(run, report.conditions));
  }
  if (report.course && report.course->missed > 0) {
    absl::StrAppendFormat(&text,
                          "the server's metrics were missed %d times: %s\n",
                          report.course->missed, report.course->last_error);
  }
  return text;
}

std::string LiveLine(const Glance& glance, double at_s) {
  const auto count = [&](CallKind kind) {
    return glance.counts[static_cast<size_t>(kind)];
  };
  if (at_s < 0) return absl::StrFormat("warming up, %.1f s left", -at_s);
  return absl::StrFormat(
      "%.1f s  %.1f/s  p50 %.1f ms  p99 %.1f ms  %d shed, %d late, %d failed",
      at_s, static_cast<double>(count(CallKind::kOk)) / std::max(at_s, 0.001),
      glance.p50_ms, glance.p99_ms, count(CallKind::kShed),
      count(CallKind::kDeadline), count(CallKind::kFailed));
}

}  // namespace treeline::bench
