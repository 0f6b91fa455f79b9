// A recording of ROS 1, format 2.0 (wiki.ros.org/Bags/Format/2.0): records of a
// header of fields and data; messages lie in chunks, plain or packed with bz2
// or lz4.
#ifndef COMMON_ROS2_BAG_ROS1_BAG_H_
#define COMMON_ROS2_BAG_ROS1_BAG_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/ros2/bag/bag.h"

namespace treeline::bag {

absl::StatusOr<std::unique_ptr<Bag>> OpenRos1Bag(const std::string& path);
// The same for bytes, which must outlive it; `name` is what errors call it.
absl::StatusOr<std::unique_ptr<Bag>> ParseRos1Bag(absl::string_view bytes,
                                                  const std::string& name);

}  // namespace treeline::bag

#endif  // COMMON_ROS2_BAG_ROS1_BAG_H_
