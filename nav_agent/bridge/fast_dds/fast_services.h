// Services as rmw_fastrtps_cpp of ROS 2 has them (rmw_request.cpp and
// rmw_response.cpp there, the same from Galactic to Rolling): nothing stands in
// front of requests and replies; who asked, and which of its requests it was,
// travels beside them, as DDS-RPC's related sample identity. Cyclone DDS can
// neither write nor read that, so this is Fast DDS.
#ifndef NAV_AGENT_BRIDGE_FAST_DDS_FAST_SERVICES_H_
#define NAV_AGENT_BRIDGE_FAST_DDS_FAST_SERVICES_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "nav_agent/bridge/dds/domain.h"
#include "nav_agent/bridge/dds/service.h"
#include "nav_agent/bridge/dds/topic_names.h"

namespace treeline::fast_dds {

// A participant of its own, beside that of the topics. The environment's
// FASTRTPS_DEFAULT_PROFILES_FILE counts, as for nodes of ROS 2.
class FastServices {
 public:
  // As dds::Domain::Join and dds::Node::Create. Over UDP alone.
  static absl::StatusOr<std::unique_ptr<FastServices>> Join(
      const dds::DomainOptions& options, const dds::NodeName& name);
  virtual ~FastServices() = default;

  // As dds::Node::Serve. Services may not outlive this. Clients of
  // rmw_cyclonedds are not understood, and left alone.
  virtual absl::StatusOr<std::unique_ptr<dds::Service>> Serve(
      const std::string& service, const std::string& service_type) = 0;
};

}  // namespace treeline::fast_dds

#endif  // NAV_AGENT_BRIDGE_FAST_DDS_FAST_SERVICES_H_
