#include "nav_agent/bridge/topic_inputs/topic_inputs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "common/ros2/messages/common_messages.h"
#include "nav_agent/bridge/topic_inputs/topic_watch.h"

namespace treeline::topic_inputs {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// A node on which tests put samples.
class FakeNode final : public dds::Node {
 public:
  absl::StatusOr<std::unique_ptr<dds::Publisher>> Advertise(
      const std::string& /*topic*/, const std::string& /*message_name*/,
      const dds::Quality& /*quality*/) override {
    return absl::UnimplementedError("nobody publishes here");
  }
  absl::StatusOr<std::unique_ptr<dds::Subscription>> Subscribe(
      const std::string& topic, const std::string& /*message_name*/,
      const dds::Quality& /*quality*/) override {
    return std::make_unique<FakeSubscription>(topic, *this);
  }
  absl::StatusOr<std::unique_ptr<dds::Service>> Serve(
      const std::string& /*service*/,
      const std::string& /*service_type*/) override {
    return absl::UnimplementedError("not here");
  }
  bool Wait(std::chrono::nanoseconds /*at_most*/) override {
    return !samples.empty();
  }

  std::vector<dds::Sample> samples;
  int writers = 1;
  std::string why;

 private:
  class FakeSubscription final : public dds::Subscription {
   public:
    FakeSubscription(std::string topic, FakeNode& node)
        : topic_(std::move(topic)), node_(node) {}
    std::vector<dds::Sample> Take() override {
      return std::exchange(node_.samples, {});
    }
    int matched() const override { return node_.writers; }
    std::string WhyNobody() const override { return node_.why; }
    int64_t lost() const override { return 0; }
    const std::string& topic() const override { return topic_; }

   private:
    const std::string topic_;
    FakeNode& node_;
  };
};

class TopicInputsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto listen = [this](const messages::Header& header) {
      heard_.push_back(header.frame_id);
      return header.frame_id.empty() ? absl::InvalidArgumentError("no frame")
                                     : absl::OkStatus();
    };
    ASSERT_TRUE(
        inputs_.Subscribe<messages::Header>("headers", {}, listen).ok());
  }
  void Come(const std::string& frame_id) {
    node_.samples.push_back({.bytes = messages::Encode(messages::Header{
                                 .stamp = {}, .frame_id = frame_id}),
                             .written_ns = 0});
  }
  std::vector<TopicInputs::Fault> Deliver() {
    return inputs_.Deliver(std::chrono::nanoseconds(0));
  }

  FakeNode node_;
  TopicInputs inputs_{node_};
  std::vector<std::string> heard_;
};

TEST_F(TopicInputsTest, MessagesAreDecodedInTheirOrder) {
  Come("a");
  Come("b");
  EXPECT_TRUE(Deliver().empty());
  EXPECT_EQ(heard_, std::vector<std::string>({"a", "b"}));
  EXPECT_EQ(inputs_.delivered(), 2);
  EXPECT_EQ(inputs_.refused(), 0);
  EXPECT_GT(inputs_.Delivery_ms(0.5), 0);
}

TEST_F(TopicInputsTest, WhatIsRefusedIsCountedAndToldOnce) {
  for (int i = 0; i < 99; ++i) Come("");
  const auto faults = Deliver();
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].topic, "headers");
  EXPECT_EQ(faults[0].why.message(), "no frame");
  Come("");
  const auto again = Deliver();
  ASSERT_EQ(again.size(), 1U) << "it goes on";
  EXPECT_EQ(again[0].refused, 100);
  EXPECT_EQ(inputs_.refused(), 100);
  for (int i = 0; i < 899; ++i) Come("");
  EXPECT_TRUE(Deliver().empty());
  Come("");
  EXPECT_EQ(Deliver().size(), 1U);
}

TEST_F(TopicInputsTest, BytesThatAreNoMessageAreRefused) {
  Come("long enough");
  node_.samples[0].bytes.resize(14);
  const auto faults = Deliver();
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_THAT(std::string(faults[0].why.message()), HasSubstr("Header"));
  EXPECT_TRUE(heard_.empty());
}

TEST_F(TopicInputsTest, WhoIsMissingOrThereTwiceIsSaidOnce) {
  base::MonotonicTime now(std::chrono::hours(1));
  TopicWatch watch({"headers", "not there"}, /*tells_nobody=*/true);
  TopicWatch doubled({"headers"}, /*tells_nobody=*/false);
  const auto look = [&](TopicWatch& who) {
    now += std::chrono::seconds(3);
    return who.Look(inputs_, now);
  };
  node_.writers = 0;
  node_.why = "nobody publishes /headers";
  EXPECT_TRUE(watch.Look(inputs_, now).empty()) << "it may come yet";
  EXPECT_TRUE(doubled.Look(inputs_, now).empty());
  EXPECT_THAT(look(watch), ElementsAre("nobody publishes /headers"));
  EXPECT_THAT(look(watch), IsEmpty());
  EXPECT_THAT(look(doubled), IsEmpty());
  node_.why = "/headers is of type x";
  EXPECT_THAT(look(watch), ElementsAre("/headers is of type x"));
  node_.writers = 1;
  node_.why = "";
  EXPECT_THAT(look(watch), IsEmpty());
  node_.writers = 2;
  EXPECT_THAT(look(watch),
              ElementsAre(HasSubstr("2 programs publish headers")));
  EXPECT_THAT(look(doubled),
              ElementsAre(HasSubstr("2 programs publish headers")));
  EXPECT_EQ(inputs_.publishers("headers"), 2);
  EXPECT_EQ(inputs_.publishers("not there"), 0);
}

}  // namespace
}  // namespace treeline::topic_inputs
