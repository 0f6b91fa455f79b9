#include "server/app/service_metrics.h"

#include <unistd.h>

#include <map>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/random.h"
#include "common/metrics/testing_exposition.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/app/process_metrics.h"

namespace treeline::server_app {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

using Families = std::map<std::string, metrics::ParsedFamily>;

Families Parsed(const metrics::Registry& registry) {
  auto parsed = metrics::ParseExposition(registry.Expose());
  EXPECT_TRUE(parsed.ok()) << parsed.status();
  return parsed.value_or(Families());
}

double Total(const Families& families, const std::string& name) {
  double total = 0;
  for (const auto& [key, value] : families.at(name).samples) total += value;
  return total;
}

service::CallRecord Localized() {
  service::CallRecord record;
  record.rpc = "Localize";
  record.scene = "kitchen";
  record.model_version = "3";
  record.method = "rgbd";
  record.outcome = localizer::Outcome::kLocalized;
  record.inliers = 200;
  record.samples = 500;
  record.confidence = 0.97;
  record.request_bytes = 1000;
  record.timings.queue_ms = 0.1;
  record.timings.decode_ms = 4;
  record.timings.localize.sample_ms = 1;
  record.timings.localize.forest_ms = 2;
  record.timings.localize.pose_ms = 3;
  record.timings.total_ms = 11;
  return record;
}

service::CallRecord Failed(absl::Status status) {
  service::CallRecord record;
  record.rpc = "Localize";
  record.status = std::move(status);
  return record;
}

class ServiceMetricsTest : public testing::Test {
 protected:
  metrics::Registry registry_;
  ServiceMetrics metrics_{registry_};
};

TEST_F(ServiceMetricsTest, TimesOfRecordedTracesAreExemplars) {
  const auto open = [&] {
    return registry_.Expose(metrics::ExpositionFormat::kOpenMetrics);
  };
  service::CallRecord record = Localized();
  metrics_.OnCall(record);
  record.trace = tracing::TraceContext{"0af7651916cd43dd8448eb211c80319c",
                                       "b7ad6b7169203331", false};
  metrics_.OnCall(record);
  EXPECT_THAT(open(), Not(HasSubstr("trace_id")));
  // The caller's, where the server has none of its own.
  record.trace->sampled = true;
  metrics_.OnCall(record);
  EXPECT_THAT(open(), HasSubstr("le=\"0.025\"} 3 # {trace_id=\"0af7651916cd43"
                                "dd8448eb211c80319c\"} 0.011 "));
  record.span = tracing::TraceContext{"11111111111111111111111111111111",
                                      "b7ad6b7169203331", true};
  metrics_.OnCall(record);
  EXPECT_THAT(open(), Not(HasSubstr("0af7651916cd43")));
  EXPECT_THAT(open(),
              HasSubstr("treeline_stage_seconds_bucket{stage=\"forest\","
                        "method=\"rgbd\",status=\"OK\",le=\"0.0025\"} 4 # "
                        "{trace_id=\"11111111111111111111111111111111\"} "
                        "0.002 "));
}

TEST_F(ServiceMetricsTest, AnAnswerIsCountedInAllItsAspects) {
  metrics_.OnCall(Localized());
  const Families families = Parsed(registry_);
  const auto at = [&](const std::string& key) {
    return metrics::SampleOf(families, key);
  };
  EXPECT_EQ(at("treeline_requests_total{reason=none,rpc=Localize,status=OK,"
               "transport=grpc}"),
            1);
  EXPECT_EQ(at("treeline_request_seconds_bucket{le=0.025,rpc=Localize}"), 1);
  EXPECT_EQ(at("treeline_request_seconds_bucket{le=0.01,rpc=Localize}"), 0);
  EXPECT_EQ(at("treeline_request_seconds_sum{rpc=Localize}"), 0.011);
  EXPECT_EQ(at("treeline_outcomes_total{outcome=LOCALIZED,reason=NONE,"
               "scene=kitchen}"),
            1);
  EXPECT_EQ(at("treeline_inlier_ratio_sum{scene=kitchen}"), 0.4);
  EXPECT_EQ(at("treeline_confidence_sum{scene=kitchen}"), 0.97);
  EXPECT_EQ(at("treeline_request_bytes_total"), 1000);
  for (const char* stage :
       {"queue", "decode", "sample", "forest", "pose", "features", "verify"}) {
    EXPECT_EQ(at(absl::StrCat("treeline_stage_seconds_count{method=rgbd,stage=",
                              stage, ",status=OK}")),
              1)
        << stage;
  }
  EXPECT_EQ(at("treeline_stage_seconds_sum{method=rgbd,stage=pose,status=OK}"),
            0.003);
}

TEST_F(ServiceMetricsTest, ShedAndCancelledCallsAreCountedOnceEach) {
  service::CallRecord shed = Failed(
      base::WithReason(absl::UnavailableError("overloaded"), "QUEUE_FULL"));
  shed.shed = true;
  metrics_.OnCall(shed);
  metrics_.OnCall(Failed(absl::CancelledError("by the client")));
  const Families families = Parsed(registry_);
  EXPECT_EQ(
      metrics::SampleOf(families, "treeline_shed_total{reason=QUEUE_FULL}"), 1);
  EXPECT_EQ(Total(families, "treeline_shed_total"), 1);
  EXPECT_EQ(metrics::SampleOf(families, "treeline_cancelled_total"), 1);
  EXPECT_EQ(metrics::SampleOf(
                families,
                "treeline_requests_total{reason=QUEUE_FULL,rpc=Localize,"
                "status=UNAVAILABLE,transport=grpc}"),
            1);
  EXPECT_EQ(Total(families, "treeline_requests_total"), 2);
}

TEST_F(ServiceMetricsTest, WhatClientsChooseIsNoLabel) {
  for (int i = 0; i < 100; ++i) {
    service::CallRecord record =
        Failed(absl::NotFoundError(absl::StrCat("no scene 'evil", i, "'")));
    record.scene = absl::StrCat("evil", i);
    record.client = absl::StrCat("evil-client", i);
    record.peer = "evil-peer";
    metrics_.OnCall(record);
  }
  EXPECT_THAT(registry_.Expose(), Not(HasSubstr("evil")));
  EXPECT_EQ(Total(Parsed(registry_), "treeline_requests_total"), 100);
}

// Any mix of calls from any threads: the sums are those of the calls.
TEST_F(ServiceMetricsTest, EveryCallIsCountedExactlyOnce) {
  constexpr int kThreads = 4;
  constexpr int kEach = 1000;
  std::vector<std::thread> threads;
  for (uint64_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([this, t] {
      for (uint64_t i = 0; i < kEach; ++i) {
        base::Random random(/*seed=*/t, i);
        service::CallRecord record = Localized();
        if (random.NextBelow(2) == 0) {
          record = Failed(absl::Status(
              static_cast<absl::StatusCode>(1 + random.NextBelow(16)), "m"));
          record.shed = random.NextBelow(2) == 0;
        }
        record.transport = random.NextBelow(2) == 0 ? "grpc" : "http";
        metrics_.OnCall(record);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  const Families families = Parsed(registry_);
  EXPECT_EQ(Total(families, "treeline_requests_total"), kThreads * kEach);
  EXPECT_EQ(metrics::SampleOf(families,
                              "treeline_request_seconds_count{rpc=Localize}"),
            kThreads * kEach);
  double ok = 0;
  double cancelled = 0;
  for (const auto& [key, value] :
       families.at("treeline_requests_total").samples) {
    if (absl::StrContains(key, "status=OK")) ok += value;
    if (absl::StrContains(key, "status=CANCELLED")) cancelled += value;
  }
  EXPECT_EQ(Total(families, "treeline_outcomes_total"), ok);
  EXPECT_EQ(metrics::SampleOf(families, "treeline_cancelled_total"), cancelled);
}

TEST(LoadMetrics, AreAskedForWhenTheMetricsAre) {
  metrics::Registry registry;
  service::Load load;
  AddLoadMetrics(registry, [&] { return load; });
  load = {.queued = 3, .running = 2, .workers = 4, .queue_capacity = 64};
  const Families families = Parsed(registry);
  EXPECT_EQ(metrics::SampleOf(families, "treeline_queue_depth"), 3);
  EXPECT_EQ(metrics::SampleOf(families, "treeline_in_flight"), 2);
  EXPECT_EQ(metrics::SampleOf(families, "treeline_workers"), 4);
  EXPECT_EQ(metrics::SampleOf(families, "treeline_queue_capacity"), 64);
}

TEST(SceneMetrics, TellLoadsEvictionsMemoryAndStates) {
  metrics::Registry registry;
  AddSceneMetrics(registry, [] {
    RepositoryFigures figures;
    figures.scenes = {
        {.scene = "kitchen",
         .state = repository::SceneState::kReady,
         .resident_bytes = 5000,
         .loads = 2,
         .load_failures = 1,
         .evictions = 1},
        {.scene = "office", .state = repository::SceneState::kFailed}};
    figures.load_seconds = metrics::HistogramCounts{{0.1}, {2, 1}, 0.7};
    return figures;
  });
  const Families families = Parsed(registry);
  EXPECT_EQ(
      metrics::SampleOf(families,
                        "treeline_scene_loads_total{result=ok,scene=kitchen}"),
      2);
  EXPECT_EQ(
      metrics::SampleOf(
          families, "treeline_scene_loads_total{result=failed,scene=kitchen}"),
      1);
  EXPECT_EQ(metrics::SampleOf(families,
                              "treeline_scene_evictions_total{scene=kitchen}"),
            1);
  EXPECT_EQ(metrics::SampleOf(families,
                              "treeline_scene_resident_bytes{scene=kitchen}"),
            5000);
  EXPECT_EQ(metrics::SampleOf(families, "treeline_scenes{state=READY}"), 1);
  EXPECT_EQ(metrics::SampleOf(families, "treeline_scenes{state=FAILED}"), 1);
  EXPECT_EQ(metrics::SampleOf(families, "treeline_scenes{state=LOADING}"), 0);
  EXPECT_EQ(families.at("treeline_scenes").samples.size(), 4u);
  EXPECT_EQ(metrics::SampleOf(families, "treeline_scene_load_seconds_count"),
            3);
}

TEST(ProcessMetrics, AreThoseOfThisProcess) {
  metrics::Registry registry;
  AddProcessMetrics(registry);
  AddBuildInfo(registry, "1.2.3");
  const Families families = Parsed(registry);
  EXPECT_GT(metrics::SampleOf(families, "process_resident_memory_bytes"), 1e5);
  EXPECT_GT(metrics::SampleOf(families, "process_open_fds"), 2);
  EXPECT_GE(metrics::SampleOf(families, "process_threads"), 1);
  EXPECT_GT(metrics::SampleOf(families, "process_start_time_seconds"), 1e9);
  EXPECT_EQ(metrics::SampleOf(families, "treeline_build_info{version=1.2.3}"),
            1);
}

TEST(ProcessMetrics, TheNameOfTheProgramMayBeAnything) {
  ProcessStat stat;
  const std::string tail =
      "S 1 1 1 0 -1 4194560 100 0 0 0 150 50 0 0 20 0 7 0 1000 8192 3 0";
  ASSERT_TRUE(ParseProcessStat("12 (a) S 9 (b) " + tail, stat));
  EXPECT_EQ(stat.cpu_s, 200.0 / static_cast<double>(sysconf(_SC_CLK_TCK)));
  EXPECT_EQ(stat.threads, 7);
  EXPECT_EQ(stat.virtual_bytes, 8192);
  EXPECT_EQ(stat.resident_bytes,
            3.0 * static_cast<double>(sysconf(_SC_PAGESIZE)));
  EXPECT_FALSE(ParseProcessStat("12 (a) S 9", stat));
  EXPECT_FALSE(ParseProcessStat("", stat));
  EXPECT_FALSE(ParseProcessStat(")", stat));
}

}  // namespace
}  // namespace treeline::server_app
