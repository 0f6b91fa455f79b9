#include "nav_agent/bridge/topic_inputs/topic_inputs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "common/ros2/messages/common_messages.h"

namespace treeline::topic_inputs {
namespace {

using ::testing::HasSubstr;

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
    return std::make_unique<FakeSubscription>(topic, samples);
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

 private:
  class FakeSubscription final : public dds::Subscription {
   public:
    FakeSubscription(std::string topic, std::vector<dds::Sample>& samples)
        : topic_(std::move(topic)), samples_(samples) {}
    std::vector<dds::Sample> Take() override {
      return std::exchange(samples_, {});
    }
    int matched() const override { return 1; }
    int64_t lost() const override { return 0; }
    const std::string& topic() const override { return topic_; }

   private:
    const std::string topic_;
    std::vector<dds::Sample>& samples_;
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
}

TEST_F(TopicInputsTest, BytesThatAreNoMessageAreRefused) {
  Come("long enough");
  node_.samples[0].bytes.resize(14);
  const auto faults = Deliver();
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_THAT(std::string(faults[0].why.message()), HasSubstr("Header"));
  EXPECT_TRUE(heard_.empty());
}

}  // namespace
}  // namespace treeline::topic_inputs
