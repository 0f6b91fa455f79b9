// Which matches speak for one place of the scene rather than for others.
#ifndef SERVER_CORE_KEYFRAMES_DISTINCT_MATCHES_H_
#define SERVER_CORE_KEYFRAMES_DISTINCT_MATCHES_H_

#include <cstddef>
#include <span>

#include "server/core/features/sift_features.h"
#include "server/core/keyframes/keyframe_features.h"
#include "server/core/keyframes/keyframe_map.h"

namespace treeline::keyframes {

// How many of these matches of `features` are distinct: no feature of the scene
// that stands further than kElsewhere_m from the match's point is nearly as
// like the frame's (Lowe's test of the second nearest, over the scene rather
// than one keyframe). Looked for in the map's index, among the features of the
// words of both; all are distinct where it has none.
size_t CountDistinct(const features::SiftFeatures& features,
                     const KeyframeMap& map,
                     std::span<const KeyframeMatch> matches);

}  // namespace treeline::keyframes

#endif  // SERVER_CORE_KEYFRAMES_DISTINCT_MATCHES_H_
