// Who else is in a domain, and why somebody hears nobody there.
#ifndef NAV_AGENT_BRIDGE_DDS_ENDPOINTS_H_
#define NAV_AGENT_BRIDGE_DDS_ENDPOINTS_H_

#include <optional>
#include <string>
#include <vector>

#include "nav_agent/bridge/dds/quality.h"

namespace treeline::dds {

// A writer or a reader of a topic.
struct Endpoint {
  // "/robot1/scan".
  std::string topic = {};
  // "sensor_msgs/msg/LaserScan".
  std::string message_name = {};
  Quality quality = {};
  bool is_writer = false;
};

// The names as DDS sees them, as ROS 2 writes them; nullopt: no topic of
// ROS 2, or a service's.
std::optional<Endpoint> EndpointOf(const std::string& dds_topic,
                                   const std::string& dds_type);

// Why `ours` meets none of `others`, in a clause for people: its topic has
// another type or quality of service there, or another name, or nobody is
// there at all. "" if one of them fits.
std::string WhyNobody(const Endpoint& ours, const std::vector<Endpoint>& others,
                      int domain_id);

}  // namespace treeline::dds

#endif  // NAV_AGENT_BRIDGE_DDS_ENDPOINTS_H_
