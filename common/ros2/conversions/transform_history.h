// The frames that /tf and /tf_static tell of, at any moment of a recording.
#ifndef COMMON_ROS2_CONVERSIONS_TRANSFORM_HISTORY_H_
#define COMMON_ROS2_CONVERSIONS_TRANSFORM_HISTORY_H_

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/geometry/rigid3.h"
#include "common/ros2/messages/geometry_messages.h"

namespace treeline::conversions {

// A frame hangs on one other at a time. Between two messages that are at most
// max_gap_s apart, transforms are interpolated (translations linearly,
// rotations along the shorter arc); beyond the first and the last nothing is
// known, but of frames that never move. Slashes in front of names (as in ROS 1)
// do not count. Not thread-safe.
class TransformHistory {
 public:
  explicit TransformHistory(double max_gap_s = 1.0) : max_gap_s_(max_gap_s) {}

  // Of /tf: each holds from its stamp on. What is not finite or hangs on itself
  // is left out.
  void Add(const messages::TFMessage& message);
  // Of /tf_static: each holds always.
  void AddStatic(const messages::TFMessage& message);
  // A pose of another topic. What /tf says of `child` counts no more.
  void AddPose(const std::string& parent, const std::string& child,
               int64_t time_ns, const geometry::Rigid3& parent_from_child);

  // Takes points of `source` into `target`. NOT_FOUND says which frame is
  // missing, or that there is nothing near that time.
  absl::StatusOr<geometry::Rigid3> Find(const std::string& target,
                                        const std::string& source,
                                        int64_t time_ns) const;
  // `frame`, what it first hung on, and so on up to the frame without a parent.
  std::vector<std::string> ChainFrom(const std::string& frame) const;
  // Whether `frame` moves in the frame that it hangs on.
  bool Moves(const std::string& frame) const;

 private:
  struct Moment {
    std::string parent;
    geometry::Rigid3 parent_from_child;

    bool operator==(const Moment&) const = default;
  };
  struct Edge {
    std::map<int64_t, Moment> moments;
    // All are the same.
    bool is_constant = true;
  };

  void AddMoment(const std::string& child, int64_t time_ns, Moment moment);
  // At this time; NOT_FOUND.
  absl::StatusOr<Moment> MomentOf(const std::string& child, const Edge& edge,
                                  int64_t time_ns) const;

  const double max_gap_s_;
  std::map<std::string, Edge> edges_;
  // Of which a topic tells.
  std::set<std::string> posed_;
};

}  // namespace treeline::conversions

#endif  // COMMON_ROS2_CONVERSIONS_TRANSFORM_HISTORY_H_
