// Straight edges of an image, and points on them lifted into space (thesis
// 5.4.1).
#ifndef SERVER_CORE_FEATURES_LINE_SEGMENTS_H_
#define SERVER_CORE_FEATURES_LINE_SEGMENTS_H_

#include <cstdint>
#include <vector>

#include "common/base/random.h"
#include "common/image/image.h"
#include "server/core/features/gray_pyramid.h"
#include "server/core/features/line_segment_detector.h"
#include "server/core/features/rgbd_samples.h"

namespace treeline::features {

struct LineOptions {
  // Level of the pyramid that segments are looked for in, in [0, 3]. Each level
  // takes about a third of the time of the one below.
  int level = 1;
  // Shorter segments are dropped (px of level 0).
  double min_length_px = 20;
  // Of more segments than this, the longest are used.
  int max_segments = 250;
  // Points of a segment lie this far apart (px of level 0).
  double step_px = 3;
  // A segment is a line in space if at least so many of its points, and at
  // least this share of those that should have depth, lie on one.
  int min_points = 6;
  double min_support = 0.6;
};

// A line in space: point + t * direction, with a direction of length 1.
struct SpaceLine {
  geometry::Vec3 point;
  geometry::Vec3 direction;
};

// Points on lines, in the frame of RgbdSamples.
struct LinePoints {
  // samples.point[i] lies on its line exactly: it is where the ray of its
  // pixel meets the line.
  RgbdSamples samples;
  std::vector<int32_t> line;  // of sample i: index into `lines`
  std::vector<SpaceLine> lines;

  size_t size() const { return samples.size(); }
  void clear();
};

// Segments of at least min_length_px (px of level 0), longest first, at most
// max_segments; see FindLineSegments.
std::vector<LineSegment> DetectLineSegments(const GrayPyramid& pyramid,
                                            const LineOptions& options);

// Points at even steps along the segments of the colour image that have depth
// and belong to a line in space. The inverse depth of a line is linear along
// its image, and a structured-light camera's noise is even in it, so a line is
// fitted to (step, 1 / z) by RANSAC and least squares, which is blind neither
// to gaps nor to points on whatever lies behind an edge. Where surfaces meet
// within 2 px, the nearer one owns the edge. Keeps to points whose 64 x 64
// patch lies inside the image. The result depends on the arguments alone.
void LiftSegments(const DepthGeometry& geometry, const image::DepthImage& depth,
                  const std::vector<LineSegment>& segments,
                  const LineOptions& options, LinePoints& points);

// Up to `count` of `points` at random, in random order, each at most once.
void DrawLinePoints(const LinePoints& points, int count, base::Random random,
                    LinePoints& drawn);

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_LINE_SEGMENTS_H_
