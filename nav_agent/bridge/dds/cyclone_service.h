// A service as rmw_cyclonedds_cpp of ROS 2 has it (serdata.hpp and rmw_node.cpp
// there, the same from Foxy to Rolling): in front of each request and reply are
// 16 bytes of CDR, the client's number for its writer and the request's number
// in sequence; and which reader and which writer are one client is in their
// user data.
#ifndef NAV_AGENT_BRIDGE_DDS_CYCLONE_SERVICE_H_
#define NAV_AGENT_BRIDGE_DDS_CYCLONE_SERVICE_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "nav_agent/bridge/dds/cyclone_parts.h"
#include "nav_agent/bridge/dds/service.h"

namespace treeline::dds {

// name: "/robot1/ask". The entities must outlive it.
absl::StatusOr<std::unique_ptr<Service>> MakeCycloneService(
    const Entity& participant, const Entity& waitset, const std::string& name,
    const std::string& service_type);

}  // namespace treeline::dds

#endif  // NAV_AGENT_BRIDGE_DDS_CYCLONE_SERVICE_H_
