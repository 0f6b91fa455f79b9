#include "nav_agent/app/relocalization/recovery_trace.h"

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::relocalization {
namespace {

using tracing::Span;

class Kept final : public tracing::SpanSink {
 public:
  void Add(std::vector<Span> spans) override {
    for (Span& span : spans) kept.push_back(std::move(span));
  }
  std::vector<Span> kept;
};

class RecoveryTraceTest : public testing::Test {
 protected:
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const Span& span : sink_.kept) names.push_back(span.name);
    return names;
  }
  static std::string Text(const Span& span, const std::string& name) {
    for (const auto& [key, value] : span.attributes) {
      if (key == name) return std::get<std::string>(value);
    }
    return "none";
  }
  static core::RelocalizationAnswer Answer() {
    core::RelocalizationAnswer answer;
    answer.localized = true;
    answer.scene = "house";
    return answer;
  }

  Kept sink_;
  int64_t now_s_ = 1000;
  tracing::Tracer tracer_{sink_, {}, 5};
  // Each look at the clock is a second later.
  RecoveryTrace trace_{
      tracer_,
      [this] { return tracing::WallTime(std::chrono::seconds(now_s_++)); }};
};

TEST_F(RecoveryTraceTest, ARecoveryIsOneTrace) {
  trace_.OnEvent("lost", "the scans do not fit");
  const auto sent = tracing::ParseTraceparent(trace_.BeginQuestion());
  ASSERT_TRUE(sent.has_value());
  trace_.EndQuestion(Answer());
  trace_.OnEvent("fix", "sure: explained 0.9 of 80 beams");
  trace_.OnEvent("fix", "two views agree");
  trace_.OnEvent("recovery", "takes 1, 2");
  trace_.OnEvent("resume", "goes on");
  trace_.OnEvent("resume", "found after 3.0 s and 1 questions");
  ASSERT_THAT(Names(),
              testing::ElementsAre("treeline.v1.RelocalizationService/Localize",
                                   "fix gate", "recovery"));
  const Span& question = sink_.kept[0];
  const Span& gate = sink_.kept[1];
  const Span& recovery = sink_.kept[2];
  EXPECT_EQ(question.context.span_id, sent->span_id);
  EXPECT_EQ(question.kind, tracing::SpanKind::kClient);
  EXPECT_EQ(recovery.parent_span_id, "");
  for (const Span* child : {&question, &gate}) {
    EXPECT_EQ(child->parent_span_id, recovery.context.span_id);
    EXPECT_EQ(child->context.trace_id, recovery.context.trace_id);
    EXPECT_GE(child->start, recovery.start);
    EXPECT_LE(child->end, recovery.end);
  }
  EXPECT_EQ(gate.start, question.end);
  EXPECT_EQ(Text(gate, "treeline.fix.verdict"),
            "sure: explained 0.9 of 80 beams");
  EXPECT_EQ(Text(recovery, "treeline.recovery.cause"), "the scans do not fit");
  EXPECT_EQ(Text(recovery, "treeline.recovery.outcome"), "found");
}

TEST_F(RecoveryTraceTest, EveryEndIsAnEnd) {
  const std::vector<std::vector<std::string>> ends = {
      {"help", "say where it is", "needs help"},
      {"check", "it stays where it thought it was", "stays"},
      {"recovery", "it was told where it is", "told"},
      {"lost", "by order", "begins anew"}};
  for (const auto& end : ends) {
    sink_.kept.clear();
    trace_.OnEvent("lost", "why");
    trace_.OnEvent(end[0], end[1]);
    ASSERT_FALSE(sink_.kept.empty());
    EXPECT_EQ(Text(sink_.kept.back(), "treeline.recovery.outcome"), end[2]);
  }
  sink_.kept.clear();
  trace_.BeginQuestion();
  trace_.Stop();
  ASSERT_EQ(sink_.kept.size(), 2u);
  EXPECT_TRUE(sink_.kept[0].is_error);
  EXPECT_EQ(Text(sink_.kept[1], "treeline.recovery.outcome"), "stopped");
  trace_.Stop();
  EXPECT_EQ(sink_.kept.size(), 2u);
}

TEST_F(RecoveryTraceTest, AQuestionOfARobotThatIsNotLostIsATraceOfItsOwn) {
  trace_.BeginQuestion();
  trace_.EndQuestion(Answer());
  trace_.OnEvent("check", "as the wheels say");
  ASSERT_EQ(sink_.kept.size(), 2u);
  EXPECT_EQ(sink_.kept[0].parent_span_id, "");
  EXPECT_EQ(sink_.kept[1].parent_span_id, sink_.kept[0].context.span_id);
}

TEST_F(RecoveryTraceTest, QuestionsThatFailSayHow) {
  trace_.OnEvent("lost", "why");
  trace_.BeginQuestion();
  trace_.EndQuestion(absl::UnavailableError("no server"));
  trace_.BeginQuestion();
  trace_.CancelQuestion();
  trace_.CancelQuestion();
  trace_.BeginQuestion();
  trace_.BeginQuestion();
  ASSERT_EQ(sink_.kept.size(), 3u);
  EXPECT_EQ(Text(sink_.kept[0], "error.type"), "UNAVAILABLE");
  EXPECT_EQ(Text(sink_.kept[1], "error.type"), "CANCELLED");
  EXPECT_EQ(Text(sink_.kept[2], "error.type"), "CANCELLED");
}

}  // namespace
}  // namespace treeline::relocalization
