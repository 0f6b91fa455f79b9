// A pose made exact, and put to the test: does the image look as the keyframes
// say, and does its depth lie on their surfaces?
#ifndef SERVER_CORE_KEYFRAMES_DIRECT_ALIGNMENT_H_
#define SERVER_CORE_KEYFRAMES_DIRECT_ALIGNMENT_H_

#include <optional>

#include "common/camera/rgbd_calibration.h"
#include "common/geometry/rigid3.h"
#include "common/image/image.h"
#include "server/core/features/gray_pyramid.h"
#include "server/core/keyframes/depth_scale.h"
#include "server/core/keyframes/keyframe_map.h"

namespace treeline::keyframes {

struct AlignmentOptions {
  // Levels of GrayPyramid, from coarse to fine.
  int first_level = 3;
  int last_level = 0;
  // Gauss-Newton steps at each.
  int iterations = 5;
  // Keyframes aligned with: those of which much should be seen from near by.
  int keyframes = 3;
  // The pose is the picture's alone; depth is compared with what is seen from
  // there.
  bool only_measures_depth = false;
  // Light differs over the picture; see LightField. Where it hardly does, there
  // is no alignment.
  bool evens_light = false;
};

struct Alignment {
  // Of the colour camera.
  geometry::Rigid3 world_from_camera;
  geometry::PoseCovariance covariance{};
  // Keyframe points that should be seen, and the share of them whose
  // brightness agrees with the image.
  int visible = 0;
  double agreement = 0;
  // The share of the keyframes' points that should be seen, in [0, 1].
  double overlap = 0;
  // Correlation of their brightness with the image's, in [-1, 1], each
  // keyframe's gain and offset taken out.
  double correlation = 0;
  // Points whose brightness agrees and where depth was measured, and the share
  // that lie on it.
  int measured = 0;
  double depth_agreement = 0;
  // See CellAgreement: of the points that lie on depth, or of all without.
  double contradicted = 0;
  // What speaks for another scale of depth: by EstimateDepthScale if depth was
  // only measured, else by DepthScaleStep. nullopt: nothing does.
  std::optional<DepthScale> depth_scale;
};

// Minimises, over the pose, the robust sum over keyframe points X of
//   (I(project(X)) - gain * I_keyframe(X) - offset)^2 / brightness noise^2
// from coarse to fine (direct alignment, as in Engel et al., DSO, 2016), and
// if there is depth also of the projective point-to-plane distances
//   (n . (measured point at project(X) - X))^2 / depth noise^2.
// nullopt: hardly a keyframe point should be visible. Poses
// further off than about 3 % of the image are not drawn in.
std::optional<Alignment> AlignToKeyframes(
    const KeyframeMap& map, const features::GrayPyramid& image,
    const image::DepthImage* depth, const camera::RgbdCalibration& calibration,
    const geometry::Rigid3& world_from_color, const AlignmentOptions& options);

}  // namespace treeline::keyframes

#endif  // SERVER_CORE_KEYFRAMES_DIRECT_ALIGNMENT_H_
