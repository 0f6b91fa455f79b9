// Pixels with depth, chosen at random: what training and queries start from.
#ifndef SERVER_CORE_FEATURES_RGBD_SAMPLES_H_
#define SERVER_CORE_FEATURES_RGBD_SAMPLES_H_

#include <cstdint>
#include <vector>

#include "common/base/random.h"
#include "common/camera/rgbd_calibration.h"
#include "common/image/image.h"

namespace treeline::features {

// Sample i in slot i of every array.
struct RgbdSamples {
  std::vector<int32_t> x;  // nearest colour pixel
  std::vector<int32_t> y;
  std::vector<int32_t> inverse_depth_q12;  // see InverseDepthQ12
  std::vector<geometry::Vec3> point;  // in the pose sensor's frame, m (scaled)
  std::vector<float> depth_sigma_m;

  size_t size() const { return x.size(); }
  void clear();
};

// Lifts depth pixels into space and sees them from the colour camera.
class DepthGeometry {
 public:
  explicit DepthGeometry(const camera::RgbdCalibration& calibration);

  const camera::RgbdCalibration& calibration() const { return calibration_; }

  // A depth pixel with a measured value seen from both cameras.
  struct Lifted {
    geometry::Vec3 point_in_color;
    geometry::Vec3 point_in_pose_sensor;
    camera::Pixel color_pixel;
  };
  // False where the depth pixel has no ray or lies behind the colour camera.
  bool Lift(int u, int v, double depth_m, Lifted& out) const;

 private:
  camera::RgbdCalibration calibration_;
  geometry::Mat3 color_from_depth_rotation_;
};

// Up to `count` samples, uniform over the depth pixels that are measured, seen
// within [0.2, 10] m and whose 64 x 64 patch lies inside the colour image.
// Gives up after 8 * count draws, so a frame with little depth gives fewer.
void DrawSamples(const DepthGeometry& geometry, const image::DepthImage& depth,
                 int count, base::Random random, RgbdSamples& samples);
// The first so many of them, in less time: fewer only if there are no more.
void DrawFirstSamples(const DepthGeometry& geometry,
                      const image::DepthImage& depth, int first, int count,
                      base::Random random, RgbdSamples& samples);

// `count` pixels whose patch lies inside an image of the camera's size, for
// queries without depth: inverse_depth_q12 is NoDepthQ12, and point is
// (x/z, y/z, 1) of the pixel's ray. Fewer where rays do not exist.
void DrawPixels(const camera::Camera& color, int count, base::Random random,
                RgbdSamples& samples);

// Standard deviation of a Kinect's depth at z metres (Nguyen, Izadi, Lovell
// 2012, axial): 0.0012 + 0.0019 (z - 0.4)^2.
double DepthSigma_m(double z_m);

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_RGBD_SAMPLES_H_
