#include "common/ros2/conversions/frame_tree.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/ros2/conversions/geometry_values.h"

namespace treeline::conversions {
namespace {

// More than robots have; bounds what others can make us keep, and loops.
constexpr size_t kMaxFrames = 2000;

std::string NameOf(const std::string& frame) {
  return std::string(absl::StripPrefix(frame, "/"));
}

}  // namespace

void FrameTree::Add(const messages::TFMessage& message) {
  for (const messages::TransformStamped& transform : message.transforms) {
    const std::string child = NameOf(transform.child_frame_id);
    const std::string parent = NameOf(transform.header.frame_id);
    const auto parent_from_child = RigidOf(transform.transform);
    if (!parent_from_child.ok()) {
      fault_ = absl::StrCat(parent, " to ", child, ": ",
                            parent_from_child.status().message());
      continue;
    }
    if (child.empty() || parent.empty() || child == parent) continue;
    if (edge_of_child_.size() >= kMaxFrames &&
        edge_of_child_.count(child) == 0) {
      continue;
    }
    edge_of_child_[child] = {.parent = parent,
                             .parent_from_child = *parent_from_child};
  }
}

FrameTree::Root FrameTree::RootOf(const std::string& frame) const {
  Root root = {.name = frame, .root_from_frame = {}};
  for (size_t i = 0; i <= edge_of_child_.size(); ++i) {
    const auto edge = edge_of_child_.find(root.name);
    if (edge == edge_of_child_.end()) return root;
    root.root_from_frame =
        edge->second.parent_from_child * root.root_from_frame;
    root.name = edge->second.parent;
  }
  // A loop: nothing hangs on anything.
  return {.name = "", .root_from_frame = {}};
}

absl::StatusOr<geometry::Rigid3> FrameTree::Find(
    const std::string& target, const std::string& source) const {
  const Root of_target = RootOf(NameOf(target));
  const Root of_source = RootOf(NameOf(source));
  if (of_target.name.empty() || of_target.name != of_source.name) {
    return absl::NotFoundError(absl::StrCat(
        "/tf and /tf_static do not tell where ", source, " is in ", target,
        ": the first hangs on \"", of_source.name, "\", the second on \"",
        of_target.name, "\"", fault_.empty() ? "" : "; left out: ", fault_));
  }
  return of_target.root_from_frame.Inverse() * of_source.root_from_frame;
}

}  // namespace treeline::conversions
