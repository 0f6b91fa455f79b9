// A recording of ROS in one MCAP file.
#ifndef COMMON_ROS2_BAG_MCAP_BAG_H_
#define COMMON_ROS2_BAG_MCAP_BAG_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "common/ros2/bag/bag.h"

namespace treeline::bag {

absl::StatusOr<std::unique_ptr<Bag>> OpenMcapBag(const std::string& path);

}  // namespace treeline::bag

#endif  // COMMON_ROS2_BAG_MCAP_BAG_H_
