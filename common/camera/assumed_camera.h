// The camera of a picture of which a client does not say which it is.
#ifndef COMMON_CAMERA_ASSUMED_CAMERA_H_
#define COMMON_CAMERA_ASSUMED_CAMERA_H_

#include <optional>

#include "common/camera/camera.h"

namespace treeline::camera {

// For a picture of width x height pixels, 1..16384, that is not of `scene`, the
// camera that learnt the scene: not as large, or of another lens. `focal_35mm`:
// the focal length in terms of film of 36 x 24 mm (of the same diagonal), as
// EXIF states it; nullopt or absurd: not known. In this order:
// * of the shape of the scene's pictures, and nothing else stated than their
//   focal length (to within 5 %): their camera, resized;
// * the stated focal length;
// * that of most phones and webcams, 67 degrees across the longer side.
// But for the first, without distortion and with the principal point in the
// middle. A guess: the localizer has to confirm the focal length.
Camera AssumedCamera(int width, int height, std::optional<double> focal_35mm,
                     const Camera& scene);

// Whether a picture as large as those of `scene` was taken through another of a
// phone's lenses, or magnified: `focal_35mm`, as above, says more than 1.25
// times the scene's focal length, or less than 0.8 times. What EXIF rounds and
// videos cut off for being steadied is less. False: not known.
bool IsOfAnotherLens(std::optional<double> focal_35mm, const Camera& scene);

}  // namespace treeline::camera

#endif  // COMMON_CAMERA_ASSUMED_CAMERA_H_
