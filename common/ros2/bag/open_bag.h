// Which file a recording of ROS is in, and the reader for it.
#ifndef COMMON_ROS2_BAG_OPEN_BAG_H_
#define COMMON_ROS2_BAG_OPEN_BAG_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "common/ros2/bag/bag.h"

namespace treeline::bag {

// Whether `path` is a file or folder that OpenBag takes for a recording, by
// name and first bytes.
bool IsBag(const std::string& path);

// Opens
//   NAME.mcap     MCAP with messages in CDR, or of ROS 1
//   NAME.db3      ROS 2's default until Humble: SQLite
//   NAME.bag      ROS 1, format 2.0: plain, bz2 or lz4
//   FOLDER        of `ros2 bag record`: metadata.yaml and files of the first
//   two
//                 kinds. Without metadata.yaml (the recording was killed), such
//                 files by their names.
// The errors of files; INVALID_ARGUMENT for what is none of these, and for
// bags that ros2 bag compressed as a whole (zstd), with what to do.
absl::StatusOr<std::unique_ptr<Bag>> OpenBag(const std::string& path);

}  // namespace treeline::bag

#endif  // COMMON_ROS2_BAG_OPEN_BAG_H_
