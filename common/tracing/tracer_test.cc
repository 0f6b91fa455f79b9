#include "common/tracing/tracer.h"

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::tracing {
namespace {

class Kept final : public SpanSink {
 public:
  void Add(std::vector<Span> spans) override {
    for (Span& span : spans) kept.push_back(std::move(span));
  }
  std::vector<Span> kept;
};

TraceContext Caller(bool sampled) {
  return {"0af7651916cd43dd8448eb211c80319c", "b7ad6b7169203331", sampled};
}

TEST(Tracer, IdsAreThoseOfTheStandardAndNeverTheSame) {
  Kept sink;
  Tracer tracer(sink, {}, 5);
  Tracer other(sink, {}, 6);
  std::set<std::string> ids;
  for (int i = 0; i < 1000; ++i) {
    for (Tracer* made : {&tracer, &other}) {
      const TraceContext context = made->Begin(std::nullopt);
      ASSERT_TRUE(ParseTraceparent(Traceparent(context)).has_value());
      EXPECT_TRUE(ids.insert(context.trace_id).second);
      EXPECT_TRUE(ids.insert(context.span_id).second);
    }
  }
}

TEST(Tracer, AChildIsInItsParentsTrace) {
  Kept sink;
  Tracer tracer(sink, {}, 5);
  const TraceContext child = tracer.Begin(Caller(true));
  EXPECT_EQ(child.trace_id, Caller(true).trace_id);
  EXPECT_NE(child.span_id, Caller(true).span_id);
}

TEST(Tracer, CallersDecideOfTheirTraces) {
  Kept sink;
  Tracer none(sink, {.ratio = 0}, 5);
  Tracer all(sink, {.ratio = 1}, 5);
  EXPECT_TRUE(none.Begin(Caller(true)).sampled);
  EXPECT_FALSE(all.Begin(Caller(false)).sampled);
  EXPECT_FALSE(none.Begin(std::nullopt).sampled);
  EXPECT_TRUE(all.Begin(std::nullopt).sampled);
}

TEST(Tracer, WhereCallersAreNotFollowedTheIdDecides) {
  Kept sink;
  Tracer none(sink, {.ratio = 0, .follows_parent = false}, 5);
  Tracer all(sink, {.ratio = 1, .follows_parent = false}, 5);
  EXPECT_FALSE(none.Begin(Caller(true)).sampled);
  EXPECT_TRUE(all.Begin(Caller(false)).sampled);
}

// 4,000 draws of probability 0.3: 5 standard deviations are 0.036.
TEST(Tracer, TheShareIsMetAndEveryProgramAgrees) {
  Kept sink;
  Tracer tracer(sink, {.ratio = 0.3}, 5);
  int sampled = 0;
  for (int i = 0; i < 4000; ++i) {
    const TraceContext context = tracer.Begin(std::nullopt);
    sampled += context.sampled ? 1 : 0;
    EXPECT_EQ(context.sampled, IsInShare(context.trace_id, 0.3));
    // Whoever records more records this too.
    EXPECT_TRUE(!context.sampled || IsInShare(context.trace_id, 0.5));
  }
  EXPECT_NEAR(sampled / 4000.0, 0.3, 0.036);
}

TEST(Tracer, WhatIsNotSampledGoesNowhere) {
  Kept sink;
  Tracer tracer(sink, {}, 5);
  Span span;
  span.context = Caller(false);
  tracer.End({span});
  tracer.End({});
  EXPECT_TRUE(sink.kept.empty());
  span.context = Caller(true);
  tracer.End({span, span});
  EXPECT_EQ(sink.kept.size(), 2u);
}

}  // namespace
}  // namespace treeline::tracing
