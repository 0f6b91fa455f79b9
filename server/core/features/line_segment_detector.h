// Straight edges of a grey picture.
#ifndef SERVER_CORE_FEATURES_LINE_SEGMENT_DETECTOR_H_
#define SERVER_CORE_FEATURES_LINE_SEGMENT_DETECTOR_H_

#include <vector>

#include "common/camera/camera.h"
#include "server/core/features/gray_pyramid.h"

namespace treeline::features {

// Where brightness jumps along a straight line (px). The brighter side is to
// the right of who goes from `a` to `b`, with y down.
struct LineSegment {
  camera::Pixel a;
  camera::Pixel b;
};

// The segments of a picture, in its own pixels, those with the steepest seeds
// first: LSD (von Gioi et al., "LSD: a Line Segment Detector", IPOL 2012)
// without its test by the number of false alarms, which is OpenCV's
// LSD_REFINE_STD, with the usual downscaling by 0.8. Empty for pictures that
// are too small for it. The result depends on the picture alone.
std::vector<LineSegment> FindLineSegments(const GrayPyramid::Level& picture);

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_LINE_SEGMENT_DETECTOR_H_
