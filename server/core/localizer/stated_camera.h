// What the camera that a query states says beside its focal length: whether
// that may be a guess, and how much of what the scene's camera sees it sees.
#ifndef SERVER_CORE_LOCALIZER_STATED_CAMERA_H_
#define SERVER_CORE_LOCALIZER_STATED_CAMERA_H_

#include <vector>

#include "common/camera/camera.h"

namespace treeline::localizer {

// Whether the focal length of `stated` may be a guess, to be confirmed by
// features. It is not where
// * it is that of the camera that learnt the scene, in pictures of the same
//   longer side (as they are, or resized) or in pixels (a window of them);
// * there is distortion, and not that of the scene's camera: who knows a lens
//   so well has measured it;
// * the principal point is far from the middle: guesses put it there. Such a
//   picture is a window of another, and so is known to whoever cut it out.
bool MayBeGuessed(const camera::Camera& stated, const camera::Camera& learnt);

// Whether it is a window of the pictures of the camera that learnt the scene,
// with the principal point in the very middle: whoever knows the focal length,
// and not where the window was cut out, states that.
bool MayBeCutElsewhere(const camera::Camera& stated,
                       const camera::Camera& learnt);

// What else the camera may be whose stated principal point is further from the
// middle than lenses are mounted, and not where that of the camera that learnt
// the scene is. That of a window of a picture is. But mostly such intrinsics
// belong to pictures of another size, or their cx and cy are exchanged, and
// features fit them nearly as well as the right ones, at a wrong pose. So, with
// the principal point in the middle:
// * the camera of the resized picture, if that brings it there;
// * the same focal lengths.
// Empty for all other cameras.
std::vector<camera::Camera> CentredCameras(const camera::Camera& stated,
                                           const camera::Camera& learnt);

// How many times as wide (tangent of half the angle across the longer side) a
// view the camera that learnt the scene has; at least 1.
double Narrowness(const camera::Camera& stated, const camera::Camera& learnt);

// By how many the picture of `stated` is reduced at least before features are
// sought, so that the smallest are as large in the scene as those that were
// learnt: finer ones have no counterparts, and there is room for so many only.
// Never so far that hardly any picture is left.
int FeatureReduction(const camera::Camera& stated,
                     const camera::Camera& learnt);

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_STATED_CAMERA_H_
