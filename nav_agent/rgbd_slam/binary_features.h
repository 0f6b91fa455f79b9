// Corners of a picture with binary descriptors and depth.
#ifndef NAV_AGENT_RGBD_SLAM_BINARY_FEATURES_H_
#define NAV_AGENT_RGBD_SLAM_BINARY_FEATURES_H_

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "common/camera/rgbd_calibration.h"
#include "common/image/frame.h"

namespace treeline::rgbd_slam {

// 256 bits: the signs of brightness differences about a corner, turned to its
// orientation (ORB: Rublee, Rabaud, Konolige, Bradski, ICCV 2011).
using BinaryDescriptor = std::array<uint64_t, 4>;

// How many bits differ, 0..256.
int HammingDistance(const BinaryDescriptor& a, const BinaryDescriptor& b);

// Each level of the pyramid is this much smaller than the one below it.
constexpr double kPyramidScale = 1.2;
constexpr int kPyramidLevels = 8;
// kPyramidScale to the power of `octave`.
double OctaveScale(int octave);

struct ImageFeature {
  // Where an ideal pinhole with the colour camera's fx, fy, cx, cy sees it:
  // distortion is taken out.
  camera::Pixel pixel;
  // Level of the pyramid that it was found in, 0 the finest.
  int octave = 0;
  double angle_rad = 0;
  // Along the optical axis of the colour camera (m); 0: not measured.
  double depth_m = 0;
  BinaryDescriptor descriptor{};
};

// A pinhole without distortion; positions as Pixel has them.
struct Pinhole {
  double fx = 525;
  double fy = 525;
  double cx = 320;
  double cy = 240;

  camera::Pixel Project(geometry::Vec3 point_in_camera) const {
    return {fx * point_in_camera.x / point_in_camera.z + cx,
            fy * point_in_camera.y / point_in_camera.z + cy};
  }
  geometry::Vec3 PointAt(camera::Pixel pixel, double depth_m) const {
    return {depth_m * (pixel.x - cx) / fx, depth_m * (pixel.y - cy) / fy,
            depth_m};
  }
};

// The features of one picture, in cells so that those near a position are
// found without a look at all.
class FeatureSet {
 public:
  FeatureSet() = default;
  FeatureSet(int width, int height, std::vector<ImageFeature> features);

  int size() const { return static_cast<int>(features_.size()); }
  const ImageFeature& operator[](int i) const {
    return features_[static_cast<size_t>(i)];
  }
  const std::vector<ImageFeature>& all() const { return features_; }
  // Whether an undistorted position is in the picture.
  bool Contains(camera::Pixel pixel) const;
  // Indices of the features within radius_px of `pixel` (a square), into
  // `found`, which is cleared first.
  void Near(camera::Pixel pixel, double radius_px,
            std::vector<int>* found) const;

 private:
  int Column(double x) const;
  int Row(double y) const;

  double width_ = 0;
  double height_ = 0;
  int columns_ = 0;
  int rows_ = 0;
  std::vector<ImageFeature> features_;
  // Features of cell c: order_[begin_[c]] to order_[begin_[c + 1]].
  std::vector<int> begin_;
  std::vector<int> order_;
};

struct FeatureOptions {
  // Features of a picture, in [50, 5000].
  int count = 1000;
  // Least contrast of a corner (grey levels), in [1, 100].
  int contrast = 10;
  // Depth beyond is left out (m), in [0.5, 50].
  double max_depth_m = 6;

  absl::Status Validate() const;
};

// Finds corners (FAST) on all levels of a pyramid, spread evenly over the
// picture: each cell of a grid gives its strongest in turn until there are
// enough. Deterministic. Not thread-safe (it keeps its buffers).
class FeatureExtractor {
 public:
  FeatureExtractor(const camera::RgbdCalibration& calibration,
                   const FeatureOptions& options);
  ~FeatureExtractor();

  const Pinhole& pinhole() const { return pinhole_; }

  // INVALID_ARGUMENT if sizes are not those of the calibration.
  absl::StatusOr<FeatureSet> Extract(const image::Frame& frame);

 private:
  struct Detector;

  camera::RgbdCalibration calibration_;
  FeatureOptions options_;
  Pinhole pinhole_;
  // Whether depth needs to be moved into the colour camera.
  bool is_registered_ = false;
  std::unique_ptr<Detector> detector_;
};

}  // namespace treeline::rgbd_slam

#endif  // NAV_AGENT_RGBD_SLAM_BINARY_FEATURES_H_
