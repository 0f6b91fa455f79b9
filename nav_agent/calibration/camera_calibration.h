// A camera's place on a robot, from how both moved in one drive.
#ifndef NAV_AGENT_CALIBRATION_CAMERA_CALIBRATION_H_
#define NAV_AGENT_CALIBRATION_CAMERA_CALIBRATION_H_

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "common/camera/rgbd_calibration.h"
#include "common/geometry/rigid3.h"
#include "common/image/image.h"
#include "nav_agent/calibration/calibration.h"
#include "nav_agent/calibration/drive.h"

namespace treeline::calibration {

// Where the camera (the pose sensor of its calibration) was, by its own
// pictures, in any frame of its own.
struct CameraView {
  double time_s = 0;  // of the drive
  geometry::Rigid3 map_from_camera;
};

// x ahead, y to the left, z above the ground (m); where it looks: yaw to the
// left, down below the horizon, then roll about its axis, clockwise (rad); and
// how much later its pictures are stamped than wheel readings (s).
enum class CameraQuantity { kX, kY, kZ, kYaw, kDown, kRoll, kDelay };
inline constexpr int kCameraQuantities = 7;
const char* NameOf(CameraQuantity quantity);
const char* DriveFor(CameraQuantity quantity);

struct CameraCalibration {
  std::array<double, kCameraQuantities> assumed{};
  // As assumed where it is not known.
  std::array<Estimate, kCameraQuantities> estimates{};
  int stretches = 0;
  int outliers = 0;
  Residuals before;
  Residuals after;

  const Estimate& Of(CameraQuantity quantity) const {
    return estimates[static_cast<size_t>(quantity)];
  }
  // What was found, and as assumed what was not.
  geometry::Rigid3 BaseFromCamera() const;
};

// Hand and eye (R. Tsai, R. Lenz, T-RA 5(3), 1989) for a hand that moves in a
// plane: over stretches as Calibrate takes them, the base's motion by the
// calibrated wheels and the camera's by its pictures determine all of the
// camera's place but its height, which the plane does not show; turns give the
// axis (down, roll) and x, y, straight ways yaw. Robust least squares as in
// Calibrate. `heights_m`: of the floor below the camera (FloorBelow_m), one a
// picture; their median is z, known if there are ten.
//
// FAILED_PRECONDITION if there are fewer than kMinMotions stretches.
absl::StatusOr<CameraCalibration> CalibrateCamera(
    const Drive& drive, const Setup& found, std::span<const CameraView> views,
    std::span<const double> heights_m, const geometry::Rigid3& assumed);

// How far the floor is below the camera (m): the height at which the most of
// the depth image lies that is below it by 0.1 to 3 m, seen with the camera's
// rotation `base_from_camera`. nullopt: no height has a tenth of the pixels.
std::optional<double> FloorBelow_m(const image::DepthImage& depth,
                                   const camera::RgbdCalibration& calibration,
                                   const geometry::Rotation3& base_from_camera);

}  // namespace treeline::calibration

#endif  // NAV_AGENT_CALIBRATION_CAMERA_CALIBRATION_H_
