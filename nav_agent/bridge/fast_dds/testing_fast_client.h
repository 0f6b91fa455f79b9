// A client of a service as rmw_fastrtps_cpp plays it, and a subscription, for
// tests: nothing in front of requests, and its reader named beside them.
#ifndef NAV_AGENT_BRIDGE_FAST_DDS_TESTING_FAST_CLIENT_H_
#define NAV_AGENT_BRIDGE_FAST_DDS_TESTING_FAST_CLIENT_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace treeline::fast_dds {

class TestingFastClient {
 public:
  // In a participant of its own, over loopback alone. service: "/robot1/ask".
  // Ends the program if Fast DDS does not work.
  TestingFastClient(int domain, const std::string& service,
                    const std::string& service_type);
  ~TestingFastClient();
  TestingFastClient(const TestingFastClient&) = delete;
  TestingFastClient& operator=(const TestingFastClient&) = delete;

  // The service was found, both ways.
  bool IsMatched() const;
  // Its number in sequence. names_reader: as ROS 2's clients do.
  int64_t Ask(std::span<const uint8_t> bytes, bool names_reader = true);
  // Nullopt: not yet. What is for other clients is left out.
  std::optional<std::vector<uint8_t>> ReplyTo(int64_t sequence);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

class TestingFastSubscription {
 public:
  // Likewise. topic: "/robot1/scan". It is reliable.
  TestingFastSubscription(int domain, const std::string& topic,
                          const std::string& message_name, bool is_latched);
  ~TestingFastSubscription();
  TestingFastSubscription(const TestingFastSubscription&) = delete;
  TestingFastSubscription& operator=(const TestingFastSubscription&) = delete;

  std::vector<std::vector<uint8_t>> Take();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace treeline::fast_dds

#endif  // NAV_AGENT_BRIDGE_FAST_DDS_TESTING_FAST_CLIENT_H_
