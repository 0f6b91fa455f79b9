// Who else is in a domain, as Cyclone DDS has discovered. For the sources of
// this folder.
#ifndef NAV_AGENT_BRIDGE_DDS_CYCLONE_NEIGHBOURS_H_
#define NAV_AGENT_BRIDGE_DDS_CYCLONE_NEIGHBOURS_H_

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/bridge/dds/cyclone_parts.h"
#include "nav_agent/bridge/dds/endpoints.h"

namespace treeline::dds {

// Thread-safe. The participant must outlive it.
class CycloneNeighbours {
 public:
  static absl::StatusOr<CycloneNeighbours> Watch(const Entity& participant,
                                                 int domain_id);

  // Of others than the participant.
  std::vector<Endpoint> Others() const;
  // endpoints.h
  std::string WhyNobody(const Endpoint& ours) const;

 private:
  CycloneNeighbours(int32_t participant, int domain_id, Entity writers,
                    Entity readers)
      : participant_(participant),
        domain_id_(domain_id),
        writers_(std::move(writers)),
        readers_(std::move(readers)) {}

  int32_t participant_;
  int domain_id_;
  Entity writers_;
  Entity readers_;
};

}  // namespace treeline::dds

#endif  // NAV_AGENT_BRIDGE_DDS_CYCLONE_NEIGHBOURS_H_
