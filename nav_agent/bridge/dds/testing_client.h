// A client of a service as rmw_cyclonedds_cpp plays it, for tests: with its
// header in front of requests, and its id in its user data.
#ifndef NAV_AGENT_BRIDGE_DDS_TESTING_CLIENT_H_
#define NAV_AGENT_BRIDGE_DDS_TESTING_CLIENT_H_

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "nav_agent/bridge/dds/cyclone_parts.h"
#include "nav_agent/bridge/dds/domain.h"

namespace treeline::dds {

class TestingClient {
 public:
  // In a participant of its own. service: "/robot1/ask". user_data: what
  // stands beside its endpoints; ROS 2's Fast DDS writes none. Ends the test's
  // program if DDS does not work.
  TestingClient(const Domain& domain, const std::string& service,
                const std::string& service_type,
                const std::string& user_data = "clientid= 1.2.3;");

  // The service was found, both ways.
  bool IsMatched() const;
  // Its number in sequence.
  int64_t Ask(std::span<const uint8_t> bytes);
  void SendRaw(std::span<const uint8_t> bytes);
  // As they came, header and all.
  std::vector<std::vector<uint8_t>> TakeRawReplies();
  // The reply to a request, without the header; nullopt: not yet.
  std::optional<std::vector<uint8_t>> ReplyTo(int64_t sequence);

  // In its headers.
  uint64_t number() const { return number_; }

 private:
  Entity participant_;
  Entity waitset_;
  RawTopic request_topic_;
  RawTopic reply_topic_;
  Entity writer_;
  Entity reader_;
  uint64_t number_ = 0;
  int64_t asked_ = 0;
  std::map<int64_t, std::vector<uint8_t>> replies_;
};

}  // namespace treeline::dds

#endif  // NAV_AGENT_BRIDGE_DDS_TESTING_CLIENT_H_
