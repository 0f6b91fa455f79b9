// Camera models: COLMAP's names and parameter order.
#ifndef COMMON_CAMERA_CAMERA_H_
#define COMMON_CAMERA_CAMERA_H_

#include <array>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/geometry/vector3.h"

namespace treeline::camera {

// A position in an image, in pixels: x to the right, y down, and the centre of
// the top left pixel is (0, 0). (COLMAP puts it at (0.5, 0.5): its principal
// points are half a pixel larger.)
struct Pixel {
  double x = 0;
  double y = 0;
};

// Parameters in COLMAP's order:
enum class CameraModel {
  kSimplePinhole,        // f, cx, cy
  kPinhole,              // fx, fy, cx, cy
  kSimpleRadial,         // f, cx, cy, k
  kRadial,               // f, cx, cy, k1, k2
  kOpenCv,               // fx, fy, cx, cy, k1, k2, p1, p2
  kFullOpenCv,           // fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6
  kOpenCvFisheye,        // fx, fy, cx, cy, k1, k2, k3, k4
  kFov,                  // fx, fy, cx, cy, omega
  kSimpleRadialFisheye,  // f, cx, cy, k
  kRadialFisheye,        // f, cx, cy, k1, k2
  // fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, sx1, sy1
  kThinPrismFisheye,
};

// "PINHOLE" and so on, as COLMAP writes them.
absl::string_view CameraModelName(CameraModel model);
absl::StatusOr<CameraModel> ParseCameraModel(absl::string_view name);
int CameraParameterCount(CameraModel model);
// Where cx stands among the parameters; cy follows it.
int CameraPrincipalPointIndex(CameraModel model);

// Calibrated intrinsics of one camera. A plain immutable value. The camera
// frame has x right, y down, z forward.
class Camera {
 public:
  static constexpr int kMaxParameters = 12;

  // A pinhole of 640 x 480 with a Kinect's focal length.
  Camera() = default;

  // INVALID_ARGUMENT: wrong number of parameters, NaN, a focal length that is
  // not positive, FOV's omega outside (-pi, pi), or a size outside 1..16384.
  static absl::StatusOr<Camera> Create(CameraModel model, int width, int height,
                                       const double* parameters,
                                       int parameter_count);

  // From "MODEL,p1,p2,...", for instance "PINHOLE,585,585,320,240".
  static absl::StatusOr<Camera> Parse(absl::string_view text, int width,
                                      int height);
  // The inverse of Parse.
  std::string ToString() const;

  CameraModel model() const { return model_; }
  int width() const { return width_; }
  int height() const { return height_; }
  const std::array<double, kMaxParameters>& parameters() const {
    return parameters_;
  }
  double fx() const { return fx_; }
  double fy() const { return fy_; }
  double cx() const { return cx_; }
  double cy() const { return cy_; }
  bool has_distortion() const { return has_distortion_; }

  // The image of a point in the camera frame (m). Meaningful for z > 0 only.
  Pixel Project(geometry::Vec3 point_in_camera) const;

  // The ray through a pixel as (x/z, y/z) of its points. Distortion is
  // inverted by Newton iterations; nullopt where they do not converge (beyond
  // the edge of a strongly distorted image).
  std::optional<Pixel> Unproject(Pixel pixel) const;

  bool operator==(const Camera&) const = default;

 private:
  // Between ideal and imaged rays, focal length and principal point apart.
  Pixel Distort(Pixel ray) const;
  std::optional<Pixel> Undistort(Pixel distorted) const;

  CameraModel model_ = CameraModel::kPinhole;
  int width_ = 640;
  int height_ = 480;
  std::array<double, kMaxParameters> parameters_{585, 585, 320, 240};
  // Derived from the above.
  double fx_ = 585;
  double fy_ = 585;
  double cx_ = 320;
  double cy_ = 240;
  bool has_distortion_ = false;
};

inline double MeanFocal_px(const Camera& camera) {
  return 0.5 * (camera.fx() + camera.fy());
}

}  // namespace treeline::camera

#endif  // COMMON_CAMERA_CAMERA_H_
