// The cameras that queries of a recording are said to be taken with.
#ifndef EVALUATION_ACCURACY_QUERY_CALIBRATION_H_
#define EVALUATION_ACCURACY_QUERY_CALIBRATION_H_

#include <optional>

#include "common/camera/rgbd_calibration.h"
#include "common/dataset/dataset.h"

namespace treeline::accuracy {

// Whether a stated camera may be the one that training refined: pictures of one
// size, focal lengths within 3 % and principal points within 3 % of the size.
bool MayBeOneCamera(const camera::Camera& a, const camera::Camera& b);

// What to tell the localizer about the camera of `dataset`.
//
// A scene's stored calibration may have been estimated from its training
// frames, and knows more than a format's default does. So it is kept (nullopt)
// unless the recording is known to come from other cameras: because the user
// named them (`options`), because its pictures have another size, or because
// depth is registered to a colour camera that is not the scene's. Then those
// cameras replace the stored ones, unless they may be the very ones that
// training refined (MayBeOneCamera); the depth scale, a property of the scene's
// unit of length, stays the scene's, and so does the offset between cameras
// that are not registered, unless pictures of another size come with one of
// their own. The frames of a structure from motion come with their own cameras
// (nullopt).
std::optional<camera::RgbdCalibration> QueryCalibration(
    const dataset::Dataset& dataset, const dataset::DatasetOptions& options,
    const camera::RgbdCalibration& scene_calibration);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_QUERY_CALIBRATION_H_
