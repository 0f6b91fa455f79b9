// Pictures of worlds for people to look at.
#ifndef COMMON_SYNTHETIC_PICTURE_H_
#define COMMON_SYNTHETIC_PICTURE_H_

#include "common/geometry/rigid3.h"
#include "common/image/image.h"
#include "common/synthetic/renderer.h"

namespace treeline {

// A camera at `eye` that looks along yaw (from +x towards +y) and pitch (up).
Rigid3 LookingFrom(Vec3 eye_m, double yaw_rad, double pitch_rad);

// The whole world from high above, x to the right and y upwards. `opened` has
// no ceiling (Renderer::CreateOpened). Its shape is the world's.
ColorImage PictureFromAbove(const Renderer& opened,
                            const WorldSnapshot& snapshot, int longer_side_px,
                            int threads);

// What a camera with a field of view of 63 degrees sees, exposed by itself and
// without noise.
ColorImage PictureOf(const Renderer& renderer, const WorldSnapshot& snapshot,
                     const Rigid3& world_from_camera, int width_px,
                     int height_px, int threads);

// What a depth camera measures there, noise and losses included: red is near,
// blue is far, black was not measured.
ColorImage PictureOfDepth(const Renderer& renderer,
                          const WorldSnapshot& snapshot,
                          const Rigid3& world_from_camera, int width_px,
                          int height_px, int threads);

}  // namespace treeline

#endif  // COMMON_SYNTHETIC_PICTURE_H_
