#include "common/tracing/trace_context.h"

#include <string>

#include "gtest/gtest.h"

namespace treeline::tracing {
namespace {

// The standard's own example.
constexpr char kExample[] =
    "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01";

TEST(TraceContext, ReadsItsParts) {
  const auto context = ParseTraceparent(kExample);
  ASSERT_TRUE(context.has_value());
  EXPECT_EQ(context->trace_id, "0af7651916cd43dd8448eb211c80319c");
  EXPECT_EQ(context->span_id, "b7ad6b7169203331");
  EXPECT_TRUE(context->sampled);
}

TEST(TraceContext, IsWrittenAsItIsRead) {
  EXPECT_EQ(Traceparent(*ParseTraceparent(kExample)), kExample);
  std::string header = kExample;
  header.replace(53, 2, "00");
  EXPECT_EQ(Traceparent(*ParseTraceparent(header)), header);
}

TEST(TraceContext, OnlyTheLastFlagMeansSampled) {
  std::string header = kExample;
  header.replace(53, 2, "fe");
  EXPECT_FALSE(ParseTraceparent(header)->sampled);
  header.replace(53, 2, "ff");
  EXPECT_TRUE(ParseTraceparent(header)->sampled);
}

TEST(TraceContext, WhatIsAllZerosIsNone) {
  std::string trace = kExample;
  trace.replace(3, 32, std::string(32, '0'));
  EXPECT_FALSE(ParseTraceparent(trace).has_value());
  std::string span = kExample;
  span.replace(36, 16, std::string(16, '0'));
  EXPECT_FALSE(ParseTraceparent(span).has_value());
}

TEST(TraceContext, OtherVersionsAreNone) {
  for (const char* version : {"01", "ff", "0 ", "cc"}) {
    std::string header = kExample;
    header.replace(0, 2, version);
    EXPECT_FALSE(ParseTraceparent(header).has_value()) << version;
  }
}

TEST(TraceContext, OtherLengthsAreNone) {
  const std::string header = kExample;
  for (size_t length = 0; length < header.size(); ++length) {
    EXPECT_FALSE(ParseTraceparent(header.substr(0, length)).has_value());
  }
  EXPECT_FALSE(ParseTraceparent(header + "0").has_value());
  EXPECT_FALSE(
      ParseTraceparent(header + "-what-the-future-brings").has_value());
  EXPECT_FALSE(ParseTraceparent(" " + header).has_value());
}

// No place takes a byte that could do harm in a log, not even upper case.
TEST(TraceContext, EveryPlaceTakesItsOwnBytesOnly) {
  for (size_t at = 0; at < std::string(kExample).size(); ++at) {
    for (int byte = 0; byte < 256; ++byte) {
      std::string header = kExample;
      header[at] = static_cast<char>(byte);
      const bool is_digit =
          (byte >= '0' && byte <= '9') || (byte >= 'a' && byte <= 'f');
      const bool is_fixed = at < 3 || at == 35 || at == 52;
      const bool fits = is_fixed ? header[at] == kExample[at] : is_digit;
      EXPECT_EQ(ParseTraceparent(header).has_value(), fits)
          << "byte " << byte << " at " << at;
    }
  }
}

}  // namespace
}  // namespace treeline::tracing
