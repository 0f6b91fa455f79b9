#include "nav_agent/bridge/foxglove/foxglove_protocol.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace treeline::foxglove {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

TEST(FoxgloveProtocolTest, TellsWhoItIsAndWhatThereIs) {
  const json info = json::parse(ServerInfoText("agent \xff", "7"));
  EXPECT_EQ(info["op"], "serverInfo");
  EXPECT_EQ(info["sessionId"], "7");
  EXPECT_TRUE(info["capabilities"].empty());

  const Channel channel = {
      .id = 3, .topic = "/pose", .schema_name = "a/msg/B", .schema = "int32 x"};
  const json advertised =
      json::parse(AdvertiseText(std::span<const Channel>(&channel, 1)));
  EXPECT_EQ(advertised["op"], "advertise");
  ASSERT_EQ(advertised["channels"].size(), 1U);
  EXPECT_EQ(advertised["channels"][0], json({{"id", 3},
                                             {"topic", "/pose"},
                                             {"encoding", "cdr"},
                                             {"schemaName", "a/msg/B"},
                                             {"schema", "int32 x"},
                                             {"schemaEncoding", "ros2msg"}}));
}

TEST(FoxgloveProtocolTest, AMessageBeginsWithItsSubscriptionAndTime) {
  const std::vector<uint8_t> message = {9, 8};
  EXPECT_EQ(MessageData(0x04030201, 0x1122334455667788, message),
            std::string("\x01\x01\x02\x03\x04\x88\x77\x66\x55\x44\x33\x22\x11"
                        "\x09\x08"));
}

TEST(FoxgloveProtocolTest, ReadsWhatIsSubscribedTo) {
  const auto request = ParseClientText(
      R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":5},)"
      R"({"id":4294967295,"channelId":1}]})");
  ASSERT_TRUE(request.ok()) << request.status();
  ASSERT_EQ(request->subscribe.size(), 2U);
  EXPECT_EQ(request->subscribe[0].channel, 5U);
  EXPECT_EQ(request->subscribe[1].id, 4294967295U);

  const auto less =
      ParseClientText(R"({"op":"unsubscribe","subscriptionIds":[7,8]})");
  ASSERT_TRUE(less.ok()) << less.status();
  EXPECT_EQ(less->unsubscribe, (std::vector<uint32_t>{7, 8}));
}

TEST(FoxgloveProtocolTest, RefusesWhatIsNotAsSpecified) {
  for (
      const char* text :
      {"", "[]", "{", "\xff\xfe", R"({"op":3})", R"({"op":"subscribe"})",
       R"({"op":"subscribe","subscriptions":{}})",
       R"({"op":"subscribe","subscriptions":[3]})",
       R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]})",
       R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":4294967296}]})",
       R"({"op":"subscribe","subscriptions":[{"id":1.5,"channelId":1}]})",
       R"({"op":"subscribe","subscriptions":[{"id":1}]})",
       R"({"op":"unsubscribe","subscriptionIds":["a"]})",
       R"({"op":"unsubscribe"})"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(ParseClientText(text).status()))
        << text;
  }
  // Nested as deep as a message may be.
  EXPECT_FALSE(ParseClientText(std::string(64 << 10, '[')).ok());
}

TEST(FoxgloveProtocolTest, NamesWhatItDoesNotOffer) {
  const auto request = ParseClientText(R"({"op":"setParameters"})");
  EXPECT_TRUE(absl::IsUnimplemented(request.status()));
  EXPECT_THAT(request.status().message(), HasSubstr("\"setParameters\""));
}

}  // namespace
}  // namespace treeline::foxglove
