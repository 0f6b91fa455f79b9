#include "common/connect_rpc/connect_router.h"

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "common/connect_rpc/connect_error.h"
#include "common/connect_rpc/connect_message.h"

namespace treeline::connect_rpc {
namespace {

// The protocol allows this many.
constexpr size_t kMaxTimeoutDigits = 10;

absl::Status NoMethod(absl::string_view message) {
  return base::WithReason(absl::UnimplementedError(message), "METHOD_UNKNOWN");
}

absl::Status InvalidRequest(absl::string_view message) {
  return base::WithReason(absl::InvalidArgumentError(message),
                          "INVALID_REQUEST");
}

http::HttpResponse WrongType(bool is_stream) {
  const char* types =
      is_stream ? "application/connect+json, application/connect+proto"
                : "application/json, application/proto";
  http::HttpResponse response = ConnectErrorResponse(
      415,
      InvalidRequest(absl::StrCat("the content-type must be one of ", types)));
  response.headers.emplace_back("Accept-Post", types);
  return response;
}

}  // namespace

absl::StatusOr<base::MonotonicTime> ConnectDeadline(
    const http::HttpRequest& request) {
  const absl::string_view timeout = request.Header("connect-timeout-ms");
  if (timeout.empty()) return base::MonotonicTime::max();
  int64_t milliseconds = 0;
  if (timeout.size() > kMaxTimeoutDigits ||
      !std::all_of(timeout.begin(), timeout.end(), absl::ascii_isdigit) ||
      !absl::SimpleAtoi(timeout, &milliseconds)) {
    return InvalidRequest(
        "connect-timeout-ms: not a number of milliseconds of up to 10 digits");
  }
  return request.arrival + std::chrono::milliseconds(milliseconds);
}

bool ConnectRouter::Owns(absl::string_view path) {
  return absl::StartsWith(path, "/treeline.v1.");
}

std::optional<http::HttpResponse> ConnectRouter::CheckHead(
    const http::HttpRequest& request) const {
  const auto method = methods_.find(request.path);
  if (method == methods_.end()) {
    return ConnectErrorResponse(404, NoMethod("no such method"));
  }
  if (request.method != "POST") {
    http::HttpResponse response =
        ConnectErrorResponse(405, NoMethod("calls are made with POST"));
    response.headers.emplace_back("Allow", "POST");
    return response;
  }
  const bool is_stream = method->second.response != nullptr;
  const auto format = ConnectFormatOf(request.Header("content-type"));
  if (!format.has_value() || format->is_stream != is_stream) {
    return WrongType(is_stream);
  }
  const absl::string_view version = request.Header("connect-protocol-version");
  if (version.empty() ? options_.require_protocol_version : version != "1") {
    return ConnectErrorResponse(
        InvalidRequest("the header 'Connect-Protocol-Version: 1' is missing"));
  }
  return std::nullopt;
}

http::HttpResponse ConnectRouter::Handle(
    const http::HttpRequest& request) const {
  if (request.body.size() > options_.max_request_bytes) {
    return ConnectErrorResponse(
        413, base::WithReason(
                 absl::ResourceExhaustedError(absl::StrCat(
                     "the body has ", request.body.size(),
                     " bytes; it may have ", options_.max_request_bytes)),
                 "REQUEST_TOO_LARGE"));
  }
  const Method& method = methods_.at(request.path);
  if (method.response != nullptr) return Stream(method, request);
  absl::StatusOr<http::HttpResponse> response = Unary(method, request);
  return response.ok() ? *std::move(response)
                       : ConnectErrorResponse(response.status());
}

absl::StatusOr<http::HttpResponse> ConnectRouter::Unary(
    const Method& method, const http::HttpRequest& request) const {
  const ConnectFormat format = *ConnectFormatOf(request.Header("content-type"));
  TL_ASSIGN_OR_RETURN(const base::MonotonicTime deadline,
                      ConnectDeadline(request));
  const std::unique_ptr<Message> message(method.request->New());
  TL_RETURN_IF_ERROR(
      ParseConnectMessage(format.is_json, request.body, *message));
  TL_ASSIGN_OR_RETURN(
      const std::unique_ptr<Message> answer,
      method.unary({.request = request, .deadline = deadline}, *message));
  TL_ASSIGN_OR_RETURN(std::string body,
                      WriteConnectMessage(format.is_json, *answer));
  return http::HttpResponse{.content_type = format.ContentType(),
                            .body = std::move(body)};
}

http::HttpResponse ConnectRouter::Stream(
    const Method& method, const http::HttpRequest& request) const {
  const ConnectFormat format = *ConnectFormatOf(request.Header("content-type"));
  ConnectStream::Options options{.is_json = format.is_json,
                                 .socket = request.socket,
                                 .heartbeat = options_.heartbeat};
  const std::shared_ptr<Message> message(method.request->New());
  const absl::Status parsed = [&] {
    TL_ASSIGN_OR_RETURN(options.deadline, ConnectDeadline(request));
    TL_ASSIGN_OR_RETURN(const absl::string_view bytes,
                        OutOfEnvelope(request.body));
    return ParseConnectMessage(format.is_json, bytes, *message);
  }();
  http::HttpResponse response{.content_type = format.ContentType()};
  if (!parsed.ok()) {
    // A stream's errors stand in its last envelope, whatever they are.
    response.body = EndOfConnectStream(parsed);
    return response;
  }
  response.stream = [this, &method, options,
                     message](http::HttpBodyWriter& writer) {
    writer.Write(
        EndOfConnectStream(RunStream(method, *message, options, writer)));
  };
  return response;
}

absl::Status ConnectRouter::RunStream(const Method& method,
                                      const Message& request,
                                      const ConnectStream::Options& options,
                                      http::HttpBodyWriter& writer) const {
  ConnectStream stream(options, writer, *method.response, clock_);
  absl::Status status = method.stream(request, stream);
  if (absl::IsCancelled(status) && stream.is_past_deadline()) {
    return base::WithReason(absl::DeadlineExceededError("the deadline passed"),
                            "DEADLINE_EXCEEDED");
  }
  return status;
}

}  // namespace treeline::connect_rpc
