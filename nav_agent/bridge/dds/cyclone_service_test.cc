// A service and clients of rmw_cyclonedds, played over loopback.
#include "nav_agent/bridge/dds/cyclone_service.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <vector>

#include "nav_agent/bridge/dds/domain.h"
#include "nav_agent/bridge/dds/node.h"
#include "nav_agent/bridge/dds/testing_client.h"
#include "nav_agent/bridge/dds/testing_domain.h"
#include "nav_agent/bridge/dds/testing_service.h"

namespace treeline::dds {
namespace {

class CycloneServiceTest : public ServiceTest {
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

  void TearDown() override { service_.reset(); }

  std::unique_ptr<Domain> domain_;
  std::unique_ptr<Node> node_;
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
  ASSERT_NE(first.number(), second.number());
  EachGetsItsOwnReply(first, second);
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
  WhoIsGoneIsNotAnswered([this](int i) {
    return std::make_unique<TestingClient>(
        *domain_, kName, kType, i == 0 ? "clientid=1;" : "clientid=later;");
  });
}

}  // namespace
}  // namespace treeline::dds
