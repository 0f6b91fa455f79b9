// A type of Cyclone DDS whose samples are bytes of CDR as they are: nothing is
// known of it but its name. For node.cc; ownership as Cyclone counts it.
#ifndef NAV_AGENT_BRIDGE_DDS_RAW_TYPE_H_
#define NAV_AGENT_BRIDGE_DDS_RAW_TYPE_H_

#include <cstdint>
#include <span>
#include <string>

struct ddsi_serdata;
struct ddsi_sertype;

namespace treeline::dds {

// Without keys, plain CDR of version 1, no type information: what ROS 2's
// nodes match by name. For dds_create_topic_sertype, which takes it over.
ddsi_sertype* NewRawType(const std::string& type_name);

// One sample to be written; `bytes` begin with their encoding. For
// dds_writecdr, which takes it over.
ddsi_serdata* NewRawSample(const ddsi_sertype* type,
                           std::span<const uint8_t> bytes);

// Of a sample of such a type; valid while the sample is.
std::span<const uint8_t> BytesOf(const ddsi_serdata* sample);

}  // namespace treeline::dds

#endif  // NAV_AGENT_BRIDGE_DDS_RAW_TYPE_H_
