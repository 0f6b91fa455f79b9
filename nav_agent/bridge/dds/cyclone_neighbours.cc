#include "nav_agent/bridge/dds/cyclone_neighbours.h"

#include <cstring>
#include <utility>

#include "common/base/status_macros.h"
#include "dds/dds.h"

namespace treeline::dds {
namespace {

// More are not looked at.
constexpr uint32_t kMostEndpoints = 1024;

Quality QualityOf(const dds_qos_t* qos) {
  dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
  dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
  dds_duration_t blocking = 0;
  dds_qget_reliability(qos, &reliability, &blocking);
  dds_qget_durability(qos, &durability);
  return {.is_reliable = reliability == DDS_RELIABILITY_RELIABLE,
          .is_latched = durability != DDS_DURABILITY_VOLATILE};
}

void AddOthers(const Entity& reader, const dds_guid_t& self, bool are_writers,
               std::vector<Endpoint>& others) {
  std::vector<void*> samples(kMostEndpoints);
  std::vector<dds_sample_info_t> infos(kMostEndpoints);
  const dds_return_t count = dds_read_mask(
      reader.id(), samples.data(), infos.data(), kMostEndpoints, kMostEndpoints,
      DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE | DDS_ALIVE_INSTANCE_STATE);
  for (size_t i = 0; count > 0 && i < static_cast<size_t>(count); ++i) {
    if (!infos[i].valid_data) continue;
    const auto* found =
        static_cast<const dds_builtintopic_endpoint_t*>(samples[i]);
    if (std::memcmp(&found->participant_key, &self, sizeof(self)) == 0) {
      continue;
    }
    auto endpoint = EndpointOf(found->topic_name, found->type_name);
    if (!endpoint.has_value()) continue;
    endpoint->quality = QualityOf(found->qos);
    endpoint->is_writer = are_writers;
    others.push_back(*std::move(endpoint));
  }
  if (count > 0) dds_return_loan(reader.id(), samples.data(), count);
}

}  // namespace

absl::StatusOr<CycloneNeighbours> CycloneNeighbours::Watch(
    const Entity& participant, int domain_id) {
  TL_ASSIGN_OR_RETURN(Entity writers,
                      Made(dds_create_reader(participant.id(),
                                             DDS_BUILTIN_TOPIC_DCPSPUBLICATION,
                                             nullptr, nullptr),
                           "who publishes"));
  TL_ASSIGN_OR_RETURN(Entity readers,
                      Made(dds_create_reader(participant.id(),
                                             DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION,
                                             nullptr, nullptr),
                           "who listens"));
  return CycloneNeighbours(participant.id(), domain_id, std::move(writers),
                           std::move(readers));
}

std::vector<Endpoint> CycloneNeighbours::Others() const {
  dds_guid_t self{};
  std::vector<Endpoint> others;
  if (dds_get_guid(participant_, &self) != DDS_RETCODE_OK) return others;
  AddOthers(writers_, self, true, others);
  AddOthers(readers_, self, false, others);
  return others;
}

std::string CycloneNeighbours::WhyNobody(const Endpoint& ours) const {
  return dds::WhyNobody(ours, Others(), domain_id_);
}

}  // namespace treeline::dds
