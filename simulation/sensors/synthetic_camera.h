// An RGB-D camera of the first Kinect's kind: what its two cameras measure of
// an ideal picture.
#ifndef SIMULATION_SENSORS_SYNTHETIC_CAMERA_H_
#define SIMULATION_SENSORS_SYNTHETIC_CAMERA_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "common/camera/rgbd_calibration.h"
#include "common/image/frame.h"
#include "simulation/renderer/renderer.h"

namespace treeline::sensors {

// The colour camera's exposure, white balance and noise.
struct ColorSensorOptions {
  // Radiance 1 times this is 1 before the tone curve. In (0, 100].
  double exposure = 3.4;
  // Exposes each picture by itself instead, so that the mean of the logarithm
  // of its radiance lands where the eye sees a middle grey (Reinhard 2002), as
  // far as shutter and gain go: from min_exposure to max_exposure, in (0, 100].
  bool is_automatic = false;
  double min_exposure = 0.1;
  double max_exposure = 100;
  // The share, in the logarithm, of a picture's colour cast that the camera
  // takes for the light's and removes (grey world: Buchsbaum 1980). In [0, 1].
  double white_balance = 0;
  // Standard deviation of the logarithm of the gains of red and of blue, which
  // are a draw of each camera (seed). In [0, 0.5].
  double white_balance_error = 0;
  // Noise before the tone curve, of exposed radiance e L: its variance is
  // shot_noise e (e L) + (read_noise e)^2, so that it grows with the exposure
  // that darkness takes. In [0, 0.1].
  double shot_noise = 0;
  double read_noise = 0;
  // Standard deviation of a channel, in the 8-bit picture's levels. [0, 50].
  double noise_levels = 1.6;

  absl::Status Validate() const;
};

// How a camera is set that takes pictures in this light: by day as above, with
// a fixed exposure; otherwise it exposes and balances each picture by itself.
ColorSensorOptions ColorSensorFor(building::Lighting lighting);

// The depth camera's noise. Defaults: Nguyen, Izadi, Lovell 2012 (axial noise)
// and Khoshelham, Elberink 2012 (quantisation of the disparity).
struct DepthSensorOptions {
  double min_range_m = 0.4;
  double max_range_m = 4.5;
  // Standard deviation along the axis: base + square (z - 0.4 m)^2.
  double axial_base_m = 0.0012;
  double axial_square_per_m = 0.0019;
  // Disparity is measured in eighths of a pixel between the depth camera and
  // a projector this far to its right; depth steps by z^2 / (8 f baseline).
  double projector_baseline_m = 0.075;
  double disparity_steps_per_px = 8;
  // Surfaces seen at a smaller angle than the first (between ray and surface)
  // are lost, at a larger one than the second never; in between by chance.
  double lost_below_angle_deg = 10;
  double safe_above_angle_deg = 20;
  // Neighbours that differ by base + slope z make an edge; its pixels are lost
  // with this probability.
  double edge_base_m = 0.02;
  double edge_slope = 0.02;
  double edge_loss = 0.6;
  // Pixels lost anywhere.
  double random_loss = 0.003;
  // The share of what is behind glass that is lost, in patches of 8 x 8 pixels;
  // the rest is measured through it, with so many times the noise. The pane
  // itself is never measured.
  double glass_loss = 0.7;
  double glass_noise_factor = 2;

  absl::Status Validate() const;
};

// What ColorSensorOptions::is_automatic exposes a picture with.
double AutomaticExposure(const std::vector<worlds::Float3>& radiance,
                         const ColorSensorOptions& options);

// Noise-free radiance as an 8-bit picture with sensor noise. `frame` numbers
// the exposures: (seed, frame) determine the noise.
image::ColorImage ExposeColor(const renderer::PixelRays& rays,
                              const std::vector<worlds::Float3>& radiance,
                              const ColorSensorOptions& options, uint64_t seed,
                              uint64_t frame, int threads);

// Ideal depth as measured, in millimetres along the optical axis. Lost: out of
// range, not lit by the projector, at edges, at grazing angles, by chance.
image::DepthImage MeasureDepth(
    const renderer::PixelRays& rays,
    const std::vector<renderer::DepthSample>& samples,
    const DepthSensorOptions& options, uint64_t seed, uint64_t frame,
    int threads);

// What the colour camera of `calibration` would measure if it measured depth:
// each pixel of `depth` moved to where the colour camera sees its point, the
// nearest where several meet; 0 where none does. The result has colour's size
// and the same unit.
image::DepthImage RegisterDepth(const image::DepthImage& depth,
                                const camera::RgbdCalibration& calibration);

// The pair, rigidly mounted. Immutable and thread-safe.
class SyntheticCamera {
 public:
  struct Options {
    // The colour camera is 2.5 cm to the right of the depth camera, so that
    // depth is not registered; poses are the depth camera's, as in 7-Scenes.
    camera::RgbdCalibration calibration = DefaultCalibration();
    ColorSensorOptions color;
    DepthSensorOptions depth;
    // Whether frames have RegisterDepth's depth.
    bool is_depth_registered = false;
    uint64_t seed = 0;
  };
  static camera::RgbdCalibration DefaultCalibration();

  // INVALID_ARGUMENT for options out of range, or a depth scale other than 1.
  static absl::StatusOr<SyntheticCamera> Create(
      std::shared_ptr<const renderer::Renderer> renderer,
      const Options& options);

  const camera::RgbdCalibration& calibration() const {
    return options_.calibration;
  }
  const renderer::Renderer& renderer() const { return *renderer_; }

  // What the pair sees with its pose sensor at world_from_camera, of the world
  // without bodies or as in the snapshot. The frame's calibration is left
  // empty.
  image::Frame Capture(const geometry::Rigid3& world_from_camera,
                       uint64_t frame, int threads) const;
  image::Frame Capture(const renderer::WorldSnapshot& snapshot,
                       const geometry::Rigid3& world_from_camera,
                       uint64_t frame, int threads) const;

  // The same of a camera that moves while the colour camera's shutter is open:
  // the mean of what is seen from these poses, at least one, evenly spaced in
  // time. Depth is as from the middle one.
  image::Frame CaptureMoving(
      const renderer::WorldSnapshot& snapshot,
      std::span<const geometry::Rigid3> world_from_camera, uint64_t frame,
      int threads) const;

  // The same of a camera whose rows are exposed one after the other, those of
  // colour and of depth alike: in bands of kRollingBand_px rows, each from
  // where the pose sensor is when its middle is exposed. `pose_at` takes
  // image::RowShare.
  image::Frame CaptureRolling(
      const renderer::WorldSnapshot& snapshot,
      const std::function<geometry::Rigid3(double row_share)>& pose_at,
      uint64_t frame, int threads) const;
  static constexpr int kRollingBand_px = 8;

 private:
  SyntheticCamera(std::shared_ptr<const renderer::Renderer> renderer,
                  const Options& options);
  image::Frame Measured(const std::vector<worlds::Float3>& radiance,
                        const std::vector<renderer::DepthSample>& samples,
                        uint64_t frame, int threads) const;

  std::shared_ptr<const renderer::Renderer> renderer_;
  Options options_;
  renderer::PixelRays color_rays_;
  renderer::PixelRays depth_rays_;
};

}  // namespace treeline::sensors

#endif  // SIMULATION_SENSORS_SYNTHETIC_CAMERA_H_
