// A dock as somebody sets it up: where the robot stands in it.
#ifndef NAV_AGENT_DOCKING_DOCK_H_
#define NAV_AGENT_DOCKING_DOCK_H_

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/core/level_pose.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/traversability/traversability.h"

namespace treeline::docking {

struct Dock {
  std::string name = {};
  // The robot's base in the map, when it is docked (m, rad).
  geometry::Rigid2 map_from_docked = {};
  int level = 0;
  // It drives in with its rear first, and out ahead.
  bool is_backward = false;
  // From the docked pose straight back the way it came, to the pose that it
  // drives to before it drives in (m).
  double staging_m = 0;
  // What the laser saw of a robot that stood in it: where beams ended, in the
  // docked base, counter-clockwise (m). Empty: no robot has looked yet.
  std::vector<geometry::Vec2> view = {};

  bool operator==(const Dock&) const = default;
};

// All but what is seen from it.
bool IsSamePlace(const Dock& a, const Dock& b);

inline constexpr size_t kMaxDocks = 100;
inline constexpr size_t kMaxViewPoints = 2000;
inline constexpr size_t kMaxDockNameBytes = 64;
inline constexpr double kMinStaging_m = 0.2;
inline constexpr double kMaxStaging_m = 5;

// Where a robot of this shape can turn before the dock, and come onto the line
// (m).
double DefaultStaging_m(const core::RobotModel& robot);

// The robot before its dock, as it drives in from there.
geometry::Rigid2 StagingPose(const Dock& dock);

// A robot in the dock's terms, whichever end of it is ahead.
struct DockOffset {
  // Along the way in: below 0 before the docked pose (m).
  double along_m = 0;
  // To the left of the way in (m).
  double aside_m = 0;
  // Of its direction of travel, counter-clockwise from the way in (rad).
  double turned_rad = 0;
};
DockOffset OffsetFrom(const Dock& dock, const geometry::Rigid2& map_from_base);

// It stands in the dock, or so near that it has touched it.
bool IsAt(const Dock& dock, const core::LevelPose& robot);
// So far in that it must drive straight out before it can turn: nearer to the
// docked pose than its circle needs, on the dock's line and along it.
bool IsInside(const Dock& dock, const core::LevelPose& robot,
              const core::RobotModel& model);

// The nearest on the robot's level, or else on any; the first where it does not
// know its place. FAILED_PRECONDITION: there is none.
absl::StatusOr<Dock> NearestOf(std::span<const Dock> docks,
                               const std::optional<core::LevelPose>& robot);
// How far the robot is from one as the crow flies; one on another level is
// farther than all on its own (m).
double Away_m(const Dock& dock, const core::LevelPose& robot);

// INVALID_ARGUMENT, with the dock's name, for one that means nothing: a name
// that is none, a pose or a staging distance that is not finite or absurd, a
// level that the map does not have, a docked or a staging pose whose base lies
// on no ground that can be driven on.
absl::Status CheckDock(const Dock& dock,
                       const traversability::TraversableMap& map);

// The same for all that are kept, and INVALID_ARGUMENT for too many, and for
// two of one name.
absl::Status CheckDocks(std::span<const Dock> docks,
                        const traversability::TraversableMap& map);

}  // namespace treeline::docking

#endif  // NAV_AGENT_DOCKING_DOCK_H_
