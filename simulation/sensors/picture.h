// Pictures of worlds for people to look at.
#ifndef SIMULATION_SENSORS_PICTURE_H_
#define SIMULATION_SENSORS_PICTURE_H_

#include "common/geometry/rigid3.h"
#include "common/image/image.h"
#include "simulation/renderer/renderer.h"

namespace treeline::sensors {

// A camera at `eye` that looks along yaw (from +x towards +y) and pitch (up).
geometry::Rigid3 LookingFrom(geometry::Vec3 eye_m, double yaw_rad,
                             double pitch_rad);

// The whole world from high above, x to the right and y upwards. `opened` has
// no ceiling (Renderer::CreateOpened). Its shape is the world's.
image::ColorImage PictureFromAbove(const renderer::Renderer& opened,
                                   const renderer::WorldSnapshot& snapshot,
                                   int longer_side_px, int threads);

// What a camera with a field of view of 63 degrees sees, exposed by itself and
// without noise.
image::ColorImage PictureOf(const renderer::Renderer& renderer,
                            const renderer::WorldSnapshot& snapshot,
                            const geometry::Rigid3& world_from_camera,
                            int width_px, int height_px, int threads);

// What a depth camera measures there, noise and losses included: red is near,
// blue is far, black was not measured.
image::ColorImage PictureOfDepth(const renderer::Renderer& renderer,
                                 const renderer::WorldSnapshot& snapshot,
                                 const geometry::Rigid3& world_from_camera,
                                 int width_px, int height_px, int threads);

}  // namespace treeline::sensors

#endif  // SIMULATION_SENSORS_PICTURE_H_
