// Where this process's nodes meet others: a domain of DDS and its network.
#ifndef NAV_AGENT_BRIDGE_DDS_DOMAIN_H_
#define NAV_AGENT_BRIDGE_DDS_DOMAIN_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/statusor.h"

namespace treeline::dds {

struct DomainOptions {
  // ROS_DOMAIN_ID; [0, 232].
  int id = 0;
  // The network interface to use alone: "lo", "eth0". With "lo" nothing is sent
  // by multicast, and others on this machine are found by asking each.
  // "": what the environment's CYCLONEDDS_URI says, else Cyclone's choice.
  std::string interface = {};
};

// `wanted`, or, if that is -1, what ROS_DOMAIN_ID says: nullptr or "" is 0.
// INVALID_ARGUMENT if it is no number.
absl::StatusOr<int> DomainId(int wanted, const char* ros_domain_id);

// One of an id in a process; it must outlive the nodes in it.
class Domain {
 public:
  // INVALID_ARGUMENT; UNAVAILABLE if there is no such interface.
  static absl::StatusOr<std::unique_ptr<Domain>> Join(
      const DomainOptions& options);
  ~Domain();
  Domain(const Domain&) = delete;
  Domain& operator=(const Domain&) = delete;

  int id() const { return id_; }

 private:
  Domain(int id, int32_t entity) : id_(id), entity_(entity) {}

  int id_;
  // 0: Cyclone makes it with the first node.
  int32_t entity_;
};

}  // namespace treeline::dds

#endif  // NAV_AGENT_BRIDGE_DDS_DOMAIN_H_
