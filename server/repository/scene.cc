#include "server/repository/scene.h"

namespace treeline::repository {

bool HasOwnCamera(const Scene& scene) {
  return scene.metadata != nullptr && scene.metadata->camera.has_value();
}

camera::RgbdCalibration QueryCalibration(const Scene& scene) {
  camera::RgbdCalibration calibration = scene.localizer->info().calibration;
  if (HasOwnCamera(scene)) {
    calibration.color = *scene.metadata->camera;
  }
  return calibration;
}

}  // namespace treeline::repository
