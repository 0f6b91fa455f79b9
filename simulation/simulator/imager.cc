#include "simulation/simulator/imager.h"

#include <cmath>
#include <utility>

#include "common/base/status_macros.h"
#include "simulation/sensors/synthetic_camera.h"
#include "simulation/simulator/random_streams.h"

namespace treeline::simulator {
namespace {

class SyntheticImager final : public Imager {
 public:
  SyntheticImager(std::shared_ptr<const renderer::Renderer> renderer,
                  sensors::SyntheticCamera camera, int threads)
      : renderer_(std::move(renderer)),
        camera_(std::move(camera)),
        threads_(threads) {}

  camera::RgbdCalibration Calibration() const override {
    return camera_.calibration();
  }
  image::Frame Capture(const CameraShot& shot) const override {
    const renderer::WorldSnapshot snapshot =
        renderer_->caster().At(shot.bodies);
    image::Frame frame =
        camera_.Capture(snapshot, shot.world_from_camera,
                        static_cast<uint64_t>(shot.sequence), threads_);
    frame.calibration = camera_.calibration();
    return frame;
  }

 private:
  std::shared_ptr<const renderer::Renderer> renderer_;
  sensors::SyntheticCamera camera_;
  int threads_;
};

// A pinhole camera's picture made smaller.
absl::StatusOr<camera::Camera> Scaled(const camera::Camera& camera,
                                      double scale) {
  const double parameters[] = {scale * camera.fx(), scale * camera.fy(),
                               scale * camera.cx(), scale * camera.cy()};
  return camera::Camera::Create(
      camera::CameraModel::kPinhole,
      static_cast<int>(std::lround(scale * camera.width())),
      static_cast<int>(std::lround(scale * camera.height())), parameters, 4);
}

}  // namespace

absl::StatusOr<std::shared_ptr<const Imager>> MakeImager(
    const worlds::World& world, uint64_t seed, double scale, bool is_lit,
    int threads) {
  TL_ASSIGN_OR_RETURN(std::shared_ptr<const renderer::Renderer> renderer,
                      is_lit ? renderer::Renderer::Create(world, threads)
                             : renderer::Renderer::CreateUnlit(world));
  sensors::SyntheticCamera::Options options;
  // The light of an unlit world is that of a cloudy day.
  if (is_lit) options.color = sensors::ColorSensorFor(world.lighting);
  if (scale != 1) {
    // Depth is as exact as that of the whole picture.
    options.depth.disparity_steps_per_px /= scale;
    TL_ASSIGN_OR_RETURN(options.calibration.color,
                        Scaled(options.calibration.color, scale));
    TL_ASSIGN_OR_RETURN(options.calibration.depth,
                        Scaled(options.calibration.depth, scale));
  }
  options.seed = RandomFor(seed, SimRandom::kCamera, 0).NextBits();
  TL_ASSIGN_OR_RETURN(sensors::SyntheticCamera camera,
                      sensors::SyntheticCamera::Create(renderer, options));
  return std::make_shared<const SyntheticImager>(std::move(renderer),
                                                 std::move(camera), threads);
}

}  // namespace treeline::simulator
