// A service and clients of rmw_fastrtps, played over loopback.
#include "nav_agent/bridge/fast_dds/fast_services.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "nav_agent/bridge/dds/testing_client.h"
#include "nav_agent/bridge/dds/testing_domain.h"
#include "nav_agent/bridge/fast_dds/testing_fast_client.h"

namespace treeline::fast_dds {
namespace {

using Bytes = std::vector<uint8_t>;
using dds::Request;
constexpr char kName[] = "/robot1/ask";
constexpr char kType[] = "test_msgs/srv/Ask";

class FastServicesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto services =
        FastServices::Join({.id = dds::TestingDomain(), .interface = "lo"},
                           {.name_space = "robot1", .remappings = {}});
    ASSERT_TRUE(services.ok()) << services.status();
    services_ = *std::move(services);
    auto service = services_->Serve("ask", kType);
    ASSERT_TRUE(service.ok()) << service.status();
    service_ = *std::move(service);
  }

  // False: it did not come true within half a minute.
  template <typename Holds>
  static bool Until(Holds holds) {
    for (int i = 0; i < 3000; ++i) {
      if (holds()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
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

  std::unique_ptr<FastServices> services_;
  std::unique_ptr<dds::Service> service_;
};

TEST_F(FastServicesTest, EachClientGetsItsOwnReply) {
  EXPECT_EQ(service_->name(), kName);
  TestingFastClient first(dds::TestingDomain(), kName, kType);
  TestingFastClient second(dds::TestingDomain(), kName, kType);
  ASSERT_TRUE(Until([&] { return first.IsMatched() && second.IsMatched(); }));
  const int64_t a = first.Ask(Bytes{0, 1, 0, 0, 1, 0, 0, 0});
  const std::optional<Request> of_first = Next();
  const int64_t b = second.Ask(Bytes{0, 1, 0, 0, 2, 0, 0, 0});
  const std::optional<Request> of_second = Next();
  ASSERT_TRUE(of_first.has_value() && of_second.has_value());
  // Nothing stands in front.
  EXPECT_EQ(of_first->bytes, (Bytes{0, 1, 0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(of_first->id.sequence, a);
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
  EXPECT_EQ(*to_first, (Bytes{0, 1, 0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(*to_second, (Bytes{0, 1, 0, 0, 2, 0, 0, 0}));
}

TEST_F(FastServicesTest, ARequestMayBeLargeOrShort) {
  TestingFastClient client(dds::TestingDomain(), kName, kType);
  ASSERT_TRUE(Until([&] { return client.IsMatched(); }));
  client.Ask(Bytes(200'000, 7));
  std::optional<Request> request = Next();
  ASSERT_TRUE(request.has_value());
  EXPECT_EQ(request->bytes.size(), 200'000U);
  client.Ask(Bytes{0, 1, 0, 0});
  request = Next();
  ASSERT_TRUE(request.has_value());
  EXPECT_EQ(request->bytes.size(), 4U);
  EXPECT_FALSE(service_->Reply(request->id, Bytes{0}).ok());
}

// Of rmw_cyclonedds, in a Cyclone DDS of its own.
TEST_F(FastServicesTest, WhoNamesNoReaderIsCountedAndLeftAlone) {
  auto domain =
      dds::Domain::Join({.id = dds::TestingDomain(), .interface = "lo"});
  ASSERT_TRUE(domain.ok()) << domain.status();
  dds::TestingClient other(**domain, kName, kType);
  TestingFastClient client(dds::TestingDomain(), kName, kType);
  ASSERT_TRUE(Until([&] { return other.IsMatched() && client.IsMatched(); }));
  other.Ask(Bytes{0, 1, 0, 0, 1, 0, 0, 0});
  client.Ask(Bytes{0, 1, 0, 0, 2, 0, 0, 0}, /*names_reader=*/false);
  client.Ask(Bytes{0, 1, 0, 0, 3, 0, 0, 0});
  const std::optional<Request> request = Next();
  ASSERT_TRUE(request.has_value());
  EXPECT_EQ(request->bytes[4], 3);
  EXPECT_TRUE(Until([&] {
    service_->Take();
    return service_->not_understood() == 2;
  }));
}

TEST_F(FastServicesTest, AClientThatIsGoneIsNotAnswered) {
  auto client =
      std::make_unique<TestingFastClient>(dds::TestingDomain(), kName, kType);
  ASSERT_TRUE(Until([&] { return client->IsMatched(); }));
  client->Ask(Bytes{0, 1, 0, 0, 5, 0, 0, 0});
  const std::optional<Request> request = Next();
  ASSERT_TRUE(request.has_value());
  client.reset();
  EXPECT_TRUE(service_->Reply(request->id, request->bytes).ok());
  TestingFastClient later(dds::TestingDomain(), kName, kType);
  ASSERT_TRUE(Until([&] { return later.IsMatched(); }));
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

TEST(FastServicesErrorsTest, TheySayWhatIsWrong) {
  EXPECT_EQ(
      FastServices::Join({.id = 233, .interface = ""}, {}).status().code(),
      absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(
      FastServices::Join({.id = 1, .interface = "nonet7"}, {}).status().code(),
      absl::StatusCode::kUnavailable);
  EXPECT_EQ(FastServices::Join({.id = 1, .interface = "lo"},
                               {.node = "a b", .remappings = {}})
                .status()
                .code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace treeline::fast_dds
