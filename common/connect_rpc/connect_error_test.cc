#include "common/connect_rpc/connect_error.h"

#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "common/base/error_info.h"

namespace treeline::connect_rpc {
namespace {

using Json = nlohmann::json;

TEST(ConnectError, HasTheProtocolsNamesAndStatuses) {
  EXPECT_STREQ(ConnectCode(absl::StatusCode::kCancelled), "canceled");
  EXPECT_EQ(ConnectHttpStatus(absl::StatusCode::kCancelled), 499);
  EXPECT_EQ(ConnectHttpStatus(absl::StatusCode::kFailedPrecondition), 400);
  EXPECT_EQ(ConnectHttpStatus(absl::StatusCode::kUnavailable), 503);
  EXPECT_STREQ(ConnectCode(static_cast<absl::StatusCode>(99)), "unknown");
}

TEST(ConnectError, HasTheDetailsOfTheStatus) {
  const absl::Status status = base::WithRetryAfter(
      base::WithReason(absl::ResourceExhaustedError("later"), "TOO_MANY"),
      std::chrono::milliseconds(1500));
  const http::HttpResponse response = ConnectErrorResponse(status);
  EXPECT_EQ(response.status, 429);
  EXPECT_EQ(
      response.headers,
      (std::vector<std::pair<std::string, std::string>>{{"Retry-After", "2"}}));
  const Json json = Json::parse(response.body);
  EXPECT_EQ(json["code"], "resource_exhausted");
  EXPECT_EQ(json["message"], "later");
  EXPECT_EQ(json["details"][0]["type"], "google.rpc.ErrorInfo");
  EXPECT_EQ(json["details"][0]["debug"]["reason"], "TOO_MANY");
}

TEST(ConnectError, IsJsonInOneLineWhateverTheMessage) {
  const std::string json =
      ConnectErrorJson(absl::InternalError("\xff\"\n<script>"));
  EXPECT_EQ(Json::parse(json)["message"], "\xEF\xBF\xBD\"\n<script>");
  EXPECT_EQ(json.find('\n'), std::string::npos);
}

}  // namespace
}  // namespace treeline::connect_rpc
