// A service and clients of rmw_cyclonedds, played over loopback.
#include "nav_agent/bridge/dds/cyclone_service.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "nav_agent/bridge/dds/domain.h"
#include "nav_agent/bridge/dds/node.h"
#include "nav_agent/bridge/dds/testing_client.h"
#include "nav_agent/bridge/dds/testing_domain.h"

namespace treeline::dds {
namespace {

using Bytes = std::vector<uint8_t>;
constexpr char kName[] = "/robot1/ask";
constexpr char kType[] = "test_msgs/srv/Ask";

class CycloneServiceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto domain = Domain::Join({.id = TestingDomain(), .interface = "lo"});
    ASSERT_TRUE(domain.ok()) << domain.status();
    domain_ = *std::move(domain);
    auto node = Node::Create(
        *domain_, {.name_space = "robot1", .node = "a", .remappings = {}});
    ASSERT_TRUE(node.ok()) << node.status();
    node_ = *std::move(node);
    auto service = node_->Serve("ask", kType);
    ASSERT_TRUE(service.ok()) << service.status();
    service_ = *std::move(service);
  }

  // False: it did not come true within half a minute.
  template <typename Holds>
  bool Until(Holds holds) {
    for (int i = 0; i < 3000; ++i) {
      if (holds()) return true;
      node_->Wait(std::chrono::milliseconds(10));
    }
    return false;
  }
  std::optional<Request> Next() {
    std::vector<Request> requests;
    if (!Until([&] { return !(requests = service_->Take()).empty(); })) {
      return std::nullopt;
    }
    EXPECT_EQ(requests.size(), 1U);
    return requests[0];
  }

  std::unique_ptr<Domain> domain_;
  std::unique_ptr<Node> node_;
  std::unique_ptr<Service> service_;
};

// The header of serdata.hpp's cdds_request_header, byte by byte.
TEST_F(CycloneServiceTest, HeadersAreThoseOfRmwCyclonedds) {
  TestingClient client(*domain_, kName, kType);
  EXPECT_EQ(service_->name(), kName);
  ASSERT_TRUE(Until([&] { return client.IsMatched(); }));
  client.SendRaw(Bytes{0,  1, 0, 0,              // little-endian
                       1,  2, 3, 4, 5, 6, 7, 8,  // the client's number
                       9,  0, 0, 0, 0, 0, 0, 0,  // of its requests, the ninth
                       42, 0, 0, 0});
  const std::optional<Request> request = Next();
  ASSERT_TRUE(request.has_value());
  EXPECT_EQ(request->bytes, (Bytes{0, 1, 0, 0, 42, 0, 0, 0}));
  EXPECT_EQ(request->id.sequence, 9);
  ASSERT_TRUE(service_->Reply(request->id, Bytes{0, 1, 0, 0, 7, 7, 0, 0}).ok());
  std::vector<Bytes> replies;
  ASSERT_TRUE(Until([&] {
    service_->Take();
    return !(replies = client.TakeRawReplies()).empty();
  }));
  EXPECT_EQ(replies[0], (Bytes{0, 1, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8,
                               9, 0, 0, 0, 0, 0, 0, 0, 7, 7, 0, 0}));
}

// A client of the other byte order: what it compares is the number.
TEST_F(CycloneServiceTest, BigEndianNumbersAreTheSameNumbers) {
  TestingClient client(*domain_, kName, kType);
  ASSERT_TRUE(Until([&] { return client.IsMatched(); }));
  client.SendRaw(Bytes{0, 0, 0, 0, 8, 7, 6, 5, 4, 3, 2, 1,
                       0, 0, 0, 0, 0, 0, 0, 9, 0, 0, 0, 42});
  const std::optional<Request> request = Next();
  ASSERT_TRUE(request.has_value());
  EXPECT_EQ(request->id.sequence, 9);
  EXPECT_EQ(request->id.client[0], 1);
  EXPECT_EQ(request->bytes, (Bytes{0, 0, 0, 0, 0, 0, 0, 42}));
}

TEST_F(CycloneServiceTest, EachClientGetsItsOwnReply) {
  TestingClient first(*domain_, kName, kType, "clientid=1;");
  TestingClient second(*domain_, kName, kType, "clientid=2;");
  ASSERT_TRUE(Until([&] { return first.IsMatched() && second.IsMatched(); }));
  ASSERT_NE(first.number(), second.number());
  const int64_t a = first.Ask(Bytes{0, 1, 0, 0, 1, 0, 0, 0});
  const std::optional<Request> of_first = Next();
  const int64_t b = second.Ask(Bytes{0, 1, 0, 0, 2, 0, 0, 0});
  const std::optional<Request> of_second = Next();
  ASSERT_TRUE(of_first.has_value() && of_second.has_value());
  // In the other order than they asked.
  ASSERT_TRUE(service_->Reply(of_second->id, of_second->bytes).ok());
  ASSERT_TRUE(service_->Reply(of_first->id, of_first->bytes).ok());
  std::optional<Bytes> to_first;
  std::optional<Bytes> to_second;
  ASSERT_TRUE(Until([&] {
    service_->Take();
    to_first = first.ReplyTo(a);
    to_second = second.ReplyTo(b);
    return to_first.has_value() && to_second.has_value();
  }));
  EXPECT_EQ((*to_first)[4], 1);
  EXPECT_EQ((*to_second)[4], 2);
}

TEST_F(CycloneServiceTest, WhatIsNoRequestIsCountedAndLeftAlone) {
  // As Fast DDS's: without an id, and without a header.
  TestingClient other(*domain_, kName, kType, "");
  TestingClient client(*domain_, kName, kType);
  ASSERT_TRUE(Until([&] { return other.IsMatched() && client.IsMatched(); }));
  other.SendRaw(Bytes(64, 1));
  client.SendRaw(Bytes{0, 1, 0, 0, 1, 2, 3});
  client.SendRaw(Bytes{0, 1});
  client.SendRaw(Bytes{});
  client.Ask(Bytes{0, 1, 0, 0, 5, 0, 0, 0});
  const std::optional<Request> request = Next();
  ASSERT_TRUE(request.has_value());
  EXPECT_EQ(request->bytes[4], 5);
  EXPECT_TRUE(Until([&] {
    service_->Take();
    return service_->not_understood() >= 3;
  }));
  EXPECT_FALSE(service_->Reply(request->id, Bytes{0}).ok());
}

TEST_F(CycloneServiceTest, AClientThatIsGoneIsNotAnswered) {
  auto client = std::make_unique<TestingClient>(*domain_, kName, kType);
  ASSERT_TRUE(Until([&] { return client->IsMatched(); }));
  client->Ask(Bytes{0, 1, 0, 0, 5, 0, 0, 0});
  const std::optional<Request> request = Next();
  ASSERT_TRUE(request.has_value());
  client.reset();
  TestingClient later(*domain_, kName, kType, "clientid=later;");
  ASSERT_TRUE(Until([&] { return later.IsMatched(); }));
  EXPECT_TRUE(service_->Reply(request->id, request->bytes).ok());
  // Who came later is answered as before, and hears nothing else.
  const int64_t asked = later.Ask(Bytes{0, 1, 0, 0, 6, 0, 0, 0});
  const std::optional<Request> next = Next();
  ASSERT_TRUE(next.has_value());
  ASSERT_TRUE(service_->Reply(next->id, next->bytes).ok());
  std::optional<Bytes> reply;
  ASSERT_TRUE(Until([&] {
    service_->Take();
    return (reply = later.ReplyTo(asked)).has_value();
  }));
  EXPECT_EQ((*reply)[4], 6);
}

}  // namespace
}  // namespace treeline::dds
