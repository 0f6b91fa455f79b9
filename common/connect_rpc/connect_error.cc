#include "common/connect_rpc/connect_error.h"

#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/error_info.h"
#include "common/wire/status.h"

namespace treeline::connect_rpc {
namespace {

struct CodeRow {
  absl::StatusCode code;
  const char* name;
  int http;
};

constexpr CodeRow kUnknown{absl::StatusCode::kUnknown, "unknown", 500};
constexpr CodeRow kCodes[] = {
    {absl::StatusCode::kCancelled, "canceled", 499},
    kUnknown,
    {absl::StatusCode::kInvalidArgument, "invalid_argument", 400},
    {absl::StatusCode::kDeadlineExceeded, "deadline_exceeded", 504},
    {absl::StatusCode::kNotFound, "not_found", 404},
    {absl::StatusCode::kAlreadyExists, "already_exists", 409},
    {absl::StatusCode::kPermissionDenied, "permission_denied", 403},
    {absl::StatusCode::kResourceExhausted, "resource_exhausted", 429},
    {absl::StatusCode::kFailedPrecondition, "failed_precondition", 400},
    {absl::StatusCode::kAborted, "aborted", 409},
    {absl::StatusCode::kOutOfRange, "out_of_range", 400},
    {absl::StatusCode::kUnimplemented, "unimplemented", 501},
    {absl::StatusCode::kInternal, "internal", 500},
    {absl::StatusCode::kUnavailable, "unavailable", 503},
    {absl::StatusCode::kDataLoss, "data_loss", 500},
    {absl::StatusCode::kUnauthenticated, "unauthenticated", 401},
};

const CodeRow& RowOf(absl::StatusCode code) {
  const auto* row =
      std::find_if(std::begin(kCodes), std::end(kCodes),
                   [&](const CodeRow& each) { return each.code == code; });
  return row == std::end(kCodes) ? kUnknown : *row;
}

// The protocol leaves the padding away.
std::string UnpaddedBase64(const std::string& bytes) {
  std::string text = absl::Base64Escape(bytes);
  text.resize(std::min(text.size(), text.find('=')));
  return text;
}

// `any` as an object without its type; null where it has no JSON.
nlohmann::json ReadableOf(const google::protobuf::Any& any) {
  std::string text;
  if (!google::protobuf::util::MessageToJsonString(any, &text).ok()) return {};
  nlohmann::json readable =
      nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!readable.is_object()) return {};
  readable.erase("@type");
  return readable;
}

nlohmann::json DetailsOf(const google::rpc::Status& status) {
  nlohmann::json details = nlohmann::json::array();
  for (const google::protobuf::Any& any : status.details()) {
    nlohmann::json detail;
    detail["type"] = std::string(absl::StripPrefix(
        absl::string_view(any.type_url()), "type.googleapis.com/"));
    detail["value"] = UnpaddedBase64(any.value());
    nlohmann::json readable = ReadableOf(any);
    if (!readable.is_null()) detail["debug"] = std::move(readable);
    details.push_back(std::move(detail));
  }
  return details;
}

}  // namespace

absl::Status InvalidRequest(absl::string_view message) {
  return base::WithReason(absl::InvalidArgumentError(message),
                          "INVALID_REQUEST");
}

int ConnectHttpStatus(absl::StatusCode code) { return RowOf(code).http; }

const char* ConnectCode(absl::StatusCode code) { return RowOf(code).name; }

std::string ConnectErrorJson(const absl::Status& status) {
  const google::rpc::Status proto = wire::ToProto(status);
  nlohmann::json body;
  body["code"] = ConnectCode(status.code());
  body["message"] = proto.message();
  if (proto.details_size() > 0) body["details"] = DetailsOf(proto);
  // Messages may quote bytes of requests.
  return body.dump(-1, ' ', /*ensure_ascii=*/false,
                   nlohmann::json::error_handler_t::replace);
}

http::HttpResponse ConnectErrorResponse(const absl::Status& status) {
  return ConnectErrorResponse(ConnectHttpStatus(status.code()), status);
}

http::HttpResponse ConnectErrorResponse(int http_status,
                                        const absl::Status& status) {
  http::HttpResponse response{.status = http_status,
                              .content_type = "application/json",
                              .body = ConnectErrorJson(status)};
  if (const auto retry_after = base::RetryAfterOf(status)) {
    const auto seconds = std::max<int64_t>(
        1, std::chrono::ceil<std::chrono::seconds>(*retry_after).count());
    response.headers.emplace_back("Retry-After", absl::StrCat(seconds));
  }
  if (http_status == 401) {
    response.headers.emplace_back("WWW-Authenticate", "Bearer");
  }
  return response;
}

}  // namespace treeline::connect_rpc
