// One camera for pictures that were taken with cameras that differ a little.
#ifndef SERVER_TOOLS_CAPTURE_COMMON_CAMERA_H_
#define SERVER_TOOLS_CAPTURE_COMMON_CAMERA_H_

#include <vector>

#include "absl/status/statusor.h"
#include "common/camera/camera.h"
#include "common/image/image.h"
#include "server/tools/capture/capture.h"

namespace treeline::capture {

// The camera of the frame with the median focal length, among those with the
// most frequent size of picture. At least one frame.
camera::Camera MedianCamera(const std::vector<CaptureFrame>& frames);

// How far apart the two cameras, of one size, see the same ray, at most, over a
// grid of pixels (px).
double LargestDifference_px(const camera::Camera& a, const camera::Camera& b);

// The picture that `to`, of any size, would have taken in the place of `from`.
// What `from` does not see is black. Smaller pictures are averages.
absl::StatusOr<image::ColorImage> Resampled(const image::ColorImage& image,
                                            const camera::Camera& from,
                                            const camera::Camera& to);
// The same of depth, with the value of the nearest pixel; the size stays.
image::DepthImage Resampled(const image::DepthImage& image,
                            const camera::Camera& from,
                            const camera::Camera& to);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_COMMON_CAMERA_H_
