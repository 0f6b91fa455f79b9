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

http::HttpResponse WrongType(bool is_stream) {
  const ConnectFormat json{.is_json = true, .is_stream = is_stream};
  const ConnectFormat proto{.is_json = false, .is_stream = is_stream};
  http::HttpResponse response = ConnectErrorResponse(
      415, InvalidRequest(absl::StrCat("the content-type must be ",
                                       json.ContentType(), " or ",
                                       proto.ContentType())));
  response.headers.emplace_back(
      "Accept-Post",
      absl::StrCat(json.ContentType(), ", ", proto.ContentType()));
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

void ConnectRouter::AddUnimplemented(const std::string& path,
                                     absl::string_view why) {
  methods_[path].refusal = NoMethod(why);
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
  if (!method->second.refusal.ok()) {
    return ConnectErrorResponse(method->second.refusal);
  }
  const bool is_stream = method->second.response != nullptr;
  const auto format = ConnectFormatOf(request.Header("content-type"));
  if (!format.has_value() || format->is_stream != is_stream) {
    return WrongType(is_stream);
  }
  const absl::string_view version = request.Header("connect-protocol-version");
  if (version.empty() ? options_.require_protocol_version : version != "1") {
    return ConnectErrorResponse(InvalidRequest(
        version.empty() ? "the header 'Connect-Protocol-Version: 1' is missing"
                        : "connect-protocol-version: only 1 is known"));
  }
  return std::nullopt;
}

std::optional<http::HttpResponse> ConnectRouter::Admit(
    http::HttpRequest& request) const {
  const AdmitCall& admit = methods_.at(request.path).admit;
  if (admit == nullptr) return std::nullopt;
  const absl::Status admitted = admit(request);
  if (admitted.ok()) return std::nullopt;
  return ConnectErrorResponse(admitted);
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

absl::StatusOr<ConnectRouter::Parsed> ConnectRouter::Parse(
    const Method& method, bool is_json, absl::string_view bytes) const {
  Parsed parsed;
  TL_ASSIGN_OR_RETURN(parsed.lease,
                      LeaseForParsing(options_.budget, is_json, bytes.size()));
  parsed.message.reset(method.request->New());
  TL_RETURN_IF_ERROR(ParseConnectMessage(is_json, bytes, *parsed.message));
  // The message alone; the body is the server's.
  parsed.lease.Resize(bytes.size());
  return parsed;
}

absl::StatusOr<http::HttpResponse> ConnectRouter::Unary(
    const Method& method, const http::HttpRequest& request) const {
  const ConnectFormat format = *ConnectFormatOf(request.Header("content-type"));
  TL_ASSIGN_OR_RETURN(const base::MonotonicTime deadline,
                      ConnectDeadline(request));
  TL_ASSIGN_OR_RETURN(const Parsed parsed,
                      Parse(method, format.is_json, request.body));
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<Message> answer,
                      method.unary({.request = request, .deadline = deadline},
                                   *parsed.message));
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
  // Shared, for std::function copies what it calls.
  const auto parsed = std::make_shared<Parsed>();
  const absl::Status status = [&] {
    TL_ASSIGN_OR_RETURN(options.deadline, ConnectDeadline(request));
    TL_ASSIGN_OR_RETURN(const absl::string_view bytes,
                        OutOfEnvelope(request.body));
    TL_ASSIGN_OR_RETURN(*parsed, Parse(method, format.is_json, bytes));
    return absl::OkStatus();
  }();
  http::HttpResponse response{.content_type = format.ContentType()};
  if (!status.ok()) {
    // A stream's errors stand in its last envelope, whatever they are.
    response.body = EndOfConnectStream(status);
    return response;
  }
  response.stream = [this, &method, options,
                     parsed](http::HttpBodyWriter& writer) {
    writer.Write(EndOfConnectStream(
        RunStream(method, *parsed->message, options, writer)));
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
