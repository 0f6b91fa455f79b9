#include "evaluation/accuracy/perturbation_effects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "common/base/status_macros.h"
#include "common/camera/derived_camera.h"
#include "common/image/decode.h"
#include "common/image/quarter_turn.h"
#include "opencv2/core.hpp"
#include "opencv2/imgproc.hpp"
#include "server/core/training/trial_views.h"

namespace treeline::accuracy {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180;
constexpr int kHole_px = 24;
// How much more a warm lamp changes red, and how much less blue.
constexpr double kWarmth = 0.15;
// Of a thing that covers the picture (m).
constexpr double kNearest_m = 0.5;
constexpr double kFarthest_m = 1;

uint8_t ToByte(double value) {
  return static_cast<uint8_t>(std::clamp(std::lround(value), 0L, 255L));
}

// The pixels themselves, not a copy.
cv::Mat MatOf(image::ColorImage& image) {
  return {image.height, image.width, CV_8UC3, image.rgb.data()};
}
cv::Mat MatOf(image::DepthImage& image) {
  return {image.height, image.width, CV_16UC1, image.values.data()};
}

void Set(const cv::Mat& mat, image::ColorImage& image) {
  image.width = mat.cols;
  image.height = mat.rows;
  image.rgb.assign(mat.datastart, mat.dataend);
}
void Set(const cv::Mat& mat, image::DepthImage& image) {
  image.width = mat.cols;
  image.height = mat.rows;
  image.values.assign(mat.begin<uint16_t>(), mat.end<uint16_t>());
}

// change(source, result, nearest) of the colour picture, and of depth, between
// whose values nothing may be interpolated.
template <typename Change>
void ChangePictures(image::Frame& frame, const Change& change) {
  cv::Mat result;
  change(MatOf(frame.color), result, /*nearest=*/false);
  Set(result, frame.color);
  if (!frame.depth) return;
  change(MatOf(*frame.depth), result, /*nearest=*/true);
  Set(result, *frame.depth);
}

// value(v) of every measured depth, in its own units. What leaves the range of
// the image is not measured.
template <typename Value>
void MapDepth(image::Frame& frame, const Value& value) {
  if (!frame.depth) return;
  for (uint16_t& v : frame.depth->values) {
    if (!image::IsMeasured(v)) continue;
    const double changed = std::round(value(static_cast<double>(v)));
    v = static_cast<uint16_t>(changed >= 1 && changed < 65535 ? changed : 0);
  }
}

// The cameras turned about their optical axes.
void TurnCameras(const geometry::Rigid3& turned_from_camera,
                 PerturbedFrame& view) {
  geometry::Rigid3& color_from_depth = view.frame.calibration->color_from_depth;
  // Registered depth stays so to the last bit.
  if (color_from_depth != geometry::Rigid3{}) {
    color_from_depth =
        turned_from_camera * color_from_depth * turned_from_camera.Inverse();
  }
  view.turned_from_sensor = turned_from_camera * view.turned_from_sensor;
}

// What `camera` sees of a picture that `source_camera` took from the same
// place; black, or unmeasured, where that saw nothing.
void Resample(const camera::Camera& source_camera,
              const geometry::Rotation3& source_from_camera,
              const camera::Camera& camera, const cv::Mat& source,
              cv::Mat& result, bool nearest) {
  cv::Mat x(camera.height(), camera.width(), CV_32F, cv::Scalar(-10));
  cv::Mat y = x.clone();
  for (int v = 0; v < camera.height(); ++v) {
    for (int u = 0; u < camera.width(); ++u) {
      const std::optional<camera::Pixel> ray =
          camera.Unproject({static_cast<double>(u), static_cast<double>(v)});
      if (!ray) continue;
      const camera::Pixel pixel = source_camera.Project(
          source_from_camera * geometry::Vec3{ray->x, ray->y, 1});
      x.at<float>(v, u) = static_cast<float>(pixel.x);
      y.at<float>(v, u) = static_cast<float>(pixel.y);
    }
  }
  cv::remap(source, result, x, y,
            nearest ? cv::INTER_NEAREST : cv::INTER_LINEAR,
            cv::BORDER_CONSTANT);
}

// A window of a share `side` of each side, at (at_x, at_y) in [0, 1] of the
// room that is left.
cv::Rect Window(int width, int height, double side, double at_x, double at_y) {
  const int w = std::max(1, static_cast<int>(std::lround(side * width)));
  const int h = std::max(1, static_cast<int>(std::lround(side * height)));
  return {static_cast<int>(std::lround(at_x * (width - w))),
          static_cast<int>(std::lround(at_y * (height - h))), w, h};
}

absl::StatusOr<camera::Camera> CroppedTo(const cv::Rect& window,
                                         const camera::Camera& camera) {
  return camera::Cropped(camera, window.x, window.y, window.width,
                         window.height);
}

bool IsRegistered(const camera::RgbdCalibration& calibration) {
  return calibration.depth == calibration.color &&
         calibration.color_from_depth == geometry::Rigid3{};
}

}  // namespace

absl::Status Grey(double share, base::Random& /*random*/,
                  PerturbedFrame& view) {
  std::vector<uint8_t>& rgb = view.frame.color.rgb;
  for (size_t i = 0; i + 2 < rgb.size(); i += 3) {
    const double luma =
        0.299 * rgb[i] + 0.587 * rgb[i + 1] + 0.114 * rgb[i + 2];
    for (size_t c = 0; c < 3; ++c) {
      rgb[i + c] = ToByte((1 - share) * rgb[i + c] + share * luma);
    }
  }
  return absl::OkStatus();
}

absl::Status WhiteBalance(double by, base::Random& /*random*/,
                          PerturbedFrame& view) {
  view.frame = training::Relit(view.frame, {.gain = {1 + by, 1, 1 - by}});
  return absl::OkStatus();
}

absl::Status Gamma(double gamma, base::Random& /*random*/,
                   PerturbedFrame& view) {
  view.frame = training::Relit(view.frame, {.gamma = gamma});
  return absl::OkStatus();
}

absl::Status Exposure(double factor, base::Random& /*random*/,
                      PerturbedFrame& view) {
  view.frame = training::Relit(view.frame, {.gain = {factor, factor, factor}});
  return absl::OkStatus();
}

absl::Status Light(double stops, base::Random& random, PerturbedFrame& view) {
  image::ColorImage& image = view.frame.color;
  const double angle_rad = random.NextUniform(0, 2 * std::numbers::pi);
  // Along the direction, from -1 to 1 between the picture's farthest corners.
  const double dx = std::cos(angle_rad);
  const double dy = std::sin(angle_rad);
  const double reach =
      0.5 * (std::abs(dx) * image.width + std::abs(dy) * image.height);
  const std::array<double, 3> exponent{stops * (1 + kWarmth), stops,
                                       stops * (1 - kWarmth)};
  size_t i = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double along = (dx * (x - 0.5 * (image.width - 1)) +
                            dy * (y - 0.5 * (image.height - 1))) /
                           reach;
      for (size_t c = 0; c < 3; ++c, ++i) {
        image.rgb[i] = ToByte(image.rgb[i] * std::exp2(exponent[c] * along));
      }
    }
  }
  return absl::OkStatus();
}

absl::Status MotionBlur(double length_px, base::Random& random,
                        PerturbedFrame& view) {
  const double angle_rad = random.NextUniform(0, std::numbers::pi);
  const int size = 2 * static_cast<int>(std::ceil(length_px / 2)) + 1;
  cv::Mat kernel(size, size, CV_32F, cv::Scalar(0));
  // Moments of the exposure, each at a place between pixels.
  const int moments = 8 * size;
  for (int k = 0; k < moments; ++k) {
    const double at_px = length_px * ((k + 0.5) / moments - 0.5);
    const double x = size / 2 + at_px * std::cos(angle_rad);
    const double y = size / 2 + at_px * std::sin(angle_rad);
    const int left = static_cast<int>(std::floor(x));
    const int top = static_cast<int>(std::floor(y));
    for (const int v : {top, top + 1}) {
      for (const int u : {left, left + 1}) {
        if (u < 0 || v < 0 || u >= size || v >= size) continue;
        kernel.at<float>(v, u) +=
            static_cast<float>((1 - std::abs(x - u)) * (1 - std::abs(y - v)));
      }
    }
  }
  kernel /= cv::sum(kernel)[0];
  cv::Mat result;
  cv::filter2D(MatOf(view.frame.color), result, -1, kernel, {-1, -1}, 0,
               cv::BORDER_REPLICATE);
  Set(result, view.frame.color);
  return absl::OkStatus();
}

absl::Status Defocus(double sigma_px, base::Random& /*random*/,
                     PerturbedFrame& view) {
  cv::Mat result;
  cv::GaussianBlur(MatOf(view.frame.color), result, {}, sigma_px, sigma_px,
                   cv::BORDER_REPLICATE);
  Set(result, view.frame.color);
  return absl::OkStatus();
}

absl::Status Noise(double sigma, base::Random& random, PerturbedFrame& view) {
  for (uint8_t& value : view.frame.color.rgb) {
    value = ToByte(value + sigma * random.NextGaussian());
  }
  return absl::OkStatus();
}

absl::Status Jpeg(double quality, base::Random& /*random*/,
                  PerturbedFrame& view) {
  TL_ASSIGN_OR_RETURN(
      const std::string jpeg,
      image::EncodeJpeg(view.frame.color, static_cast<int>(quality)));
  TL_ASSIGN_OR_RETURN(view.frame.color, image::DecodeColor(jpeg));
  return absl::OkStatus();
}

absl::Status Cover(double share, base::Random& random, PerturbedFrame& view) {
  const double side = std::sqrt(share);
  const double at_x = random.NextUnit();
  const double at_y = random.NextUnit();
  cv::Scalar color;
  for (int c = 0; c < 3; ++c) color[c] = random.NextUniform(20, 235);
  const double away_m = random.NextUniform(kNearest_m, kFarthest_m);
  const bool measured = random.NextUnit() < 0.5;
  image::ColorImage& picture = view.frame.color;
  MatOf(picture)(Window(picture.width, picture.height, side, at_x, at_y)) =
      color;
  if (!view.frame.depth) return absl::OkStatus();
  image::DepthImage& depth = *view.frame.depth;
  MatOf(depth)(Window(depth.width, depth.height, side, at_x, at_y)) =
      cv::Scalar(measured ? std::round(away_m / depth.unit_m) : 0);
  return absl::OkStatus();
}

absl::Status Crop(double side, base::Random& random, PerturbedFrame& view) {
  const double at_x = random.NextUnit();
  const double at_y = random.NextUnit();
  camera::RgbdCalibration& calibration = *view.frame.calibration;
  const cv::Rect color_window =
      Window(view.frame.color.width, view.frame.color.height, side, at_x, at_y);
  // Depth that is not there has a camera all the same.
  const cv::Rect depth_window = Window(
      calibration.depth.width(), calibration.depth.height(), side, at_x, at_y);
  ChangePictures(
      view.frame, [&](const cv::Mat& source, cv::Mat& result, bool nearest) {
        result = source(nearest ? depth_window : color_window).clone();
      });
  TL_ASSIGN_OR_RETURN(calibration.color,
                      CroppedTo(color_window, calibration.color));
  TL_ASSIGN_OR_RETURN(calibration.depth,
                      CroppedTo(depth_window, calibration.depth));
  return absl::OkStatus();
}

absl::Status Scale(double factor, base::Random& /*random*/,
                   PerturbedFrame& view) {
  camera::RgbdCalibration& calibration = *view.frame.calibration;
  TL_ASSIGN_OR_RETURN(calibration.color,
                      camera::Resized(calibration.color, factor));
  TL_ASSIGN_OR_RETURN(calibration.depth,
                      camera::Resized(calibration.depth, factor));
  ChangePictures(
      view.frame, [&](const cv::Mat& source, cv::Mat& result, bool nearest) {
        const auto smooth = factor < 1 ? cv::INTER_AREA : cv::INTER_LINEAR;
        // A size that is not rounded keeps the factor exact.
        cv::resize(source, result, {}, factor, factor,
                   nearest ? cv::INTER_NEAREST_EXACT : smooth);
      });
  return absl::OkStatus();
}

absl::Status Distort(double k, base::Random& /*random*/, PerturbedFrame& view) {
  camera::Camera& color = view.frame.calibration->color;
  const auto corner = color.Unproject({-0.5, -0.5});
  const double r2 = corner ? corner->x * corner->x + corner->y * corner->y : 0;
  const double at_corner = 1 + k * r2;
  // Beyond it the image would fold.
  if (!corner || !(at_corner > 0) || !(1 + 3 * k * r2 > 0)) {
    return absl::InvalidArgumentError(
        "so strong a distortion folds the corners of this picture");
  }
  const std::array<double, 8> parameters{color.fx() / at_corner,
                                         color.fy() / at_corner,
                                         color.cx(),
                                         color.cy(),
                                         k,
                                         0,
                                         0,
                                         0};
  TL_ASSIGN_OR_RETURN(
      const camera::Camera distorted,
      camera::Camera::Create(camera::CameraModel::kOpenCv, color.width(),
                             color.height(), parameters.data(),
                             static_cast<int>(parameters.size())));
  cv::Mat result;
  Resample(color, {}, distorted, MatOf(view.frame.color), result,
           /*nearest=*/false);
  Set(result, view.frame.color);
  color = distorted;
  return absl::OkStatus();
}

absl::Status WrongFocalLength(double factor, base::Random& /*random*/,
                              PerturbedFrame& view) {
  camera::RgbdCalibration& calibration = *view.frame.calibration;
  const bool registered = IsRegistered(calibration);
  TL_ASSIGN_OR_RETURN(calibration.color,
                      camera::WithFocalScaled(calibration.color, factor));
  if (registered) calibration.depth = calibration.color;
  return absl::OkStatus();
}

absl::Status AssumedLens(double factor, base::Random& random,
                         PerturbedFrame& view) {
  view.frame.is_camera_assumed = true;
  return GuessedLens(factor, random, view);
}

absl::Status GuessedLens(double factor, base::Random& /*random*/,
                         PerturbedFrame& view) {
  camera::RgbdCalibration& calibration = *view.frame.calibration;
  const bool registered = IsRegistered(calibration);
  const camera::Camera& color = calibration.color;
  const std::array<double, 3> parameters = {factor * MeanFocal_px(color),
                                            0.5 * (color.width() - 1),
                                            0.5 * (color.height() - 1)};
  TL_ASSIGN_OR_RETURN(
      calibration.color,
      camera::Camera::Create(camera::CameraModel::kSimplePinhole, color.width(),
                             color.height(), parameters.data(),
                             parameters.size()));
  if (registered) calibration.depth = calibration.color;
  return absl::OkStatus();
}

absl::Status Rotate(double degrees, base::Random& /*random*/,
                    PerturbedFrame& view) {
  const auto turn = static_cast<image::QuarterTurn>(
      static_cast<int>(std::lround(degrees / 90)) & 3);
  if (turn == image::QuarterTurn::kNone) return absl::OkStatus();
  const image::Orientation said = view.frame.orientation;
  view.frame = image::Turned(view.frame, turn);
  view.frame.orientation = said;  // nobody tells the localizer
  view.turned_from_sensor =
      geometry::Rigid3{image::TurnedFromCamera(turn), {}} *
      view.turned_from_sensor;
  return absl::OkStatus();
}

absl::Status Roll(double degrees, base::Random& /*random*/,
                  PerturbedFrame& view) {
  const geometry::Rigid3 turned_from_camera{
      geometry::Rotation3::FromAxisAngle({0, 0, degrees * kRadiansPerDegree}),
      {}};
  const camera::RgbdCalibration& calibration = *view.frame.calibration;
  ChangePictures(view.frame,
                 [&](const cv::Mat& source, cv::Mat& result, bool nearest) {
                   const camera::Camera& camera =
                       nearest ? calibration.depth : calibration.color;
                   Resample(camera, turned_from_camera.rotation.Inverse(),
                            camera, source, result, nearest);
                 });
  TurnCameras(turned_from_camera, view);
  return absl::OkStatus();
}

absl::Status Mirror(double /*unused*/, base::Random& /*random*/,
                    PerturbedFrame& view) {
  ChangePictures(view.frame, [](const cv::Mat& source, cv::Mat& result, bool) {
    cv::flip(source, result, 1);
  });
  camera::RgbdCalibration& calibration = *view.frame.calibration;
  calibration.color = camera::Mirrored(calibration.color);
  calibration.depth = camera::Mirrored(calibration.depth);
  // Seen in the mirror: rotations about y and z turn the other way.
  geometry::Rigid3& color_from_depth = calibration.color_from_depth;
  color_from_depth.rotation.y *= -1;
  color_from_depth.rotation.z *= -1;
  color_from_depth.translation.x *= -1;
  return absl::OkStatus();
}

absl::Status DepthHoles(double share, base::Random& random,
                        PerturbedFrame& view) {
  if (!view.frame.depth) return absl::OkStatus();
  image::DepthImage& depth = *view.frame.depth;
  const cv::Mat pixels = MatOf(depth);
  const cv::Rect all(0, 0, depth.width, depth.height);
  for (int y = 0; y < depth.height; y += kHole_px) {
    for (int x = 0; x < depth.width; x += kHole_px) {
      if (random.NextUnit() >= share) continue;
      pixels(cv::Rect(x, y, kHole_px, kHole_px) & all) = cv::Scalar(0);
    }
  }
  return absl::OkStatus();
}

absl::Status DepthNoise(double sigma, base::Random& random,
                        PerturbedFrame& view) {
  const double unit_m = view.frame.depth ? view.frame.depth->unit_m : 1;
  MapDepth(view.frame, [&](double value) {
    const double depth_m = value * unit_m;
    return value + sigma * depth_m * depth_m * random.NextGaussian() / unit_m;
  });
  return absl::OkStatus();
}

absl::Status DepthScaled(double factor, base::Random& /*random*/,
                         PerturbedFrame& view) {
  MapDepth(view.frame, [&](double value) { return factor * value; });
  return absl::OkStatus();
}

absl::Status DepthOffset(double offset_m, base::Random& /*random*/,
                         PerturbedFrame& view) {
  if (!view.frame.depth) return absl::OkStatus();
  const double units = offset_m / view.frame.depth->unit_m;
  MapDepth(view.frame, [&](double value) { return value + units; });
  return absl::OkStatus();
}

absl::Status NoDepth(double /*unused*/, base::Random& /*random*/,
                     PerturbedFrame& view) {
  view.frame.depth.reset();
  return absl::OkStatus();
}

}  // namespace treeline::accuracy
