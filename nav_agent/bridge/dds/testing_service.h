// What tests of services of every implementation of ROS 2 have in common.
#ifndef NAV_AGENT_BRIDGE_DDS_TESTING_SERVICE_H_
#define NAV_AGENT_BRIDGE_DDS_TESTING_SERVICE_H_

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "nav_agent/bridge/dds/service.h"

namespace treeline::dds {

// With a service named kName of the type kType, which the fixture of an
// implementation opens. Clients have IsMatched, Ask and ReplyTo, as
// TestingClient.
class ServiceTest : public ::testing::Test {
 protected:
  using Bytes = std::vector<uint8_t>;
  static constexpr char kName[] = "/robot1/ask";
  static constexpr char kType[] = "test_msgs/srv/Ask";

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
  // What comes back of a question; nullopt: nothing.
  template <typename Client>
  std::optional<Bytes> ReplyTo(Client& client, int64_t asked) {
    std::optional<Bytes> reply;
    Until([&] {
      service_->Take();
      return (reply = client.ReplyTo(asked)).has_value();
    });
    return reply;
  }

  // They are answered in the other order than they asked.
  template <typename Client>
  void EachGetsItsOwnReply(Client& first, Client& second) {
    ASSERT_TRUE(Until([&] { return first.IsMatched() && second.IsMatched(); }));
    const Bytes one = {0, 1, 0, 0, 1, 0, 0, 0};
    const Bytes two = {0, 1, 0, 0, 2, 0, 0, 0};
    const int64_t a = first.Ask(one);
    const std::optional<Request> of_first = Next();
    const int64_t b = second.Ask(two);
    const std::optional<Request> of_second = Next();
    ASSERT_TRUE(of_first.has_value() && of_second.has_value());
    EXPECT_EQ(of_first->bytes, one);
    EXPECT_EQ(of_first->id.sequence, a);
    ASSERT_TRUE(service_->Reply(of_second->id, of_second->bytes).ok());
    ASSERT_TRUE(service_->Reply(of_first->id, of_first->bytes).ok());
    EXPECT_EQ(ReplyTo(first, a), one);
    EXPECT_EQ(ReplyTo(second, b), two);
  }

  // make(i): the i-th client. Who comes later is answered as before, and hears
  // nothing else.
  template <typename Make>
  void WhoIsGoneIsNotAnswered(Make make) {
    auto client = make(0);
    ASSERT_TRUE(Until([&] { return client->IsMatched(); }));
    client->Ask(Bytes{0, 1, 0, 0, 5, 0, 0, 0});
    const std::optional<Request> request = Next();
    ASSERT_TRUE(request.has_value());
    client.reset();
    const auto later = make(1);
    ASSERT_TRUE(Until([&] { return later->IsMatched(); }));
    EXPECT_TRUE(service_->Reply(request->id, request->bytes).ok());
    const Bytes six = {0, 1, 0, 0, 6, 0, 0, 0};
    const int64_t asked = later->Ask(six);
    const std::optional<Request> next = Next();
    ASSERT_TRUE(next.has_value());
    ASSERT_TRUE(service_->Reply(next->id, next->bytes).ok());
    EXPECT_EQ(ReplyTo(*later, asked), six);
  }

  std::unique_ptr<Service> service_;
};

}  // namespace treeline::dds

#endif  // NAV_AGENT_BRIDGE_DDS_TESTING_SERVICE_H_
