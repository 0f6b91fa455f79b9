#include "evaluation/accuracy/scene_coordinate_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "absl/strings/str_format.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "common/image/depth_registration.h"

namespace treeline::accuracy {
namespace {

constexpr int kJpegQuality = 82;
// A heat map's cells (px).
constexpr int kCell_px = 6;

struct PixelError {
  camera::Pixel color_pixel;
  double error_m = 0;
};

// Asks for correspondences and knows where their pixels truly are.
class TruthChecker {
 public:
  TruthChecker(const localizer::Localizer& localizer,
               const dataset::Dataset& dataset,
               const EvaluationOptions& options)
      : localizer_(localizer),
        dataset_(dataset),
        options_(options),
        calibration_(
            options.calibration.value_or(localizer.info().calibration)),
        registration_(calibration_) {}

  bool CanCheck(int i) const {
    return dataset_.frame(i).world_from_camera.has_value() &&
           !dataset_.frame(i).depth_path.empty();
  }

  absl::StatusOr<std::vector<PixelError>> Check(const image::Frame& frame,
                                                int i) const {
    const geometry::Rigid3 world_from_color =
        camera::PoseOfSensor(*dataset_.frame(i).world_from_camera,
                             dataset_.calibration().pose_sensor,
                             camera::RgbdSensor::kColor, calibration_);
    image::Frame query = frame;
    if (options_.calibration) query.calibration = options_.calibration;
    localizer::LocalizeOptions asked = options_.Query();
    asked.keep_correspondences = true;
    TL_ASSIGN_OR_RETURN(const localizer::PoseEstimate estimate,
                        localizer_.Localize(query, asked));
    const std::vector<geometry::Vec3> points =
        registration_.PointsInColor(*frame.depth);
    std::vector<PixelError> errors;
    for (const localizer::Correspondence& c : estimate.correspondences) {
      const std::optional<geometry::Vec3> point =
          registration_.PointAt(points, c.color_pixel);
      if (!point) continue;
      errors.push_back(
          {c.color_pixel,
           geometry::Norm(world_from_color * *point - c.point_in_world)});
    }
    return errors;
  }

 private:
  const localizer::Localizer& localizer_;
  const dataset::Dataset& dataset_;
  const EvaluationOptions& options_;
  const camera::RgbdCalibration calibration_;
  const image::DepthRegistrar registration_;
};

std::array<double, 3> HeatRgb(double fraction) {
  // Green, yellow, red, dark: light to dark beyond the middle, so that it also
  // reads without colour.
  constexpr std::array<std::array<double, 3>, 4> kStops{
      {{31, 150, 110}, {245, 208, 80}, {214, 64, 40}, {70, 8, 30}}};
  const double at = std::clamp(fraction, 0.0, 1.0) * (kStops.size() - 1);
  const size_t below = std::min(static_cast<size_t>(at), kStops.size() - 2);
  const double rest = at - static_cast<double>(below);
  std::array<double, 3> rgb{};
  for (size_t c = 0; c < 3; ++c) {
    rgb[c] =
        kStops[below][c] + rest * (kStops[below + 1][c] - kStops[below][c]);
  }
  return rgb;
}

// Mean errors by cell, row by row; negative: no prediction there.
class CellMeans {
 public:
  CellMeans(int width, int height)
      : columns_(width / kCell_px + 1),
        sums_(static_cast<size_t>(columns_) *
              static_cast<size_t>(height / kCell_px + 1)),
        counts_(sums_.size()) {}

  void Add(const PixelError& error) {
    const size_t cell = At(static_cast<int>(error.color_pixel.x),
                           static_cast<int>(error.color_pixel.y));
    // Truncated, as in the thesis: one wild guess does not colour a cell.
    sums_[cell] += std::min(error.error_m, kHeatMapMax_m);
    ++counts_[cell];
  }
  double Mean(int x, int y) const {
    const size_t cell = At(x, y);
    return counts_[cell] == 0 ? -1 : sums_[cell] / counts_[cell];
  }

 private:
  size_t At(int x, int y) const {
    return static_cast<size_t>(y / kCell_px * columns_ + x / kCell_px);
  }

  int columns_;
  std::vector<double> sums_;
  std::vector<int> counts_;
};

image::ColorImage Coloured(const image::ColorImage& photo,
                           const CellMeans& means) {
  image::ColorImage image = photo;
  for (int y = 0; y < photo.height; ++y) {
    for (int x = 0; x < photo.width; ++x) {
      uint8_t* rgb = &image.rgb[static_cast<size_t>(3 * (y * photo.width + x))];
      const double grey = 0.3 * rgb[0] + 0.59 * rgb[1] + 0.11 * rgb[2];
      const double mean_m = means.Mean(x, y);
      const std::array<double, 3> heat = HeatRgb(mean_m / kHeatMapMax_m);
      for (size_t c = 0; c < 3; ++c) {
        const double value =
            mean_m < 0 ? 0.45 * grey : 0.35 * grey + 0.65 * heat[c];
        rgb[c] = static_cast<uint8_t>(std::clamp(value, 0.0, 255.0));
      }
    }
  }
  return image;
}

}  // namespace

absl::StatusOr<std::vector<double>> SceneCoordinateErrors(
    const localizer::Localizer& localizer, const dataset::Dataset& dataset,
    int max_frames, const EvaluationOptions& options) {
  const TruthChecker checker(localizer, dataset, options);
  std::vector<int> usable;
  for (int i = 0; i < dataset.size(); ++i) {
    if (checker.CanCheck(i)) usable.push_back(i);
  }
  const auto count = std::min<size_t>(
      usable.size(), static_cast<size_t>(std::max(max_frames, 0)));
  std::vector<double> errors_m;
  base::Progress progress("scene coordinates",
                          std::max<int64_t>(static_cast<int64_t>(count), 1),
                          options.quiet || count == 0);
  for (size_t k = 0; k < count; ++k) {
    if (options.stop.stop_requested()) {
      return absl::CancelledError("evaluation was interrupted");
    }
    const int i = usable[k * usable.size() / count];
    progress.Add(1);
    const absl::StatusOr<image::Frame> frame = dataset.Load(i);
    if (!frame.ok() || !frame->depth) continue;
    const auto errors = checker.Check(*frame, i);
    if (!errors.ok()) continue;
    for (const PixelError& error : *errors) errors_m.push_back(error.error_m);
  }
  std::ranges::sort(errors_m);
  return errors_m;
}

std::string HeatColor(double fraction) {
  const std::array<double, 3> rgb = HeatRgb(fraction);
  return absl::StrFormat("#%02x%02x%02x", static_cast<int>(rgb[0]),
                         static_cast<int>(rgb[1]), static_cast<int>(rgb[2]));
}

std::vector<ErrorHeatMap> TakeHeatMaps(const localizer::Localizer& dense,
                                       const dataset::Dataset& dataset,
                                       const std::vector<int>& frames,
                                       const EvaluationOptions& options) {
  const TruthChecker checker(dense, dataset, options);
  std::vector<ErrorHeatMap> maps;
  for (int i : frames) {
    if (options.stop.stop_requested() || !checker.CanCheck(i)) continue;
    const absl::StatusOr<image::Frame> frame = dataset.Load(i);
    if (!frame.ok() || !frame->depth) continue;
    const auto errors = checker.Check(*frame, i);
    if (!errors.ok() || errors->empty()) continue;
    const image::ColorImage& photo = frame->color;
    CellMeans means(photo.width, photo.height);
    std::vector<double> errors_m;
    for (const PixelError& error : *errors) {
      means.Add(error);
      errors_m.push_back(error.error_m);
    }
    const auto photo_jpeg = image::EncodeJpeg(photo, kJpegQuality);
    const auto map_jpeg =
        image::EncodeJpeg(Coloured(photo, means), kJpegQuality);
    if (!photo_jpeg.ok() || !map_jpeg.ok()) continue;
    maps.push_back({.stem = dataset.frame(i).stem,
                    .width = photo.width,
                    .height = photo.height,
                    .photo_jpeg = *photo_jpeg,
                    .map_jpeg = *map_jpeg,
                    .predictions = static_cast<int>(errors->size()),
                    .median_error_m = *Percentile(std::move(errors_m), 50)});
  }
  return maps;
}

}  // namespace treeline::accuracy
