#include "common/metrics/registry.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"
#include "common/metrics/testing_exposition.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::metrics {
namespace {

using ::testing::ElementsAre;

auto Parsed(const Registry& registry) {
  auto parsed = ParseExposition(registry.Expose());
  EXPECT_TRUE(parsed.ok()) << parsed.status();
  return parsed.value();
}

TEST(Registry, ShowsWhatWasCounted) {
  Registry registry;
  auto& calls = registry.AddCounter("calls_total", "Calls.", {"rpc"});
  auto& waiting = registry.AddGauge("waiting", "Waiting.", {});
  auto& seconds = registry.AddHistogram("seconds", "Time.", {"rpc"}, {0.1, 1});
  registry.AddSource([](Exposition& out) {
    out.Family("elsewhere", "Elsewhere.", MetricType::kGauge);
    out.Sample({}, 9);
  });
  calls.With({"Localize"}).Add();
  calls.With({"Localize"}).Add(2);
  waiting.With({}).Set(-1.5);
  seconds.With({"Localize"}).Observe(0.1);
  const auto families = Parsed(registry);
  EXPECT_EQ(SampleOf(families, "calls_total{rpc=Localize}"), 3);
  EXPECT_EQ(SampleOf(families, "waiting"), -1.5);
  EXPECT_EQ(SampleOf(families, "seconds_bucket{le=0.1,rpc=Localize}"), 1);
  EXPECT_EQ(SampleOf(families, "elsewhere"), 9);
  EXPECT_EQ(families.at("calls_total").type, "counter");
}

TEST(Registry, FamiliesWithoutSamplesAreShownToo) {
  Registry registry;
  registry.AddCounter("calls_total", "Calls.", {"rpc"});
  EXPECT_TRUE(Parsed(registry).at("calls_total").samples.empty());
}

TEST(Histogram, BoundsBelongToTheirBucket) {
  Histogram histogram({1, 2});
  for (const double value : {-5.0, 1.0, 1.0000001, 2.0, 2.1, 1e300}) {
    histogram.Observe(value);
  }
  EXPECT_THAT(histogram.Counts().counts, ElementsAre(2, 2, 2));
}

TEST(Histogram, EachBucketKeepsItsLatestExemplar) {
  Histogram histogram({1, 2});
  EXPECT_TRUE(histogram.Counts().exemplars.empty());
  histogram.Observe(Exemplar{0.5, "a", 10});
  histogram.Observe(Exemplar{0.75, "b", 11});
  histogram.Observe(Exemplar{5, "c", 12});
  histogram.Observe(1.5);
  const HistogramCounts counts = histogram.Counts();
  EXPECT_THAT(counts.counts, ElementsAre(2, 1, 1));
  EXPECT_EQ(counts.sum, 7.75);
  ASSERT_EQ(counts.exemplars.size(), 3u);
  EXPECT_EQ(counts.exemplars[0]->trace_id, "b");
  EXPECT_FALSE(counts.exemplars[1].has_value());
  EXPECT_EQ(counts.exemplars[2]->value, 5);
}

TEST(Histogram, NanIsCountedAndSpoilsNoSum) {
  Histogram histogram({1});
  histogram.Observe(std::nan(""));
  histogram.Observe(0.5);
  EXPECT_THAT(histogram.Counts().counts, ElementsAre(1, 1));
  EXPECT_EQ(histogram.Counts().sum, 0.5);
}

// Against counting by hand.
TEST(Histogram, CountsLikeTheDefinition) {
  for (uint64_t round = 0; round < 50; ++round) {
    base::Random random(/*seed=*/5, round);
    std::vector<double> bounds;
    for (uint32_t i = random.NextBelow(6); i > 0; --i) {
      bounds.push_back(random.NextBelow(20));
    }
    std::sort(bounds.begin(), bounds.end());
    bounds.erase(std::unique(bounds.begin(), bounds.end()), bounds.end());
    Registry registry;
    Histogram& histogram =
        registry.AddHistogram("h", "H.", {}, bounds).With({});
    std::vector<double> values;
    double sum = 0;
    for (int i = 0; i < 100; ++i) {
      values.push_back(random.NextBelow(22));  // whole: sums are exact
      sum += values.back();
      histogram.Observe(values.back());
    }
    const auto families = Parsed(registry);
    for (const double bound : bounds) {
      EXPECT_EQ(SampleOf(families,
                         absl::StrCat("h_bucket{le=", NumberText(bound), "}")),
                std::count_if(values.begin(), values.end(),
                              [&](double value) { return value <= bound; }));
    }
    EXPECT_EQ(SampleOf(families, "h_bucket{le=+Inf}"), 100);
    EXPECT_EQ(SampleOf(families, "h_count"), 100);
    EXPECT_EQ(SampleOf(families, "h_sum"), sum);
  }
}

TEST(MetricFamily, GrowsToABoundAndLosesNothing) {
  Registry registry;
  auto& family = registry.AddCounter("calls_total", "Calls.", {"a", "b"});
  constexpr size_t kValues = 5000;
  for (size_t i = 0; i < kValues; ++i)
    family.With({absl::StrCat(i), "x"}).Add();
  const auto families = Parsed(registry);
  const auto& samples = families.at("calls_total").samples;
  EXPECT_EQ(samples.size(), MetricFamily<Counter>::kMaxSeries);
  double total = 0;
  for (const auto& [key, value] : samples) total += value;
  EXPECT_EQ(total, kValues);
  EXPECT_EQ(SampleOf(families, "calls_total{a=other,b=other}"),
            kValues - MetricFamily<Counter>::kMaxSeries + 1);
}

TEST(Registry, ManyThreadsLoseNothing) {
  Registry registry;
  auto& calls = registry.AddCounter("calls_total", "Calls.", {"n"});
  auto& seconds = registry.AddHistogram("seconds", "Time.", {}, {0.5});
  constexpr int kThreads = 4;
  constexpr int kEach = 5000;
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < kEach; ++i) {
        calls.With({absl::StrCat(i % 7)}).Add();
        seconds.With({}).Observe(t % 2);
        if (i % 1000 == 0) {
          EXPECT_TRUE(ParseExposition(registry.Expose()).ok());
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  const auto families = Parsed(registry);
  double total = 0;
  for (const auto& [key, value] : families.at("calls_total").samples) {
    total += value;
  }
  EXPECT_EQ(total, kThreads * kEach);
  EXPECT_EQ(SampleOf(families, "seconds_count"), kThreads * kEach);
  EXPECT_EQ(SampleOf(families, "seconds_sum"), kThreads / 2 * kEach);
}

}  // namespace
}  // namespace treeline::metrics
