#include "common/connect_rpc/connect_message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "common/connect_rpc/json_message.h"
#include "treeline/v1/navigation.pb.h"

namespace treeline::connect_rpc {
namespace {

using ::testing::HasSubstr;

TEST(ConnectFormat, IsToldByTheContentType) {
  EXPECT_EQ(ConnectFormatOf("Application/JSON; charset=utf-8"),
            (ConnectFormat{.is_json = true, .is_stream = false}));
  EXPECT_EQ(ConnectFormatOf("application/connect+proto"),
            (ConnectFormat{.is_json = false, .is_stream = true}));
  EXPECT_EQ(ConnectFormatOf("text/plain"), std::nullopt);
  EXPECT_EQ(ConnectFormatOf(""), std::nullopt);
  for (const char* type : {"application/json", "application/connect+json",
                           "application/proto", "application/connect+proto"}) {
    EXPECT_STREQ(ConnectFormatOf(type)->ContentType(), type);
  }
}

TEST(ConnectMessage, SurvivesBothFormats) {
  v1::RobotEvent event;
  event.set_number(7);
  event.set_text("a \"quoted\" word");
  for (const bool is_json : {false, true}) {
    const auto bytes = WriteConnectMessage(is_json, event);
    ASSERT_TRUE(bytes.ok()) << bytes.status();
    v1::RobotEvent read;
    EXPECT_TRUE(ParseConnectMessage(is_json, *bytes, read).ok());
    EXPECT_EQ(read.SerializeAsString(), event.SerializeAsString());
  }
}

TEST(ConnectMessage, RefusesOtherBytesAndNamesTheField) {
  v1::RobotEvent event;
  EXPECT_TRUE(absl::IsInvalidArgument(
      ParseConnectMessage(/*is_json=*/false, "\x08", event)));
  const absl::Status unknown =
      ParseConnectMessage(/*is_json=*/true, R"({"numbr":1})", event);
  EXPECT_TRUE(absl::IsInvalidArgument(unknown));
  EXPECT_THAT(std::string(unknown.message()), HasSubstr("numbr"));
}

// protobuf's parser takes single quotes, too: nothing may hide behind them.
TEST(ConnectMessage, RefusesMoreValuesThanARequestHasInAnyQuotes) {
  for (const char* key : {R"("poses")", "'poses'", R"('poses"')"}) {
    std::string json = std::string("{") + key + ":[";
    for (int i = 0; i < JsonLimits().max_values; ++i) json += "{},";
    json += "{}]}";
    v1::NavigateRequest request;
    const absl::Status status =
        ParseConnectMessage(/*is_json=*/true, json, request);
    EXPECT_THAT(std::string(status.message()), HasSubstr("20000 values"))
        << key;
  }
}

TEST(ConnectEnvelope, HoldsOneMessage) {
  using std::string_literals::operator""s;
  EXPECT_EQ(InEnvelope("abc"), "\0\0\0\0\3abc"s);
  EXPECT_EQ(OutOfEnvelope("\0\0\0\0\3abc"s).value(), "abc");
  EXPECT_EQ(OutOfEnvelope("\0\0\0\0\0"s).value(), "");
  for (const std::string& bad :
       {""s, "\0\0\0\0"s, "\0\0\0\0\3ab"s, "\0\0\0\0\3abcd"s,
        "\0\xff\xff\xff\xff"s, "\2\0\0\0\0"s}) {
    EXPECT_TRUE(absl::IsInvalidArgument(OutOfEnvelope(bad).status()))
        << bad.size();
  }
  EXPECT_TRUE(absl::IsUnimplemented(OutOfEnvelope("\1\0\0\0\0"s).status()));
}

TEST(ConnectEnvelope, TheLastOneSaysHowItEnded) {
  using std::string_literals::operator""s;
  EXPECT_EQ(EndOfConnectStream(absl::OkStatus()), "\2\0\0\0\2{}"s);
  const std::string end = EndOfConnectStream(absl::UnavailableError("stop"));
  EXPECT_EQ(end.substr(5),
            R"({"error":{"code":"unavailable","message":"stop"}})");
}

}  // namespace
}  // namespace treeline::connect_rpc
