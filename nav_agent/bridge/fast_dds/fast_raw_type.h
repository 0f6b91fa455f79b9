// A type of Fast DDS whose samples are bytes of CDR as they are. For the
// sources of this folder: it includes Fast DDS.
#ifndef NAV_AGENT_BRIDGE_FAST_DDS_FAST_RAW_TYPE_H_
#define NAV_AGENT_BRIDGE_FAST_DDS_FAST_RAW_TYPE_H_

#include <cstdint>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <functional>
#include <string>
#include <vector>

namespace treeline::fast_dds {

// Samples are std::vector<uint8_t>, their encoding in front. Without keys and
// type information: names decide, as among nodes of ROS 2.
class FastRawType final : public eprosima::fastdds::dds::TopicDataType {
 public:
  using Payload = eprosima::fastrtps::rtps::SerializedPayload_t;
  using Handle = eprosima::fastrtps::rtps::InstanceHandle_t;

  explicit FastRawType(const std::string& name);
  bool serialize(void* data, Payload* payload) override;
  bool deserialize(Payload* payload, void* data) override;
  std::function<uint32_t()> getSerializedSizeProvider(void* data) override;
  void* createData() override;
  void deleteData(void* data) override;
  bool getKey(void* /*data*/, Handle* /*handle*/, bool /*force_md5*/) override {
    return false;
  }
};

}  // namespace treeline::fast_dds

#endif  // NAV_AGENT_BRIDGE_FAST_DDS_FAST_RAW_TYPE_H_
