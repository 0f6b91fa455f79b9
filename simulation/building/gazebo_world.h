// Worlds of Gazebo (SDF): what stands in them, as far as it is upright boxes
// and cylinders. http://sdformat.org/spec has the format; versions 1.4 to 1.9
// do not differ in what is read here.
#ifndef SIMULATION_BUILDING_GAZEBO_WORLD_H_
#define SIMULATION_BUILDING_GAZEBO_WORLD_H_

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::building {

inline constexpr size_t kMaxGazeboBytes = size_t{16} << 20;

// An upright box or cylinder, in Gazebo's world frame.
struct GazeboSolid {
  std::string model{};
  // In the file; for errors.
  int line = 0;
  bool is_round = false;
  // Of its middle.
  double x_m = 0;
  double y_m = 0;
  // Of a box, of the side that along_m measures, counter-clockwise from x.
  double yaw_rad = 0;
  // A cylinder's are both its diameter.
  double along_m = 0;
  double across_m = 0;
  double bottom_m = 0;
  double top_m = 0;

  bool operator==(const GazeboSolid&) const = default;
};

// The collision shapes of all models, where the world's <state> puts them, if
// it has one. Of other things the ground at z = 0, lights, and what only says
// how Gazebo computes, shows or draws are passed over.
//
// INVALID_ARGUMENT, "FILE:LINE: reason" with the name of the model, for what
// cannot be had by that: shapes of other kinds, tilted ones, models that are
// files of their own, that a plugin or joints move, actors, and poses in other
// frames than their parent's. Safe on any bytes. `name` is what errors call
// the file.
absl::StatusOr<std::vector<GazeboSolid>> ParseGazeboWorld(
    absl::string_view text, absl::string_view name);

}  // namespace treeline::building

#endif  // SIMULATION_BUILDING_GAZEBO_WORLD_H_
