// The best way through a field, which the score's optimal time is made of.
#ifndef EVALUATION_FIELDS_BEST_WAY_H_
#define EVALUATION_FIELDS_BEST_WAY_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/geometry/rigid2.h"

namespace treeline::fields {

enum class BestWaySource : uint8_t {
  kCells,         // of a drawn field
  kPathFile,      // beside the world's file
  kStraightLine,  // nothing better is known
};
const char* BestWaySourceName(BestWaySource source);

struct BestWay {
  double length_m = 0;
  BestWaySource source = BestWaySource::kStraightLine;
};

inline constexpr size_t kMaxPathFileBytes = size_t{4} << 20;

// A way of the BARN data set, path_N.npy: an array of N x 2 whole or floating
// numbers, columns and rows of its cells, as numpy writes arrays (versions 1 to
// 3 of its format, little-endian, in C's order). Its points in Gazebo's world,
// by path_coord_to_gazebo_coord of the challenge's run.py.
// INVALID_ARGUMENT, "FILE: reason". Safe on any bytes.
absl::StatusOr<std::vector<geometry::Vec2>> ParseBarnPath(
    absl::string_view bytes, absl::string_view name);

// PATH/path_files/path_N.npy for PATH/world_N.world; "": the name is another.
std::string PathFileBeside(absl::string_view world);

// From start to goal, both in the frame of the world's file: of "field:N" over
// its cells; of a world of Gazebo along its path file, if there is one beside;
// otherwise straight. Fails for a path file that cannot be read.
absl::StatusOr<BestWay> FindBestWay(absl::string_view world,
                                    geometry::Vec2 start, geometry::Vec2 goal);

}  // namespace treeline::fields

#endif  // EVALUATION_FIELDS_BEST_WAY_H_
