// Where the differences of a scale space are largest or least: the blobs that
// features stand on (Lowe 2004, sections 3 and 4).
#ifndef SERVER_CORE_FEATURES_SCALE_SPACE_EXTREMA_H_
#define SERVER_CORE_FEATURES_SCALE_SPACE_EXTREMA_H_

#include <cstddef>
#include <vector>

#include "server/core/features/scale_space.h"
#include "server/core/features/sift_features.h"

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

struct ExtremumOptions {
  // Weaker ones are left out; grey levels.
  float least_contrast = 0;
  // So are those with curvatures that differ by more than this factor: on
  // edges.
  float max_curvature_ratio = 0;
  // One that is this far from its pixel or level, at least 0.5, is sought from
  // the next one.
  float move_beyond = 0.5F;
};

// Appends the values of an octave's differences above those of all 26
// neighbours or below them, each moved to the extremum of a parabola through
// these. In the order of rows and levels. The octave is complete.
void FindExtrema(const ScaleSpace& space, size_t octave,
                 const ExtremumOptions& options,
                 std::vector<ScaleSpaceExtremum>& extrema);

// Mean size of the finest differences, in grey levels: of those of level 1 of
// octave 0, which must be there.
float MeanDifference(const ScaleSpace& space);

// A feature that stands there: position and diameter in pixels of the image.
SiftKeypoint KeypointOf(const ScaleSpace& space,
                        const ScaleSpaceExtremum& extremum, float angle_rad);

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_SCALE_SPACE_EXTREMA_H_
