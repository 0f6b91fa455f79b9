#include "client/cli/client_tracing.h"

#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/base/error_info.h"
#include "common/base/version.h"

namespace treeline::client_cli {
namespace {

constexpr char kService[] = "treeline.v1.RelocalizationService";

std::map<std::string, std::string> OtelVariables() {
  std::map<std::string, std::string> variables;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const absl::string_view text = *entry;
    const size_t equals = text.find('=');
    if (absl::StartsWith(text, "OTEL_") && equals != absl::string_view::npos) {
      variables.emplace(text.substr(0, equals), text.substr(equals + 1));
    }
  }
  return variables;
}

void Say(absl::string_view message) {
  std::fprintf(stderr, "treeline-client: %s\n", std::string(message).c_str());
}

}  // namespace

ClientTracing::ClientTracing() {
  if (const char* parent = std::getenv("TRACEPARENT")) {
    parent_ = tracing::ParseTraceparent(parent);
  }
  const tracing::TracingOptions options = tracing::OptionsFromEnvironment(
      OtelVariables(), "treeline-client", base::Version());
  for (const std::string& warning : options.warnings) Say(warning);
  if (!options.enabled()) return;
  auto started = tracing::Tracing::Start(
      options, base::Version(), tracing::SeedOfProcess(),
      [](const absl::Status& health) {
        if (!health.ok()) {
          Say(absl::StrCat("traces are not sent: ", health.message()));
        }
      });
  if (started.ok()) {
    tracing_ = *std::move(started);
  } else {
    Say(started.status().message());
  }
}

ClientTracing::~ClientTracing() {
  if (tracing_ != nullptr) tracing_->Stop(tracing::Tracing::kPatience);
}

TracedCall::TracedCall(ClientTracing& tracing)
    : tracing_(tracing), context_(tracing.parent_) {
  if (tracing_.tracing_ == nullptr) return;
  context_ = tracing_.tracing_->tracer().Begin(tracing_.parent_);
  span_.start = std::chrono::system_clock::now();
}

std::string TracedCall::traceparent() const {
  return context_.has_value() ? tracing::Traceparent(*context_) : "";
}

void TracedCall::End(
    const absl::StatusOr<relocalizer::LocalizeAnswer>& answer) {
  if (answer.ok()) {
    span_.attributes.emplace_back("treeline.scene", answer->scene);
    span_.attributes.emplace_back(
        "treeline.outcome", answer->localized ? "LOCALIZED" : "NOT_LOCALIZED");
    if (!answer->localized) {
      span_.attributes.emplace_back("treeline.not_localized_reason",
                                    answer->reason);
    }
  }
  Finish("Localize", answer.status());
}

void TracedCall::EndStream(const absl::Status& status) {
  Finish("LocalizeStream", status);
}

void TracedCall::Finish(const char* method, const absl::Status& status) {
  if (tracing_.tracing_ == nullptr) return;
  span_.end = std::chrono::system_clock::now();
  span_.context = *context_;
  if (tracing_.parent_.has_value()) {
    span_.parent_span_id = tracing_.parent_->span_id;
  }
  span_.name = absl::StrCat(kService, "/", method);
  span_.kind = tracing::SpanKind::kClient;
  span_.attributes.emplace_back("rpc.system", "grpc");
  span_.attributes.emplace_back("rpc.service", kService);
  span_.attributes.emplace_back("rpc.method", method);
  span_.attributes.emplace_back("rpc.grpc.status_code",
                                static_cast<int64_t>(status.code()));
  if (!status.ok()) {
    span_.is_error = true;
    span_.error = base::ErrorInfoOf(status).reason;
    span_.attributes.emplace_back("error.type",
                                  span_.error.empty()
                                      ? absl::StatusCodeToString(status.code())
                                      : span_.error);
  }
  tracing_.tracing_->tracer().End({std::move(span_)});
}

}  // namespace treeline::client_cli
