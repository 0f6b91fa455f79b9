// A service and clients of rmw_fastrtps, played over loopback.
#include "nav_agent/bridge/fast_dds/fast_services.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <vector>

#include "nav_agent/bridge/dds/testing_client.h"
#include "nav_agent/bridge/dds/testing_domain.h"
#include "nav_agent/bridge/dds/testing_service.h"
#include "nav_agent/bridge/fast_dds/testing_fast_client.h"

namespace treeline::fast_dds {
namespace {

using Bytes = std::vector<uint8_t>;
using dds::Request;

class FastServicesTest : public dds::ServiceTest {
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

  void TearDown() override { service_.reset(); }

  std::unique_ptr<FastServices> services_;
};

TEST_F(FastServicesTest, EachClientGetsItsOwnReply) {
  TestingFastClient first(dds::TestingDomain(), kName, kType);
  TestingFastClient second(dds::TestingDomain(), kName, kType);
  EXPECT_EQ(service_->name(), kName);
  EachGetsItsOwnReply(first, second);
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
  WhoIsGoneIsNotAnswered([](int /*i*/) {
    return std::make_unique<TestingFastClient>(dds::TestingDomain(), kName,
                                               kType);
  });
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
