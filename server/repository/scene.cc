#include "server/repository/scene.h"

namespace treeline {

bool HasOwnCamera(const Scene& scene) {
  return scene.metadata != nullptr && scene.metadata->camera.has_value();
}

RgbdCalibration QueryCalibration(const Scene& scene) {
  RgbdCalibration calibration = scene.localizer->info().calibration;
  if (HasOwnCamera(scene)) {
    calibration.color = *scene.metadata->camera;
  }
  return calibration;
}

}  // namespace treeline
