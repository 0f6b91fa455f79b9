#include "server/app/recording_dispatcher.h"

#include <google/protobuf/util/json_util.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"
#include "common/base/error_info.h"
#include "common/tracing/trace_context.h"
#include "server/repository/names.h"

namespace treeline::server_app {
namespace {

using Json = nlohmann::ordered_json;
using Trace = std::optional<tracing::TraceContext>;

std::string Text(absl::string_view text) { return std::string(text); }

std::string JsonOf(const v1::LocalizeRequest& request,
                   const std::string& reason,
                   const absl::StatusOr<v1::LocalizeResponse>& answer,
                   const Trace& trace) {
  Json json;
  json["scene"] = Text(
      absl::string_view(request.scene()).substr(0, repository::kLongestName));
  json["reason"] = reason;
  json["status"] = Text(absl::StatusCodeToString(answer.status().code()));
  if (!answer.ok()) json["message"] = Text(answer.status().message());
  if (trace.has_value()) {
    json["trace_id"] = trace->trace_id;
    json["span_id"] = trace->span_id;
  }
  if (answer.ok()) {
    std::string response;
    google::protobuf::util::JsonPrintOptions options;
    options.preserve_proto_field_names = true;
    if (google::protobuf::util::MessageToJsonString(*answer, &response, options)
            .ok()) {
      json["response"] = Json::parse(response, nullptr, false);
    }
  }
  return json.dump(2, ' ', true, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::string ReasonToRecord(const absl::StatusOr<v1::LocalizeResponse>& answer) {
  if (!answer.ok()) {
    if (!absl::IsInvalidArgument(answer.status()) &&
        !absl::IsInternal(answer.status())) {
      return "";
    }
    const std::string reason = base::ErrorInfoOf(answer.status()).reason;
    return reason.empty()
               ? Text(absl::StatusCodeToString(answer.status().code()))
               : reason;
  }
  if (answer->outcome() == v1::OUTCOME_LOCALIZED) return "";
  const std::string name = v1::NotLocalizedReason_Name(answer->reason());
  return Text(absl::StripPrefix(name, "NOT_LOCALIZED_REASON_"));
}

void RecordingDispatcher::Record(
    const v1::LocalizeRequest& request,
    const absl::StatusOr<v1::LocalizeResponse>& answer, const Trace& trace) {
  std::string reason = ReasonToRecord(answer);
  if (reason.empty() || !recorder_.HasRoomFor(request.ByteSizeLong())) return;
  std::string json = JsonOf(request, reason, answer, trace);
  recorder_.Offer({.reason = std::move(reason),
                   .request = request.SerializeAsString(),
                   .json = std::move(json)});
}

void RecordingDispatcher::Localize(service::CallInfo call,
                                   const v1::LocalizeRequest& request,
                                   Done<v1::LocalizeResponse> done) {
  if (call.rpc == absl::string_view(service::kGeoPoseRpc)) {
    inner_.Localize(std::move(call), request, std::move(done));
    return;
  }
  Trace trace = tracing::ParseTraceparent(call.traceparent);
  if (tracer_ != nullptr) {
    trace = tracer_->Begin(trace);
    call.span = trace;
  }
  inner_.Localize(
      std::move(call), request,
      [this, &request, trace = std::move(trace),
       done = std::move(done)](absl::StatusOr<v1::LocalizeResponse> answer) {
        Record(request, answer, trace);
        done(std::move(answer));
      });
}

void RecordingDispatcher::ListScenes(service::CallInfo call,
                                     const v1::ListScenesRequest& request,
                                     Done<v1::ListScenesResponse> done) {
  inner_.ListScenes(std::move(call), request, std::move(done));
}

void RecordingDispatcher::GetScene(service::CallInfo call,
                                   const v1::GetSceneRequest& request,
                                   Done<v1::GetSceneResponse> done) {
  inner_.GetScene(std::move(call), request, std::move(done));
}

void RecordingDispatcher::LoadScene(service::CallInfo call,
                                    const v1::LoadSceneRequest& request,
                                    Done<v1::LoadSceneResponse> done) {
  inner_.LoadScene(std::move(call), request, std::move(done));
}

void RecordingDispatcher::UnloadScene(service::CallInfo call,
                                      const v1::UnloadSceneRequest& request,
                                      Done<v1::UnloadSceneResponse> done) {
  inner_.UnloadScene(std::move(call), request, std::move(done));
}

}  // namespace treeline::server_app
