#include "client/scrape/metrics_text.h"

#include <cmath>
#include <limits>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::scrape {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

constexpr const char* kText = R"(# HELP requests_total Of all kinds.
# TYPE requests_total counter
requests_total{rpc="Localize",status="OK"} 7
requests_total{rpc="Localize",status="NOT_FOUND"} 2 1700000000000
requests_total{rpc="GetScene",status="OK"} 1
up 1.5
odd{text="a \"quoted\" \\ line\nof, two} ="} -3e-2
seconds_bucket{rpc="Localize",le="0.01"} 50
seconds_bucket{rpc="Localize",le="0.02"} 90
seconds_bucket{rpc="Localize",le="+Inf"} 100
)";

TEST(MetricsSnapshot, SumsWhatHasTheLabels) {
  const auto snapshot = MetricsSnapshot::Parse(kText);
  ASSERT_TRUE(snapshot.ok()) << snapshot.status();
  EXPECT_EQ(snapshot->Sum("requests_total"), 10);
  EXPECT_EQ(snapshot->Sum("requests_total", {{"rpc", "Localize"}}), 9);
  EXPECT_EQ(
      snapshot->Sum("requests_total", {{"rpc", "Localize"}, {"status", "OK"}}),
      7);
  EXPECT_EQ(snapshot->Sum("requests_total", {{"verb", "GET"}}), 0);
  EXPECT_EQ(snapshot->Sum("up"), 1.5);
  EXPECT_EQ(snapshot->Sum("down"), 0);
  EXPECT_TRUE(snapshot->Has("up"));
  EXPECT_FALSE(snapshot->Has("down"));
  EXPECT_THAT(snapshot->SumBy("requests_total", "status"),
              ElementsAre(Pair("NOT_FOUND", 2), Pair("OK", 8)));
}

TEST(MetricsSnapshot, ReadsEscapes) {
  const auto snapshot = MetricsSnapshot::Parse(kText);
  ASSERT_TRUE(snapshot.ok()) << snapshot.status();
  EXPECT_THAT(snapshot->SumBy("odd", "text"),
              ElementsAre(Pair("a \"quoted\" \\ line\nof, two} =", -0.03)));
}

TEST(MetricsSnapshot, NamesTheLineThatIsNone) {
  for (const char* line : {"no value", "name{label=\"open} 1", "name{label} 1",
                           "name{a=\"b\" 1", "{a=\"b\"} 1", "name one",
                           "name 1 two", "name 1 2 3", "name{a=\"b\"c"}) {
    const auto snapshot = MetricsSnapshot::Parse(std::string("ok 1\n") + line);
    ASSERT_FALSE(snapshot.ok()) << line;
    EXPECT_THAT(std::string(snapshot.status().message()), HasSubstr("line 2"));
  }
}

TEST(HistogramQuantile, IsLinearWithinABucket) {
  const auto snapshot = MetricsSnapshot::Parse(kText);
  ASSERT_TRUE(snapshot.ok()) << snapshot.status();
  const auto buckets = snapshot->Buckets("seconds");
  EXPECT_THAT(buckets, ElementsAre(Pair(0.01, 50), Pair(0.02, 90),
                                   Pair(kInfinity, 100)));
  EXPECT_DOUBLE_EQ(HistogramQuantile(0.25, buckets), 0.005);
  EXPECT_DOUBLE_EQ(HistogramQuantile(0.7, buckets), 0.015);
  // Beyond the last bound nothing more is known.
  EXPECT_DOUBLE_EQ(HistogramQuantile(0.99, buckets), 0.02);
  EXPECT_TRUE(std::isnan(HistogramQuantile(0.5, {})));
  EXPECT_TRUE(std::isnan(HistogramQuantile(0.5, {{1, 0}, {kInfinity, 0}})));
}

}  // namespace
}  // namespace treeline::scrape
