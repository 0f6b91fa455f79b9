// Where the differences of a scale space are largest or least: the blobs that
// features stand on (Lowe 2004, sections 3 and 4).
#ifndef SERVER_CORE_FEATURES_SCALE_SPACE_EXTREMA_H_
#define SERVER_CORE_FEATURES_SCALE_SPACE_EXTREMA_H_

#include <cstddef>
#include <vector>

#include "server/core/features/scale_space.h"

namespace treeline::features {

struct ScaleSpaceExtremum {
  size_t octave = 0;
  // In pixels of the octave, and in levels of its differences.
  float x = 0;
  float y = 0;
  float level = 0;
  // Size of the difference there, in grey levels.
  float contrast = 0;
};

// Values of the differences above those of all 26 neighbours or below them,
// each moved to the extremum of a parabola through these. Left out: what lies
// on an edge, where one curvature is far larger than the other, and what is
// weak beside the rest of the picture (see parameters.h), so that a picture of
// another exposure has the same. In the order of octaves, levels, rows.
void FindExtrema(const ScaleSpace& space,
                 std::vector<ScaleSpaceExtremum>& extrema);

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_SCALE_SPACE_EXTREMA_H_
