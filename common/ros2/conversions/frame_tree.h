// The frames that /tf and /tf_static tell of, at their newest.
#ifndef COMMON_ROS2_CONVERSIONS_FRAME_TREE_H_
#define COMMON_ROS2_CONVERSIONS_FRAME_TREE_H_

#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "common/geometry/rigid3.h"
#include "common/ros2/messages/geometry_messages.h"

namespace treeline::conversions {

// What changes (odometry) is only as good as its age: for poses of a moment,
// use what has a stamp. Not thread-safe.
class FrameTree {
 public:
  // Transforms that are not finite or no rotation, or that make a frame its own
  // parent, are left out. Slashes in front of names (as in ROS 1) do not count.
  void Add(const messages::TFMessage& message);

  // Takes points of `source` into `target`, through as many frames as it
  // takes. NOT_FOUND says which frame is missing, and what was left out.
  absl::StatusOr<geometry::Rigid3> Find(const std::string& target,
                                        const std::string& source) const;

 private:
  struct Edge {
    std::string parent;
    geometry::Rigid3 parent_from_child;
  };
  // To the frame without a parent that `frame` hangs on.
  struct Root {
    std::string name;
    geometry::Rigid3 root_from_frame;
  };
  Root RootOf(const std::string& frame) const;

  std::map<std::string, Edge> edge_of_child_;
  // The newest that was left out.
  std::string fault_;
};

}  // namespace treeline::conversions

#endif  // COMMON_ROS2_CONVERSIONS_FRAME_TREE_H_
