#include "server/tools/photographs/testing_walk.h"

#include <cmath>

#include "absl/strings/str_format.h"
#include "common/camera/rgbd_calibration.h"
#include "server/core/training/box_room_recording.h"

namespace treeline::photographs {

geometry::Rigid3 AlongTheWall(double along_m, double yaw_rad, double height_m) {
  const geometry::Rotation3 level{0.5, -0.5, 0.5, -0.5};
  const geometry::Rotation3 turn{std::cos(yaw_rad / 2), 0, 0,
                                 std::sin(yaw_rad / 2)};
  return {turn * level, {-0.8, along_m, height_m}};
}

std::string WalkCameraText(int width, int height) {
  return absl::StrFormat("PINHOLE,400,400,%g,%g", (width - 1) / 2.0,
                         (height - 1) / 2.0);
}

image::ColorImage PictureOfRoom(const geometry::Rigid3& world_from_camera,
                                int width, int height) {
  camera::RgbdCalibration calibration;
  calibration.color = calibration.depth =
      camera::Camera::Parse(WalkCameraText(width, height), width, height)
          .value();
  return training::RenderBoxRoom(calibration, world_from_camera,
                                 training::BoxRoomWalls::kTiled)
      .color;
}

}  // namespace treeline::photographs
