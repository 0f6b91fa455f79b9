#include "simulation/sensors/synthetic_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/base/check_range.h"
#include "common/base/parallel_for.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "common/image/rolling_shutter.h"

namespace treeline::sensors {
namespace {

constexpr float kPi = 3.14159265f;
// Where the tone curve reaches white, in units of exposed radiance.
constexpr float kWhite = 4;

// Of a camera's error in white balance.
constexpr uint64_t kBalanceStream = 0xba1;

// 64 random bits of one pixel: a function of where, when and what for.
class PixelNoise {
 public:
  PixelNoise(uint64_t seed, uint64_t frame, uint64_t purpose)
      : state_(base::MixBits(seed + 0x9e3779b97f4a7c15u) ^
               base::MixBits(frame * 0xd1b54a32d192ed03u + purpose)) {}
  uint64_t At(size_t pixel) const {
    return base::MixBits(state_ + 0x9e3779b97f4a7c15u * (pixel + 1));
  }

 private:
  uint64_t state_;
};

// Nearly normal with mean 0 and variance 1: the sum of four uniform numbers of
// 16 bits each. It never exceeds 3.47, and costs a tenth of Box-Muller.
float NearlyNormal(uint64_t bits) {
  const uint64_t sum = (bits & 0xffff) + ((bits >> 16) & 0xffff) +
                       ((bits >> 32) & 0xffff) + (bits >> 48);
  return (static_cast<float>(sum) - 131070.0f) * (1 / 37837.2f);
}

float Unit(uint64_t bits) {
  return static_cast<float>(bits >> 40) * 0x1.0p-24f;
}

// A film-like curve: steep for shadows, white at kWhite (Reinhard 2002).
float Tone(float exposed) {
  return exposed * (1 + exposed / (kWhite * kWhite)) / (1 + exposed);
}

// std::round of numbers from 0 to 2^31, without a call into the library.
float RoundPositive(float value) {
  return static_cast<float>(static_cast<int>(value + 0.5f));
}

// One row of measured depth.
class DepthRow {
 public:
  DepthRow(const renderer::PixelRays& rays, const DepthSensorOptions& options,
           const std::vector<renderer::DepthSample>& samples)
      : width_(rays.width()),
        height_(rays.height()),
        options_(options),
        samples_(samples),
        glass_loss_(static_cast<float>(options.glass_loss)),
        glass_noise_(static_cast<float>(options.glass_noise_factor)),
        disparity_m_(rays.focal_length_px() *
                     static_cast<float>(options.projector_baseline_m)),
        lost_sine_(std::sin(static_cast<float>(options.lost_below_angle_deg) *
                            kPi / 180)),
        safe_sine_(std::sin(static_cast<float>(options.safe_above_angle_deg) *
                            kPi / 180)) {}

  void Measure(int y, const PixelNoise& noise, const PixelNoise& chance,
               uint16_t* out) const {
    const size_t first = static_cast<size_t>(y) * static_cast<size_t>(width_);
    // Light of the projector, on the right, that passes a near surface falls
    // on the far one behind only so far to the left. Going left, a pixel is in
    // shadow if its light would have to come from where it already has.
    float lit_until = 1e9f;
    for (int x = width_ - 1; x >= 0; --x) {
      const size_t i = first + static_cast<size_t>(x);
      const float z = samples_[i].depth_m;
      out[x] = 0;
      if (!(z > 0)) continue;
      const float from_projector = static_cast<float>(x) - disparity_m_ / z;
      const bool in_shadow = from_projector >= lit_until;
      lit_until = std::min(lit_until, from_projector);
      if (in_shadow || IsLost(x, y, i, Unit(chance.At(i)))) continue;
      float normal = NearlyNormal(noise.At(i));
      if (samples_[i].is_behind_glass) {
        if (Unit(chance.At(PatchOf(x, y))) < glass_loss_) continue;
        normal *= glass_noise_;
      }
      out[x] = Quantised(z, normal);
    }
  }

 private:
  // A number that no pixel has.
  size_t PatchOf(int x, int y) const {
    constexpr int kPatch_px = 8;
    return samples_.size() +
           static_cast<size_t>(y / kPatch_px) * static_cast<size_t>(width_) +
           static_cast<size_t>(x / kPatch_px);
  }

  bool IsLost(int x, int y, size_t i, float chance) const {
    const renderer::DepthSample& sample = samples_[i];
    const float z = sample.depth_m;
    if (z < static_cast<float>(options_.min_range_m) ||
        z > static_cast<float>(options_.max_range_m)) {
      return true;
    }
    // The incidence's cosine to the normal is the sine to the surface.
    const float sine = sample.incidence;
    if (sine < lost_sine_) return true;
    float loss = static_cast<float>(options_.random_loss);
    if (sine < safe_sine_) {
      loss = std::max(loss, (safe_sine_ - sine) / (safe_sine_ - lost_sine_));
    }
    const float edge = static_cast<float>(options_.edge_base_m) +
                       static_cast<float>(options_.edge_slope) * z;
    const size_t row = static_cast<size_t>(width_);
    const auto is_edge = [&](size_t neighbour) {
      return std::abs(samples_[neighbour].depth_m - z) > edge;
    };
    if ((x > 0 && is_edge(i - 1)) || (x + 1 < width_ && is_edge(i + 1)) ||
        (y > 0 && is_edge(i - row)) || (y + 1 < height_ && is_edge(i + row))) {
      loss = std::max(loss, static_cast<float>(options_.edge_loss));
    }
    return chance < loss;
  }

  // Millimetres, of noisy depth in steps of disparity.
  uint16_t Quantised(float z, float normal) const {
    const float away = z - 0.4f;
    const float sigma =
        static_cast<float>(options_.axial_base_m) +
        static_cast<float>(options_.axial_square_per_m) * away * away;
    const float noisy = std::max(z + sigma * normal, 0.01f);
    const float steps =
        disparity_m_ * static_cast<float>(options_.disparity_steps_per_px);
    const float quantised =
        steps / std::max(RoundPositive(steps / noisy), 1.0f);
    return static_cast<uint16_t>(
        RoundPositive(std::min(1000 * quantised, 65534.0f)));
  }

  int width_;
  int height_;
  const DepthSensorOptions& options_;
  const std::vector<renderer::DepthSample>& samples_;
  float glass_loss_;
  float glass_noise_;
  float disparity_m_;  // disparity (px) times depth (m)
  float lost_sine_;
  float safe_sine_;
};

}  // namespace

absl::Status ColorSensorOptions::Validate() const {
  TL_RETURN_IF_ERROR(base::CheckRange("exposure", exposure, 1e-6, 100));
  TL_RETURN_IF_ERROR(
      base::CheckRange("lowest exposure", min_exposure, 1e-6, 100));
  TL_RETURN_IF_ERROR(
      base::CheckRange("highest exposure", max_exposure, min_exposure, 100));
  TL_RETURN_IF_ERROR(base::CheckRange("white balance", white_balance, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("white balance error", white_balance_error, 0, 0.5));
  TL_RETURN_IF_ERROR(base::CheckRange("shot noise", shot_noise, 0, 0.1));
  TL_RETURN_IF_ERROR(base::CheckRange("read noise", read_noise, 0, 0.1));
  return base::CheckRange("colour noise (levels)", noise_levels, 0, 50);
}

absl::Status DepthSensorOptions::Validate() const {
  TL_RETURN_IF_ERROR(base::CheckRange("depth range (m)", min_range_m, 0, 60));
  TL_RETURN_IF_ERROR(
      base::CheckRange("depth range (m)", max_range_m, min_range_m, 60));
  TL_RETURN_IF_ERROR(base::CheckRange("axial noise (m)", axial_base_m, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("axial noise (1/m)", axial_square_per_m, 0, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("projector baseline (m)",
                                      projector_baseline_m, 0.001, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("disparity steps per pixel",
                                      disparity_steps_per_px, 0.1, 1000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("grazing angle (deg)", lost_below_angle_deg, 0, 89));
  TL_RETURN_IF_ERROR(base::CheckRange(
      "grazing angle (deg)", safe_above_angle_deg, lost_below_angle_deg, 90));
  TL_RETURN_IF_ERROR(base::CheckRange("depth edge (m)", edge_base_m, 0, 10));
  TL_RETURN_IF_ERROR(base::CheckRange("depth edge slope", edge_slope, 0, 10));
  TL_RETURN_IF_ERROR(base::CheckRange("loss at depth edges", edge_loss, 0, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("random loss", random_loss, 0, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("loss behind glass", glass_loss, 0, 1));
  return base::CheckRange("noise factor behind glass", glass_noise_factor, 0,
                          100);
}

ColorSensorOptions ColorSensorFor(building::Lighting lighting) {
  if (lighting == building::Lighting::kDay) return {};
  return {.is_automatic = true,
          // A shutter of 1 ms without gain, and one of 33 ms with a gain of
          // about 20 dB. By day it is 3.4.
          .min_exposure = 0.1,
          .max_exposure = 30,
          // Cameras leave lamps much of their colour, and a grey world takes
          // wood and brick for warm light; no two of them agree.
          .white_balance = 0.4,
          .white_balance_error = 0.05,
          // At e = 3.4 a middle grey (0.35) has 2.4 % of shot and 1.2 % of read
          // noise, 1.2 levels together; at e = 30 it is 12 %, 6 levels, and in
          // the shadows more than what there is to see.
          .shot_noise = 6e-5,
          .read_noise = 1.2e-3};
}

double AutomaticExposure(const std::vector<worlds::Float3>& radiance,
                         const ColorSensorOptions& options) {
  // Middle grey, as exposed radiance: what the room has at 3.4.
  constexpr double kKey = 0.35;
  constexpr size_t kStep = 7;
  double sum = 0;
  double count = 0;
  for (size_t i = 0; i < radiance.size(); i += kStep) {
    const float mean =
        (radiance[i].x + radiance[i].y + radiance[i].z) * (1.0f / 3);
    if (!(mean > 0)) continue;
    sum += std::log(std::max(mean, 1e-4f));
    count += 1;
  }
  if (count == 0) return 1;
  return std::clamp(kKey / std::exp(sum / count), options.min_exposure,
                    options.max_exposure);
}

namespace {

// What a picture's channels are multiplied with: exposure, white balance and
// the camera's error in it.
std::array<float, 3> GainsFor(const std::vector<worlds::Float3>& radiance,
                              const ColorSensorOptions& options,
                              uint64_t seed) {
  const float exposure = static_cast<float>(
      options.is_automatic ? AutomaticExposure(radiance, options)
                           : options.exposure);
  std::array<float, 3> gains = {exposure, exposure, exposure};
  if (options.white_balance > 0) {
    // What is as bright as a lamp says nothing about the light on other things.
    const float brightest = kWhite / exposure;
    std::array<double, 3> sums = {1e-9, 1e-9, 1e-9};
    constexpr size_t kStep = 7;
    for (size_t i = 0; i < radiance.size(); i += kStep) {
      const worlds::Float3& at = radiance[i];
      if (std::max({at.x, at.y, at.z}) > brightest) continue;
      sums[0] += at.x;
      sums[1] += at.y;
      sums[2] += at.z;
    }
    for (const size_t c : {size_t{0}, size_t{2}}) {
      // What a camera can balance: from candles to a blue sky.
      const double cast = std::clamp(sums[1] / sums[c], 0.4, 4.0);
      gains[c] *= static_cast<float>(std::pow(cast, options.white_balance));
    }
  }
  if (options.white_balance_error > 0) {
    base::Random random(seed, kBalanceStream);
    for (const size_t c : {size_t{0}, size_t{2}}) {
      gains[c] *= static_cast<float>(
          std::exp(options.white_balance_error * random.NextGaussian()));
    }
  }
  return gains;
}

}  // namespace

image::ColorImage ExposeColor(const renderer::PixelRays& rays,
                              const std::vector<worlds::Float3>& radiance,
                              const ColorSensorOptions& options, uint64_t seed,
                              uint64_t frame, int threads) {
  image::ColorImage image{
      .width = rays.width(), .height = rays.height(), .rgb = {}};
  image.rgb.resize(3 * radiance.size());
  const PixelNoise noise(seed, frame, 1);
  const PixelNoise sensor_noise(seed, frame, 4);
  const std::array<float, 3> gains = GainsFor(radiance, options, seed);
  const float sigma = static_cast<float>(options.noise_levels);
  const float shot = static_cast<float>(options.shot_noise);
  const float read = static_cast<float>(options.read_noise);
  const bool is_noisy = shot > 0 || read > 0;
  base::ParallelFor(image.height, threads, [&](int64_t y) {
    const size_t width = static_cast<size_t>(image.width);
    for (size_t i = static_cast<size_t>(y) * width;
         i < (static_cast<size_t>(y) + 1) * width; ++i) {
      const float channels[] = {radiance[i].x, radiance[i].y, radiance[i].z};
      for (size_t c = 0; c < 3; ++c) {
        float exposed = gains[c] * channels[c];
        if (is_noisy) {
          const float floor = read * gains[c];
          const float variance = shot * gains[c] * exposed + floor * floor;
          exposed =
              std::max(exposed + std::sqrt(variance) *
                                     NearlyNormal(sensor_noise.At(3 * i + c)),
                       0.0f);
        }
        const float level = 255 * worlds::DisplayFromLinear(Tone(exposed)) +
                            sigma * NearlyNormal(noise.At(3 * i + c));
        image.rgb[3 * i + c] =
            static_cast<uint8_t>(std::clamp(level, 0.0f, 255.0f) + 0.5f);
      }
    }
  });
  return image;
}

image::DepthImage MeasureDepth(
    const renderer::PixelRays& rays,
    const std::vector<renderer::DepthSample>& samples,
    const DepthSensorOptions& options, uint64_t seed, uint64_t frame,
    int threads) {
  image::DepthImage image{.width = rays.width(),
                          .height = rays.height(),
                          .values = {},
                          .unit_m = 0.001};
  image.values.resize(samples.size());
  const PixelNoise noise(seed, frame, 2);
  const PixelNoise chance(seed, frame, 3);
  const DepthRow row(rays, options, samples);
  base::ParallelFor(image.height, threads, [&](int64_t y) {
    row.Measure(static_cast<int>(y), noise, chance,
                image.values.data() + y * image.width);
  });
  return image;
}

image::DepthImage RegisterDepth(const image::DepthImage& depth,
                                const camera::RgbdCalibration& calibration) {
  const camera::Camera& color = calibration.color;
  const renderer::PixelRays rays(calibration.depth);
  image::DepthImage registered{.width = color.width(),
                               .height = color.height(),
                               .values = {},
                               .unit_m = depth.unit_m};
  registered.values.resize(static_cast<size_t>(color.width()) *
                           static_cast<size_t>(color.height()));
  for (size_t i = 0; i < depth.values.size(); ++i) {
    const worlds::Float3 ray = rays.rays()[i];
    if (!image::IsMeasured(depth.values[i]) || !(ray.z > 0)) continue;
    const double z_m = depth.values[i] * depth.unit_m;
    const geometry::Vec3 point = calibration.color_from_depth *
                                 geometry::Vec3{z_m * ray.x, z_m * ray.y, z_m};
    if (!(point.z > 0)) continue;
    const camera::Pixel pixel = color.Project(point);
    const int x = static_cast<int>(std::lround(pixel.x));
    const int y = static_cast<int>(std::lround(pixel.y));
    if (x < 0 || y < 0 || x >= color.width() || y >= color.height()) continue;
    uint16_t& value = registered.values[static_cast<size_t>(y) *
                                            static_cast<size_t>(color.width()) +
                                        static_cast<size_t>(x)];
    const auto moved = static_cast<uint16_t>(
        std::clamp(point.z / depth.unit_m + 0.5, 1.0, 65534.0));
    if (value == 0 || moved < value) value = moved;
  }
  return registered;
}

camera::RgbdCalibration SyntheticCamera::DefaultCalibration() {
  camera::RgbdCalibration calibration;
  constexpr double kColor[] = {525, 525, 320, 240};
  constexpr double kDepth[] = {585, 585, 320, 240};
  calibration.color = *camera::Camera::Create(camera::CameraModel::kPinhole,
                                              640, 480, kColor, 4);
  calibration.depth = *camera::Camera::Create(camera::CameraModel::kPinhole,
                                              640, 480, kDepth, 4);
  calibration.color_from_depth.translation = {-0.025, 0, 0};
  calibration.pose_sensor = camera::RgbdSensor::kDepth;
  return calibration;
}

absl::StatusOr<SyntheticCamera> SyntheticCamera::Create(
    std::shared_ptr<const renderer::Renderer> renderer,
    const Options& options) {
  TL_RETURN_IF_ERROR(options.color.Validate());
  TL_RETURN_IF_ERROR(options.depth.Validate());
  if (options.calibration.depth_scale != 1) {
    return absl::InvalidArgumentError(
        "a synthetic world is in metres: its depth scale is 1");
  }
  return SyntheticCamera(std::move(renderer), options);
}

SyntheticCamera::SyntheticCamera(
    std::shared_ptr<const renderer::Renderer> renderer, const Options& options)
    : renderer_(std::move(renderer)),
      options_(options),
      color_rays_(options.calibration.color),
      depth_rays_(options.calibration.depth) {}

namespace {

// The camera of some rows of the picture.
camera::Camera RowsOf(const camera::Camera& camera, int top, int rows) {
  std::array<double, camera::Camera::kMaxParameters> parameters =
      camera.parameters();
  parameters[static_cast<size_t>(
      camera::CameraPrincipalPointIndex(camera.model()) + 1)] -= top;
  return *camera::Camera::Create(camera.model(), camera.width(), rows,
                                 parameters.data(),
                                 camera::CameraParameterCount(camera.model()));
}

}  // namespace

image::Frame SyntheticCamera::Capture(const geometry::Rigid3& world_from_camera,
                                      uint64_t frame, int threads) const {
  return Capture(renderer_->caster().At({}), world_from_camera, frame, threads);
}

image::Frame SyntheticCamera::Capture(const renderer::WorldSnapshot& snapshot,
                                      const geometry::Rigid3& world_from_camera,
                                      uint64_t frame, int threads) const {
  return CaptureMoving(snapshot, {&world_from_camera, 1}, frame, threads);
}

image::Frame SyntheticCamera::CaptureMoving(
    const renderer::WorldSnapshot& snapshot,
    std::span<const geometry::Rigid3> world_from_camera, uint64_t frame,
    int threads) const {
  const camera::RgbdCalibration& calibration = options_.calibration;
  const auto pose_of = [&](const geometry::Rigid3& pose,
                           camera::RgbdSensor sensor) {
    return camera::PoseOfSensor(pose, calibration.pose_sensor, sensor,
                                calibration);
  };
  std::vector<worlds::Float3> radiance;
  for (const geometry::Rigid3& pose : world_from_camera) {
    std::vector<worlds::Float3> seen = renderer_->RenderRadiance(
        snapshot, color_rays_, pose_of(pose, camera::RgbdSensor::kColor),
        threads);
    if (world_from_camera.size() == 1) {
      radiance = std::move(seen);
      break;
    }
    radiance.resize(seen.size());
    const float share = 1 / static_cast<float>(world_from_camera.size());
    for (size_t i = 0; i < seen.size(); ++i) {
      radiance[i] = radiance[i] + share * seen[i];
    }
  }
  const geometry::Rigid3& middle =
      world_from_camera[world_from_camera.size() / 2];
  return Measured(radiance,
                  renderer_->RenderDepth(
                      snapshot, depth_rays_,
                      pose_of(middle, camera::RgbdSensor::kDepth), threads),
                  frame, threads);
}

image::Frame SyntheticCamera::CaptureRolling(
    const renderer::WorldSnapshot& snapshot,
    const std::function<geometry::Rigid3(double row_share)>& pose_at,
    uint64_t frame, int threads) const {
  const camera::RgbdCalibration& calibration = options_.calibration;
  // Of each band of a camera's picture, what `render` makes of it.
  const auto by_bands = [&](const camera::Camera& camera,
                            camera::RgbdSensor sensor, const auto& render) {
    decltype(render(renderer::PixelRays(camera), geometry::Rigid3{})) all;
    for (int top = 0; top < camera.height(); top += kRollingBand_px) {
      const int rows = std::min(kRollingBand_px, camera.height() - top);
      const geometry::Rigid3 pose = camera::PoseOfSensor(
          pose_at(image::RowShare(top + 0.5 * (rows - 1), camera.height())),
          calibration.pose_sensor, sensor, calibration);
      const auto band =
          render(renderer::PixelRays(RowsOf(camera, top, rows)), pose);
      all.insert(all.end(), band.begin(), band.end());
    }
    return all;
  };
  return Measured(
      by_bands(
          calibration.color, camera::RgbdSensor::kColor,
          [&](const renderer::PixelRays& rays, const geometry::Rigid3& pose) {
            return renderer_->RenderRadiance(snapshot, rays, pose, threads);
          }),
      by_bands(
          calibration.depth, camera::RgbdSensor::kDepth,
          [&](const renderer::PixelRays& rays, const geometry::Rigid3& pose) {
            return renderer_->RenderDepth(snapshot, rays, pose, threads);
          }),
      frame, threads);
}

image::Frame SyntheticCamera::Measured(
    const std::vector<worlds::Float3>& radiance,
    const std::vector<renderer::DepthSample>& samples, uint64_t frame,
    int threads) const {
  image::Frame result;
  result.color = ExposeColor(color_rays_, radiance, options_.color,
                             options_.seed, frame, threads);
  result.depth = MeasureDepth(depth_rays_, samples, options_.depth,
                              options_.seed, frame, threads);
  if (options_.is_depth_registered) {
    result.depth = RegisterDepth(*result.depth, options_.calibration);
  }
  return result;
}

}  // namespace treeline::sensors
