#include "server/gateway/http_errors.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/error_info.h"
#include "common/wire/status.h"
#include "server/gateway/json_message.h"

namespace treeline::gateway {
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

// The Connect protocol leaves the padding away.
std::string UnpaddedBase64(const std::string& bytes) {
  std::string text = absl::Base64Escape(bytes);
  text.resize(std::min(text.size(), text.find('=')));
  return text;
}

nlohmann::json DetailsOf(const google::rpc::Status& status) {
  nlohmann::json details = nlohmann::json::array();
  for (const google::protobuf::Any& any : status.details()) {
    nlohmann::json detail;
    detail["type"] = std::string(absl::StripPrefix(
        absl::string_view(any.type_url()), "type.googleapis.com/"));
    detail["value"] = UnpaddedBase64(any.value());
    if (const auto readable = JsonFromMessage(any); readable.ok()) {
      nlohmann::json debug =
          nlohmann::json::parse(*readable, nullptr, /*allow_exceptions=*/false);
      if (debug.is_object()) {
        debug.erase("@type");
        detail["debug"] = std::move(debug);
      }
    }
    details.push_back(std::move(detail));
  }
  return details;
}

}  // namespace

int HttpStatusOf(absl::StatusCode code) { return RowOf(code).http; }

const char* ConnectCodeName(absl::StatusCode code) { return RowOf(code).name; }

http::HttpResponse ErrorResponse(const absl::Status& status) {
  return ErrorResponse(HttpStatusOf(status.code()), status);
}

http::HttpResponse ErrorResponse(int http_status, const absl::Status& status) {
  const google::rpc::Status proto = wire::ToProto(status);
  nlohmann::json body;
  body["code"] = ConnectCodeName(status.code());
  body["message"] = proto.message();
  if (proto.details_size() > 0) body["details"] = DetailsOf(proto);
  http::HttpResponse response{
      .status = http_status,
      .content_type = "application/json",
      // Messages may quote bytes of requests.
      .body =
          body.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)};
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

}  // namespace treeline::gateway
