// Sparse features of keyframes, and of frames to be matched with them
// (thesis 3.2.3).
#ifndef SERVER_CORE_KEYFRAMES_KEYFRAME_FEATURES_H_
#define SERVER_CORE_KEYFRAMES_KEYFRAME_FEATURES_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/geometry/vector3.h"
#include "common/image/image.h"
#include "server/core/features/fast_sift.h"
#include "server/core/features/sift_features.h"
#include "server/core/keyframes/keyframe_map.h"

namespace treeline::keyframes {

// Up to max_features SIFT features of an image, at its pixels, to be matched
// with those of keyframes of the same kind. FastSift's are `options`; Lowe's
// heed max_features alone.
//
// Lowe's come with the largest regions first, and of images of 512 pixels and
// more a side in half their size: that is four times as fast, and the small
// features that it misses are the least stable ones.
features::SiftFeatures ExtractKeyframeSift(const image::ColorImage& image,
                                           features::SiftKind kind,
                                           features::FastSiftOptions options,
                                           features::FastSift& fast_sift);

// A pixel of a frame, and the point that a keyframe's feature like it stands
// on.
struct KeyframeMatch {
  camera::Pixel pixel;
  geometry::Vec3 point_in_world;
  // Of the distances to the nearest and the second nearest feature, in [0, 1]:
  // small is sure.
  double ratio = 1;
  // Which of the frame's features it is, and of KeyframeMap::features, and how
  // far their descriptors are apart.
  uint32_t feature = 0;
  uint32_t known = 0;
  int32_t squared_distance = 0;
};

// Matches of a frame's features with each of the keyframes, surest first: pairs
// that are each other's nearest, with a ratio of at most max_ratio (Lowe 2004).
std::vector<KeyframeMatch> MatchKeyframes(
    const features::SiftFeatures& features, const KeyframeMap& map,
    std::span<const size_t> keyframes, double max_ratio);

// Up to `count` keyframes that share most features with a frame, most first,
// whatever its pose: by the map's index, or where the features are Lowe's,
// by matching the largest with those of all keyframes.
std::vector<size_t> MostSimilarKeyframes(const features::SiftFeatures& features,
                                         const KeyframeMap& map, size_t count,
                                         double max_ratio);
// The same of some of the keyframes.
std::vector<size_t> MostSimilarKeyframes(const features::SiftFeatures& features,
                                         const KeyframeMap& map,
                                         std::span<const size_t> keyframes,
                                         size_t count, double max_ratio);

}  // namespace treeline::keyframes

#endif  // SERVER_CORE_KEYFRAMES_KEYFRAME_FEATURES_H_
