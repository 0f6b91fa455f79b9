// A recording of ROS 2 in one SQLite file: table `topics` with id, name, type
// and serialization_format, table `messages` with topic_id, timestamp (ns) and
// data (rosbag2's plug-in sqlite3).
#ifndef COMMON_ROS2_BAG_SQLITE_BAG_H_
#define COMMON_ROS2_BAG_SQLITE_BAG_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "common/ros2/bag/bag.h"

namespace treeline::bag {

absl::StatusOr<std::unique_ptr<Bag>> OpenSqliteBag(const std::string& path);

}  // namespace treeline::bag

#endif  // COMMON_ROS2_BAG_SQLITE_BAG_H_
