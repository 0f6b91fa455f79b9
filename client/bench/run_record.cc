#include "client/bench/run_record.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "absl/strings/str_cat.h"
#include "nlohmann/json.hpp"

namespace treeline::bench {
namespace {

using Json = nlohmann::json;

Json ToJson(const LatencyHistogram& histogram) {
  const LatencyHistogram::Parts parts = histogram.ToParts();
  Json buckets = Json::array();
  for (const auto& [bucket, count] : parts.buckets) {
    buckets.push_back({bucket, count});
  }
  return {{"buckets", std::move(buckets)},
          {"sum_ms", parts.sum_ms},
          {"max_ms", parts.max_ms}};
}

// Throws what nlohmann does, as all that reads JSON here; ParseRunRecord
// catches it.
LatencyHistogram HistogramOf(const Json& json) {
  LatencyHistogram::Parts parts{
      .buckets = {}, .sum_ms = json.at("sum_ms"), .max_ms = json.at("max_ms")};
  for (const Json& bucket : json.at("buckets")) {
    parts.buckets[bucket.at(0).get<size_t>()] = bucket.at(1).get<int64_t>();
  }
  absl::StatusOr<LatencyHistogram> histogram =
      LatencyHistogram::FromParts(parts);
  if (!histogram.ok()) {
    throw Json::other_error::create(
        501, std::string(histogram.status().message()), nullptr);
  }
  return *std::move(histogram);
}

Json ToJson(const Latencies& latencies) {
  return {ToJson(latencies.from_schedule), ToJson(latencies.from_send)};
}
Latencies LatenciesOf(const Json& json) {
  return {.from_schedule = HistogramOf(json.at(0)),
          .from_send = HistogramOf(json.at(1))};
}

Json ToJson(const OutcomeKey& key) {
  return {static_cast<int>(key.first), key.second};
}
OutcomeKey KeyOf(const Json& json) {
  return {static_cast<absl::StatusCode>(json.at(0).get<int>()),
          json.at(1).get<std::string>()};
}

// The histograms of a split, in one order.
constexpr LatencyHistogram ServerSplit::*kSplit[] = {
    &ServerSplit::queue,    &ServerSplit::decode,  &ServerSplit::sample,
    &ServerSplit::forest,   &ServerSplit::pose,    &ServerSplit::localize,
    &ServerSplit::total,    &ServerSplit::outside, &ServerSplit::overhead,
    &ServerSplit::features, &ServerSplit::verify};
constexpr int64_t Checks::*kChecks[] = {
    &Checks::as_before_load,     &Checks::as_first_under_load,
    &Checks::first_of_a_version, &Checks::different,
    &Checks::with_truth,         &Checks::within_tolerance,
    &Checks::wrong_poses};

Json ToJson(const TallyState& tally) {
  Json json = {{"counts", tally.counts},
               {"localized", tally.localized},
               {"answered_by", tally.answered_by}};
  for (const Latencies& latencies : tally.latencies) {
    json["latencies"].push_back(ToJson(latencies));
  }
  json["outcomes"] = Json::array();
  for (const auto& [key, latencies] : tally.outcomes) {
    json["outcomes"].push_back({ToJson(key), ToJson(latencies)});
  }
  json["messages"] = Json::array();
  for (const auto& [key, message] : tally.messages) {
    json["messages"].push_back({ToJson(key), message});
  }
  for (const auto part : kSplit) {
    json["server"].push_back(ToJson(tally.server.*part));
  }
  for (const auto part : kChecks) json["checks"].push_back(tally.checks.*part);
  json["intervals"] = Json::array();
  for (const Interval& interval : tally.intervals) {
    json["intervals"].push_back({interval.counts, ToJson(interval.ok)});
  }
  return json;
}

TallyState TallyOf(const Json& json) {
  TallyState tally;
  tally.counts = json.at("counts").get<CallCounts>();
  tally.localized = json.at("localized");
  tally.answered_by =
      json.at("answered_by").get<std::map<std::string, int64_t>>();
  for (size_t i = 0; i < tally.latencies.size(); ++i) {
    tally.latencies[i] = LatenciesOf(json.at("latencies").at(i));
  }
  for (const Json& outcome : json.at("outcomes")) {
    tally.outcomes[KeyOf(outcome.at(0))] = LatenciesOf(outcome.at(1));
  }
  for (const Json& message : json.at("messages")) {
    tally.messages[KeyOf(message.at(0))] = message.at(1).get<std::string>();
  }
  for (size_t i = 0; i < std::size(kSplit); ++i) {
    tally.server.*kSplit[i] = HistogramOf(json.at("server").at(i));
  }
  for (size_t i = 0; i < std::size(kChecks); ++i) {
    tally.checks.*kChecks[i] = json.at("checks").at(i).get<int64_t>();
  }
  for (const Json& interval : json.at("intervals")) {
    tally.intervals.push_back({.counts = interval.at(0).get<CallCounts>(),
                               .ok = HistogramOf(interval.at(1))});
  }
  return tally;
}

RunRecord RecordOf(const Json& json) {
  RunRecord record;
  LoadRun& run = record.run;
  const Json& options = json.at("options");
  run.options = {.concurrency = options.at("concurrency"),
                 .stream_window = options.at("stream_window"),
                 .rate_per_s = options.at("rate_per_s"),
                 .duration_s = options.at("duration_s"),
                 .warm_up_s = options.at("warm_up_s"),
                 .deadline_ms = options.at("deadline_ms"),
                 .interval_s = options.at("interval_s")};
  run.measured_from = std::chrono::system_clock::time_point(
      std::chrono::microseconds(json.at("measured_from_us").get<int64_t>()));
  run.measured_s = json.at("measured_s");
  run.wall_s = json.at("wall_s");
  run.interrupted = json.at("interrupted");
  run.abandoned = json.at("abandoned");
  run.tally = TallyOf(json.at("tally"));
  run.not_sent = json.at("not_sent");
  run.send_lag = HistogramOf(json.at("send_lag"));
  run.generator_cpus = json.at("generator_cpus");
  for (const Json& calls : json.at("all_calls")) {
    record.all_calls[KeyOf(calls.at(0))] = calls.at(1).get<int64_t>();
  }
  return record;
}

void Add(const TallyState& from, TallyState& to) {
  const auto merge = [](const Latencies& more, Latencies& all) {
    all.from_schedule.Merge(more.from_schedule);
    all.from_send.Merge(more.from_send);
  };
  for (size_t i = 0; i < to.counts.size(); ++i) to.counts[i] += from.counts[i];
  to.localized += from.localized;
  for (size_t i = 0; i < to.latencies.size(); ++i) {
    merge(from.latencies[i], to.latencies[i]);
  }
  for (const auto& [key, latencies] : from.outcomes) {
    merge(latencies, to.outcomes[key]);
  }
  to.messages.insert(from.messages.begin(), from.messages.end());
  for (const auto part : kSplit) (to.server.*part).Merge(from.server.*part);
  for (const auto part : kChecks) to.checks.*part += from.checks.*part;
  to.intervals.resize(std::max(to.intervals.size(), from.intervals.size()));
  for (size_t i = 0; i < from.intervals.size(); ++i) {
    for (size_t kind = 0; kind < from.counts.size(); ++kind) {
      to.intervals[i].counts[kind] += from.intervals[i].counts[kind];
    }
    to.intervals[i].ok.Merge(from.intervals[i].ok);
  }
  for (const auto& [who, count] : from.answered_by) {
    to.answered_by[who] += count;
  }
}

}  // namespace

std::string WriteRunRecord(const RunRecord& record) {
  const LoadRun& run = record.run;
  Json all_calls = Json::array();
  for (const auto& [key, count] : record.all_calls) {
    all_calls.push_back({ToJson(key), count});
  }
  const Json json = {{"options",
                      {{"concurrency", run.options.concurrency},
                       {"stream_window", run.options.stream_window},
                       {"rate_per_s", run.options.rate_per_s},
                       {"duration_s", run.options.duration_s},
                       {"warm_up_s", run.options.warm_up_s},
                       {"deadline_ms", run.options.deadline_ms},
                       {"interval_s", run.options.interval_s}}},
                     {"measured_from_us",
                      std::chrono::duration_cast<std::chrono::microseconds>(
                          run.measured_from.time_since_epoch())
                          .count()},
                     {"measured_s", run.measured_s},
                     {"wall_s", run.wall_s},
                     {"interrupted", run.interrupted},
                     {"abandoned", run.abandoned},
                     {"tally", ToJson(run.tally)},
                     {"not_sent", run.not_sent},
                     {"send_lag", ToJson(run.send_lag)},
                     {"generator_cpus", run.generator_cpus},
                     {"all_calls", std::move(all_calls)}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

absl::StatusOr<RunRecord> ParseRunRecord(absl::string_view line) {
  try {
    return RecordOf(Json::parse(line.begin(), line.end()));
  } catch (const Json::exception& error) {
    return absl::InvalidArgumentError(
        absl::StrCat("no record of a run: ", error.what()));
  }
}

LoadRun MergeRuns(const std::vector<LoadRun>& runs) {
  LoadRun all = runs.front();
  for (size_t i = 1; i < runs.size(); ++i) {
    const LoadRun& run = runs[i];
    all.options.rate_per_s += run.options.rate_per_s;
    all.options.concurrency += run.options.concurrency;
    all.measured_from = std::min(all.measured_from, run.measured_from);
    all.measured_s = std::max(all.measured_s, run.measured_s);
    all.wall_s = std::max(all.wall_s, run.wall_s);
    all.interrupted = all.interrupted || run.interrupted;
    all.abandoned += run.abandoned;
    Add(run.tally, all.tally);
    all.not_sent += run.not_sent;
    all.send_lag.Merge(run.send_lag);
    all.generator_cpus += run.generator_cpus;
  }
  return all;
}

}  // namespace treeline::bench
