#include "nav_agent/app/relocalization/recovery_trace.h"

#include <cstdint>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace treeline::relocalization {
namespace {

constexpr char kService[] = "treeline.v1.RelocalizationService";
constexpr char kMethod[] = "Localize";

// Of RelocalizationNote, which says "goes on" of other things too.
bool IsFound(const std::string& kind, const std::string& text) {
  return kind == "resume" && absl::StartsWith(text, "found after");
}

bool IsTold(const std::string& kind, const std::string& text) {
  return kind == "recovery" && text == "it was told where it is";
}

tracing::Attributes AttributesOf(const core::RelocalizationAnswer& answer) {
  tracing::Attributes attributes{
      {"treeline.scene", answer.scene},
      {"treeline.model_version", answer.model_version},
      {"treeline.outcome",
       std::string(answer.localized ? "LOCALIZED" : "NOT_LOCALIZED")},
      {"treeline.confidence", answer.confidence}};
  if (!answer.localized) {
    attributes.emplace_back("treeline.not_localized_reason", answer.reason);
  }
  return attributes;
}

}  // namespace

void RecoveryTrace::Stop() {
  const absl::MutexLock lock(&mutex_);
  EndQuestion({}, absl::CancelledError(""));
  EndRecovery("stopped", "");
}

tracing::Span RecoveryTrace::Ended(const Open& open, std::string name) const {
  tracing::Span span;
  span.context = open.context;
  span.parent_span_id = open.parent_span_id;
  span.name = std::move(name);
  span.start = open.start;
  span.end = wall_clock_();
  return span;
}

void RecoveryTrace::OnEvent(const std::string& kind, const std::string& text) {
  const absl::MutexLock lock(&mutex_);
  if (kind == "lost") {
    BeginRecovery(text);
  } else if (kind == "fix") {
    EndJudgement(text);
  } else if (kind == "check") {
    EndJudgement(text);
    EndRecovery("stays", text);
  } else if (kind == "help") {
    EndRecovery("needs help", text);
  } else if (IsFound(kind, text)) {
    EndRecovery("found", text);
  } else if (IsTold(kind, text)) {
    EndRecovery("told", text);
  }
}

void RecoveryTrace::BeginRecovery(const std::string& why) {
  EndRecovery("begins anew", "");
  recovery_ = Open{tracer_.Begin(std::nullopt), "", wall_clock_()};
  cause_ = why;
  questions_ = 0;
}

void RecoveryTrace::EndRecovery(const std::string& outcome,
                                const std::string& text) {
  if (!recovery_.has_value()) return;
  tracing::Span span = Ended(*recovery_, "recovery");
  span.attributes = {{"treeline.recovery.cause", cause_},
                     {"treeline.recovery.outcome", outcome},
                     {"treeline.recovery.questions", int64_t{questions_}}};
  if (!text.empty()) {
    span.attributes.emplace_back("treeline.recovery.text", text);
  }
  recovery_.reset();
  judgement_.reset();
  tracer_.End({std::move(span)});
}

std::string RecoveryTrace::BeginQuestion() {
  const absl::MutexLock lock(&mutex_);
  EndQuestion({}, absl::CancelledError(""));
  judgement_.reset();
  ++questions_;
  std::optional<tracing::TraceContext> parent;
  if (recovery_.has_value()) parent = recovery_->context;
  question_ = Open{tracer_.Begin(parent),
                   parent.has_value() ? parent->span_id : "", wall_clock_()};
  return tracing::Traceparent(question_->context);
}

void RecoveryTrace::EndQuestion(
    const absl::StatusOr<core::RelocalizationAnswer>& answer) {
  const absl::MutexLock lock(&mutex_);
  EndQuestion(answer.ok() ? AttributesOf(*answer) : tracing::Attributes(),
              answer.status());
}

void RecoveryTrace::CancelQuestion() {
  const absl::MutexLock lock(&mutex_);
  EndQuestion({}, absl::CancelledError(""));
}

void RecoveryTrace::EndQuestion(tracing::Attributes attributes,
                                const absl::Status& status) {
  if (!question_.has_value()) return;
  tracing::Span span = Ended(*question_, absl::StrCat(kService, "/", kMethod));
  span.kind = tracing::SpanKind::kClient;
  span.attributes = {
      {"rpc.system", std::string("grpc")},
      {"rpc.service", std::string(kService)},
      {"rpc.method", std::string(kMethod)},
      {"rpc.grpc.status_code", static_cast<int64_t>(status.code())}};
  for (auto& attribute : attributes) {
    span.attributes.push_back(std::move(attribute));
  }
  if (!status.ok()) {
    span.is_error = true;
    span.error = absl::StatusCodeToString(status.code());
    span.attributes.emplace_back("error.type", span.error);
  }
  // The verdict is a sibling: it is the robot's own, not the server's.
  const std::optional<tracing::TraceContext> parent =
      recovery_.has_value() ? recovery_->context : question_->context;
  judgement_ = Open{tracer_.Begin(parent), parent->span_id, span.end};
  question_.reset();
  tracer_.End({std::move(span)});
}

void RecoveryTrace::EndJudgement(const std::string& verdict) {
  if (!judgement_.has_value()) return;
  tracing::Span span = Ended(*judgement_, "fix gate");
  span.attributes = {{"treeline.fix.verdict", verdict}};
  judgement_.reset();
  tracer_.End({std::move(span)});
}

}  // namespace treeline::relocalization
