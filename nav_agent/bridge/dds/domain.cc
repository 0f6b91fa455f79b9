#include "nav_agent/bridge/dds/domain.h"

#include "absl/memory/memory.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "dds/dds.h"

namespace treeline::dds {
namespace {

constexpr int kMaxDomain = 232;

std::string Configuration(const std::string& interface) {
  const bool is_loopback = interface == "lo";
  return absl::StrCat(
      "<General><Interfaces><NetworkInterface name=\"", interface, "\"",
      is_loopback ? " multicast=\"false\"" : "", "/></Interfaces>",
      is_loopback ? "<AllowMulticast>false</AllowMulticast>" : "", "</General>",
      is_loopback ? "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
                    "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
                    "<Peers><Peer address=\"localhost\"/></Peers></Discovery>"
                  : "");
}

}  // namespace

absl::StatusOr<int> DomainId(int wanted, const char* ros_domain_id) {
  if (wanted >= 0) return wanted;
  int id = 0;
  if (ros_domain_id == nullptr || *ros_domain_id == 0 ||
      absl::SimpleAtoi(ros_domain_id, &id)) {
    return id;
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "ROS_DOMAIN_ID is \"", ros_domain_id, "\", which is no number"));
}

absl::StatusOr<std::unique_ptr<Domain>> Domain::Join(
    const DomainOptions& options) {
  if (options.id < 0 || options.id > kMaxDomain) {
    return absl::InvalidArgumentError(
        absl::StrCat("domain ", options.id, ": it must be in 0..", kMaxDomain));
  }
  if (options.interface.find_first_of("<>\"&'") != std::string::npos) {
    return absl::InvalidArgumentError(
        absl::StrCat("\"", options.interface, "\" is no network interface"));
  }
  if (options.interface.empty()) {
    return absl::WrapUnique(new Domain(options.id, 0));
  }
  const dds_entity_t entity =
      dds_create_domain(static_cast<dds_domainid_t>(options.id),
                        Configuration(options.interface).c_str());
  if (entity < 0) {
    return absl::UnavailableError(
        absl::StrCat("domain ", options.id, " over the network interface ",
                     options.interface, ": ", dds_strretcode(entity),
                     "; `ip link` lists those of this machine"));
  }
  return absl::WrapUnique(new Domain(options.id, entity));
}

Domain::~Domain() {
  if (entity_ > 0) dds_delete(entity_);
}

}  // namespace treeline::dds
