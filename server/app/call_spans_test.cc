#include "server/app/call_spans.h"

#include <chrono>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error_info.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/service/call.h"

namespace treeline::server_app {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using tracing::Span;

class Kept final : public tracing::SpanSink {
 public:
  void Add(std::vector<Span> spans) override {
    for (Span& span : spans) kept.push_back(std::move(span));
  }
  std::vector<Span> kept;
};

constexpr tracing::WallTime kEnd{std::chrono::hours(100)};

service::CallRecord Localized() {
  service::CallRecord record;
  record.rpc = "Localize";
  record.scene = "kitchen";
  record.model_version = "3";
  record.method = "rgbd";
  record.peer = "ipv4:10.1.2.3:4";
  record.client = "robot-7";
  record.trace = tracing::TraceContext{"0af7651916cd43dd8448eb211c80319c",
                                       "b7ad6b7169203331", true};
  record.span = tracing::TraceContext{"0af7651916cd43dd8448eb211c80319c",
                                      "1111111111111111", true};
  record.outcome = localizer::Outcome::kLocalized;
  record.world_from_camera = geometry::Rigid3();
  record.timings.queue_ms = 1;
  record.timings.decode_ms = 4;
  record.timings.localize.sample_ms = 2;
  record.timings.localize.forest_ms = 8;
  record.timings.localize.pose_ms = 16;
  record.timings.localize.features_ms = 5;
  record.timings.localize.verify_ms = 7;
  record.timings.total_ms = 32;
  return record;
}

class CallSpansTest : public testing::Test {
 protected:
  std::vector<Span> Of(const service::CallRecord& record) {
    sink_.kept.clear();
    spans_.OnCall(record);
    return sink_.kept;
  }
  static std::string Text(const Span& span, const std::string& name) {
    for (const auto& [key, value] : span.attributes) {
      if (key != name) continue;
      if (const auto* text = std::get_if<std::string>(&value)) return *text;
      if (const auto* number = std::get_if<int64_t>(&value)) {
        return std::to_string(*number);
      }
      return "of another type";
    }
    return "none";
  }

  Kept sink_;
  tracing::Tracer tracer_{sink_, {}, 5};
  CallSpans spans_{tracer_, [] { return kEnd; }};
};

TEST_F(CallSpansTest, ACallIsASpanAndEachStageAChild) {
  const std::vector<Span> spans = Of(Localized());
  ASSERT_EQ(spans.size(), 8u);
  const Span& call = spans[0];
  EXPECT_EQ(call.name, "treeline.v1.RelocalizationService/Localize");
  EXPECT_EQ(call.kind, tracing::SpanKind::kServer);
  EXPECT_EQ(call.context.span_id, "1111111111111111");
  EXPECT_EQ(call.parent_span_id, "b7ad6b7169203331");
  EXPECT_EQ(call.end, kEnd);
  EXPECT_EQ(call.start, kEnd - milliseconds(32));
  EXPECT_FALSE(call.is_error);
  std::vector<std::string> names;
  tracing::WallTime at = call.start;
  for (size_t i = 1; i < 6; ++i) {
    names.push_back(spans[i].name);
    EXPECT_EQ(spans[i].parent_span_id, call.context.span_id);
    EXPECT_EQ(spans[i].context.trace_id, call.context.trace_id);
    EXPECT_EQ(spans[i].start, at);
    at = spans[i].end;
  }
  EXPECT_THAT(names,
              ElementsAre("queue", "decode", "sample", "forest", "pose"));
  EXPECT_EQ(at, call.start + milliseconds(31));
}

TEST_F(CallSpansTest, APosesPartsAreItsChildren) {
  service::CallRecord record = Localized();
  std::vector<Span> spans = Of(record);
  ASSERT_EQ(spans.size(), 8u);
  const Span pose = spans[5];
  EXPECT_EQ(spans[6].name, "features");
  EXPECT_EQ(spans[6].parent_span_id, pose.context.span_id);
  EXPECT_EQ(spans[6].start, pose.start);
  EXPECT_EQ(spans[6].end, pose.start + milliseconds(5));
  EXPECT_EQ(spans[7].name, "verify");
  EXPECT_EQ(spans[7].parent_span_id, pose.context.span_id);
  EXPECT_EQ(spans[7].start, pose.end - milliseconds(7));
  EXPECT_EQ(spans[7].end, pose.end);
  // No part outlasts its pose, and what did not happen is no span.
  record.timings.localize.features_ms = 0;
  record.timings.localize.verify_ms = 100;
  spans = Of(record);
  ASSERT_EQ(spans.size(), 7u);
  EXPECT_EQ(spans[6].name, "verify");
  EXPECT_EQ(spans[6].start, spans[5].start);
}

TEST_F(CallSpansTest, AttributesAreThoseOfOpenTelemetry) {
  const Span call = Of(Localized())[0];
  EXPECT_EQ(Text(call, "rpc.system"), "grpc");
  EXPECT_EQ(Text(call, "rpc.service"), "treeline.v1.RelocalizationService");
  EXPECT_EQ(Text(call, "rpc.method"), "Localize");
  EXPECT_EQ(Text(call, "rpc.grpc.status_code"), "0");
  EXPECT_EQ(Text(call, "treeline.scene"), "kitchen");
  EXPECT_EQ(Text(call, "treeline.outcome"), "LOCALIZED");
  EXPECT_EQ(Text(call, "error.type"), "none");
  service::CallRecord record = Localized();
  record.transport = "http";
  record.status = absl::NotFoundError("no scene");
  record.rpc = "GetScene";
  const Span over_http = Of(record)[0];
  EXPECT_EQ(over_http.name, "treeline.v1.SceneService/GetScene");
  EXPECT_EQ(Text(over_http, "rpc.system"), "connect_rpc");
  EXPECT_EQ(Text(over_http, "rpc.connect_rpc.error_code"), "not_found");
  record.rpc = service::kGeoPoseRpc;
  EXPECT_EQ(Of(record)[0].name, "POST /geopose");
}

// Only what the answer says; never who asked, where from, or where it is.
TEST_F(CallSpansTest, NobodyAndNoPlaceIsNamed) {
  service::CallRecord record = Localized();
  record.status = base::WithReason(
      absl::InvalidArgumentError("s3cret of the client"), "INVALID_REQUEST");
  for (const Span& span : Of(record)) {
    for (const auto& [name, value] : span.attributes) {
      const auto* text = std::get_if<std::string>(&value);
      if (text == nullptr) continue;
      for (const char* secret : {"10.1.2.3", "robot-7", "s3cret"}) {
        EXPECT_EQ(text->find(secret), std::string::npos) << name;
      }
    }
    EXPECT_EQ(span.error.find("s3cret"), std::string::npos);
  }
}

TEST_F(CallSpansTest, ASceneThatNobodyKnowsIsNotNamed) {
  service::CallRecord record = Localized();
  record.model_version = "";
  EXPECT_EQ(Text(Of(record)[0], "treeline.scene"), "none");
}

TEST_F(CallSpansTest, OnlyTheServersFaultsAreErrors) {
  const std::vector<std::pair<absl::Status, bool>> cases = {
      {absl::InvalidArgumentError(""), false},
      {absl::NotFoundError(""), false},
      {absl::CancelledError(""), false},
      {absl::ResourceExhaustedError(""), false},
      {absl::UnavailableError(""), true},
      {absl::DeadlineExceededError(""), true},
      {absl::InternalError(""), true}};
  for (const auto& [status, is_error] : cases) {
    service::CallRecord record = Localized();
    record.outcome.reset();
    record.status = base::WithReason(status, "WHY");
    const std::vector<Span> spans = Of(record);
    ASSERT_EQ(spans.size(), 3u);
    EXPECT_EQ(spans[0].is_error, is_error) << status;
    EXPECT_EQ(Text(spans[0], "error.type"), "WHY");
  }
}

TEST_F(CallSpansTest, WhoIsTurnedAwayLeavesNoSpan) {
  service::CallRecord record = Localized();
  record.status = absl::UnauthenticatedError("");
  EXPECT_TRUE(Of(record).empty());
  record.status = absl::PermissionDeniedError("");
  EXPECT_TRUE(Of(record).empty());
  record = Localized();
  record.span->sampled = false;
  EXPECT_TRUE(Of(record).empty());
  record.span.reset();
  EXPECT_TRUE(Of(record).empty());
}

// The clocks that stages are measured by are not the one of the whole.
TEST_F(CallSpansTest, NoStageOutlastsItsCall) {
  service::CallRecord record = Localized();
  record.timings.total_ms = 10;
  record.timings.localize.sample_ms = -3;
  const std::vector<Span> spans = Of(record);
  for (const Span& span : spans) {
    EXPECT_GE(span.start, spans[0].start);
    EXPECT_LE(span.start, span.end);
    EXPECT_LE(span.end, spans[0].end);
  }
}

}  // namespace
}  // namespace treeline::server_app
