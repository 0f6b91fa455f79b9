// Do the surfaces of different frames coincide? The geometric half of
// calibration.
#ifndef SERVER_CORE_TRAINING_SURFACE_CONSISTENCY_H_
#define SERVER_CORE_TRAINING_SURFACE_CONSISTENCY_H_

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/camera/rgbd_calibration.h"
#include "common/image/image.h"

namespace treeline::training {

// A depth frame with the pose of the calibration's pose sensor.
struct PosedDepth {
  image::DepthImage depth;
  geometry::Rigid3 world_from_sensor;
};

// Pairs of frames that see the same surfaces, and points to compare.
class SurfaceConsistency {
 public:
  // `nominal` decides which frames overlap; frames must outlive this object.
  SurfaceConsistency(const std::vector<PosedDepth>& frames,
                     const camera::RgbdCalibration& nominal);

  int pairs() const { return static_cast<int>(pairs_.size()); }

  // Finds, for each point to compare, the depth pixel of the other frame that
  // it falls on. Kept until the next call.
  void Associate(const camera::RgbdCalibration& calibration, int threads);

  // Distances along the surface normal between each point and the surface at
  // its associated pixel (m), in units of the depth noise expected there; a
  // smooth function of the calibration. `calibrations` are those whose
  // residuals are wanted: all within a step of numerical differentiation of
  // that of Associate, since rays of other depth cameras are found to first
  // order. residuals[i * calibrations.size() + k] belongs to point i, always
  // the same one, and calibration k; all of a point are 0 where it falls on no
  // surface.
  void Residuals(std::span<const camera::RgbdCalibration> calibrations,
                 int threads, std::vector<double>& residuals) const;
  // Root mean square of the distances (m) that are below cutoff_m, with the
  // calibration of Associate.
  double Rms_m(double cutoff_m) const;

 private:
  // A depth pixel of the other frame, and its surface's normal in the depth
  // camera's frame, as the calibration had it when they were associated.
  struct Partner {
    int32_t pixel = -1;  // -1: none
    geometry::Vec3 normal;
  };
  // The ray of a depth pixel, where it has one.
  using Ray = std::optional<camera::Pixel>;
  struct Pair {
    size_t from = 0;
    size_t to = 0;
    std::vector<uint32_t> pixels;   // compared depth pixels of `from`
    std::vector<Partner> partners;  // what they fall on, slot by slot
  };

  void SetCalibration(const camera::RgbdCalibration& calibration, int threads);

  void AssociatePair(Pair& pair) const;
  void PairResiduals(const Pair& pair,
                     std::span<const camera::RgbdCalibration> calibrations,
                     std::span<double> residuals) const;

  const std::vector<PosedDepth>& frames_;
  std::vector<Pair> pairs_;
  // Of the last association. Most calibrations that are compared with it have
  // the same depth camera, and undistorting pixels is what costs most.
  camera::RgbdCalibration calibration_;
  std::vector<Ray> rays_;  // of its depth pixels, row-major
};

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_SURFACE_CONSISTENCY_H_
