// Robots as ROS describes them (URDF): links, where they are, and their
// collision shapes. http://wiki.ros.org/urdf/XML has the format.
#ifndef NAV_AGENT_URDF_URDF_FILE_H_
#define NAV_AGENT_URDF_URDF_FILE_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/geometry/rigid3.h"

namespace treeline::urdf {

inline constexpr size_t kMaxUrdfBytes = size_t{4} << 20;
inline constexpr size_t kMaxLinks = 2000;

enum class ShapeKind : uint8_t { kBox, kCylinder, kSphere };

// About its own middle; a cylinder's axis is z.
struct Shape {
  ShapeKind kind = ShapeKind::kBox;
  // Of a box (m).
  geometry::Vec3 size_m;
  // Of a cylinder and a sphere; a cylinder's length.
  double radius_m = 0;
  double length_m = 0;
  geometry::Rigid3 link_from_shape;
};

enum class JointKind : uint8_t { kFixed, kTurning, kOther };

struct Link {
  std::string name;
  std::vector<Shape> collisions;
  // Collision shapes that are files of their own, which are not read.
  int meshes = 0;
  // The joint that it hangs on; nullopt: it is the root. Where joints can move,
  // the pose is that of their zero.
  std::optional<size_t> parent;
  JointKind joint = JointKind::kFixed;
  geometry::Rigid3 parent_from_link;
};

// A tree: one root, all links below it.
struct Urdf {
  std::string name;
  std::vector<Link> links;

  // nullopt: there is no such link.
  std::optional<size_t> Find(absl::string_view link) const;
  // Where `link` is in the frame of `base`; both are indices of links.
  geometry::Rigid3 BaseFromLink(size_t base, size_t link) const;
};

// INVALID_ARGUMENT, "NAME:LINE: reason", for what is no such file: no XML,
// xacro that is not expanded, document types and their entities, numbers that
// are none or beyond 100 m, links that are missing, named twice, without way
// to the root or in a circle. Safe on any bytes.
absl::StatusOr<Urdf> ParseUrdf(absl::string_view text, absl::string_view name);

}  // namespace treeline::urdf

#endif  // NAV_AGENT_URDF_URDF_FILE_H_
