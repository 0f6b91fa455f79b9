// For tests: what a phone sees that is carried along a wall of the box room.
#ifndef SERVER_TOOLS_PHOTOGRAPHS_TESTING_WALK_H_
#define SERVER_TOOLS_PHOTOGRAPHS_TESTING_WALK_H_

#include <string>

#include "common/geometry/rigid3.h"
#include "common/image/frame.h"

namespace treeline::photographs {

// world_from_camera: level, before a wall of the room, turned a little about
// what is up.
geometry::Rigid3 AlongTheWall(double along_m, double yaw_rad, double height_m);

// A picture of the room, of a pinhole camera with 400 px focal length.
image::ColorImage PictureOfRoom(const geometry::Rigid3& world_from_camera,
                                int width, int height);

// That camera, as --camera takes it.
std::string WalkCameraText(int width, int height);

}  // namespace treeline::photographs

#endif  // SERVER_TOOLS_PHOTOGRAPHS_TESTING_WALK_H_
