#include "nav_agent/rgbd_slam/binary_features.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/check_range.h"
#include "common/base/status_macros.h"
#include "common/image/depth_registration.h"

namespace treeline::rgbd_slam {
namespace {

constexpr double kCell_px = 20;
// ORB looks this far about a corner, on the corner's own level.
constexpr int kBorder_px = 19;
constexpr int kAngleRadius_px = 15;
constexpr int kDetectionCell_px = 40;

// A corner on its level.
struct Corner {
  int x = 0;
  int y = 0;
  int octave = 0;
  float response = 0;
};

// The direction from a corner to the centroid of brightness about it
// (Rosin 1999).
double CentroidAngle_rad(const cv::Mat& level, int x, int y) {
  int moment_x = 0;
  int moment_y = 0;
  for (int dy = -kAngleRadius_px; dy <= kAngleRadius_px; ++dy) {
    const auto half = static_cast<int>(
        std::sqrt(kAngleRadius_px * kAngleRadius_px - dy * dy));
    const uint8_t* row = level.ptr<uint8_t>(y + dy) + x;
    int sum = 0;
    for (int dx = -half; dx <= half; ++dx) {
      const int value = row[dx];
      sum += value;
      moment_x += dx * value;
    }
    moment_y += dy * sum;
  }
  return std::atan2(moment_y, moment_x);
}

std::vector<Corner> FindCorners(const std::vector<cv::Mat>& pyramid,
                                int contrast) {
  std::vector<Corner> corners;
  std::vector<cv::KeyPoint> found;
  for (size_t octave = 0; octave < pyramid.size(); ++octave) {
    const cv::Mat& level = pyramid[octave];
    if (level.cols <= 2 * kBorder_px || level.rows <= 2 * kBorder_px) break;
    const cv::Rect inside(kBorder_px, kBorder_px, level.cols - 2 * kBorder_px,
                          level.rows - 2 * kBorder_px);
    cv::FAST(level(inside), found, contrast, true);
    for (const cv::KeyPoint& point : found) {
      corners.push_back({.x = static_cast<int>(point.pt.x) + kBorder_px,
                         .y = static_cast<int>(point.pt.y) + kBorder_px,
                         .octave = static_cast<int>(octave),
                         .response = point.response});
    }
  }
  return corners;
}

// At most `count`, from all cells of the picture alike: first the strongest of
// every cell, then the second of every cell, and so on.
std::vector<Corner> Spread(std::vector<Corner> corners, int width, int count) {
  const int columns = width / kDetectionCell_px + 1;
  const auto cell_of = [columns](const Corner& corner) {
    const double scale = OctaveScale(corner.octave) / kDetectionCell_px;
    return static_cast<int>(scale * corner.y) * columns +
           static_cast<int>(scale * corner.x);
  };
  struct Ranked {
    Corner corner;
    int cell = 0;
    int rank = 0;
  };
  std::vector<Ranked> ranked;
  ranked.reserve(corners.size());
  for (const Corner& corner : corners) {
    ranked.push_back({corner, cell_of(corner), 0});
  }
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const Ranked& a, const Ranked& b) {
                     if (a.cell != b.cell) return a.cell < b.cell;
                     return a.corner.response > b.corner.response;
                   });
  for (size_t i = 1; i < ranked.size(); ++i) {
    if (ranked[i].cell == ranked[i - 1].cell) {
      ranked[i].rank = ranked[i - 1].rank + 1;
    }
  }
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const Ranked& a, const Ranked& b) {
                     if (a.rank != b.rank) return a.rank < b.rank;
                     return a.corner.response > b.corner.response;
                   });
  corners.clear();
  for (const Ranked& entry : ranked) {
    if (static_cast<int>(corners.size()) == count) break;
    corners.push_back(entry.corner);
  }
  return corners;
}

// Whether a picture has a camera's size, and as many values as it should.
bool Fits(const image::ColorImage& image, const camera::Camera& camera) {
  return image.width == camera.width() && image.height == camera.height() &&
         image.rgb.size() == 3 * static_cast<size_t>(image.width) *
                                 static_cast<size_t>(image.height);
}
bool Fits(const image::DepthImage& image, const camera::Camera& camera) {
  return image.width == camera.width() && image.height == camera.height() &&
         image.values.size() == static_cast<size_t>(image.width) *
                                    static_cast<size_t>(image.height);
}

std::vector<cv::Mat> MakePyramid(const image::ColorImage& color) {
  const cv::Mat rgb(color.height, color.width, CV_8UC3,
                    const_cast<uint8_t*>(color.rgb.data()));
  std::vector<cv::Mat> pyramid(1);
  cv::cvtColor(rgb, pyramid[0], cv::COLOR_RGB2GRAY);
  for (int octave = 1; octave < kPyramidLevels; ++octave) {
    const double scale = 1 / OctaveScale(octave);
    const cv::Size size(cvRound(color.width * scale),
                        cvRound(color.height * scale));
    cv::Mat smaller;
    cv::resize(pyramid.back(), smaller, size, 0, 0, cv::INTER_LINEAR);
    pyramid.push_back(std::move(smaller));
  }
  return pyramid;
}

std::vector<cv::KeyPoint> ToKeypoints(const std::vector<Corner>& corners,
                                      const std::vector<cv::Mat>& pyramid) {
  std::vector<cv::KeyPoint> keypoints;
  for (const Corner& corner : corners) {
    const auto scale = static_cast<float>(OctaveScale(corner.octave));
    const double angle_rad = CentroidAngle_rad(
        pyramid[static_cast<size_t>(corner.octave)], corner.x, corner.y);
    keypoints.emplace_back(
        scale * static_cast<float>(corner.x),
        scale * static_cast<float>(corner.y), 31 * scale,
        static_cast<float>(angle_rad * 180 / std::numbers::pi), corner.response,
        corner.octave);
    if (keypoints.back().angle < 0) keypoints.back().angle += 360;
  }
  return keypoints;
}

// Depth that is registered already: the nearest measured within 1 px, unless
// it jumps there.
double RegisteredDepth_m(const image::DepthImage& depth, camera::Pixel pixel) {
  const int x0 = static_cast<int>(std::lround(pixel.x));
  const int y0 = static_cast<int>(std::lround(pixel.y));
  int nearest = 65535;
  int furthest = 0;
  int best = 0;
  int best_distance = 9;
  for (int y = std::max(0, y0 - 1); y <= std::min(depth.height - 1, y0 + 1);
       ++y) {
    for (int x = std::max(0, x0 - 1); x <= std::min(depth.width - 1, x0 + 1);
         ++x) {
      const uint16_t value = depth.values[static_cast<size_t>(y) *
                                              static_cast<size_t>(depth.width) +
                                          static_cast<size_t>(x)];
      if (!image::IsMeasured(value)) continue;
      nearest = std::min<int>(nearest, value);
      furthest = std::max<int>(furthest, value);
      const int distance = std::abs(x - x0) + std::abs(y - y0);
      if (distance < best_distance) {
        best_distance = distance;
        best = value;
      }
    }
  }
  constexpr double kMaxJump = 1.05;
  if (furthest > kMaxJump * nearest) return 0;
  return best * depth.unit_m;
}

}  // namespace

int HammingDistance(const BinaryDescriptor& a, const BinaryDescriptor& b) {
  return std::popcount(a[0] ^ b[0]) + std::popcount(a[1] ^ b[1]) +
         std::popcount(a[2] ^ b[2]) + std::popcount(a[3] ^ b[3]);
}

double OctaveScale(int octave) {
  static const std::array<double, kPyramidLevels> kScales = [] {
    std::array<double, kPyramidLevels> scales{};
    double scale = 1;
    for (double& entry : scales) {
      entry = scale;
      scale *= kPyramidScale;
    }
    return scales;
  }();
  return kScales[static_cast<size_t>(
      std::clamp(octave, 0, kPyramidLevels - 1))];
}

FeatureSet::FeatureSet(int width, int height,
                       std::vector<ImageFeature> features)
    : width_(width),
      height_(height),
      columns_(static_cast<int>(width / kCell_px) + 1),
      rows_(static_cast<int>(height / kCell_px) + 1),
      features_(std::move(features)) {
  begin_.assign(static_cast<size_t>(columns_ * rows_) + 1, 0);
  const auto cell_of = [this](const ImageFeature& feature) {
    return static_cast<size_t>(Row(feature.pixel.y) * columns_ +
                               Column(feature.pixel.x));
  };
  for (const ImageFeature& feature : features_) ++begin_[cell_of(feature) + 1];
  for (size_t c = 1; c < begin_.size(); ++c) begin_[c] += begin_[c - 1];
  order_.resize(features_.size());
  std::vector<int> next(begin_.begin(), begin_.end() - 1);
  for (size_t i = 0; i < features_.size(); ++i) {
    order_[static_cast<size_t>(next[cell_of(features_[i])]++)] =
        static_cast<int>(i);
  }
}

int FeatureSet::Column(double x) const {
  return std::clamp(static_cast<int>(std::floor(x / kCell_px)), 0,
                    columns_ - 1);
}

int FeatureSet::Row(double y) const {
  return std::clamp(static_cast<int>(std::floor(y / kCell_px)), 0, rows_ - 1);
}

bool FeatureSet::Contains(camera::Pixel pixel) const {
  return pixel.x > -0.5 && pixel.x < width_ - 0.5 && pixel.y > -0.5 &&
         pixel.y < height_ - 0.5;
}

void FeatureSet::Near(camera::Pixel pixel, double radius_px,
                      std::vector<int>* found) const {
  found->clear();
  const int last_column = Column(pixel.x + radius_px);
  const int last_row = Row(pixel.y + radius_px);
  for (int row = Row(pixel.y - radius_px); row <= last_row; ++row) {
    for (int column = Column(pixel.x - radius_px); column <= last_column;
         ++column) {
      const auto cell = static_cast<size_t>(row * columns_ + column);
      for (int k = begin_[cell]; k < begin_[cell + 1]; ++k) {
        const int i = order_[static_cast<size_t>(k)];
        const camera::Pixel at = features_[static_cast<size_t>(i)].pixel;
        if (std::abs(at.x - pixel.x) <= radius_px &&
            std::abs(at.y - pixel.y) <= radius_px) {
          found->push_back(i);
        }
      }
    }
  }
}

absl::Status FeatureOptions::Validate() const {
  TL_RETURN_IF_ERROR(base::CheckRange("features.count", count, 50, 5000));
  TL_RETURN_IF_ERROR(base::CheckRange("features.contrast", contrast, 1, 100));
  return base::CheckRange("features.max_depth_m", max_depth_m, 0.5, 50);
}

struct FeatureExtractor::Detector {
  Detector(const camera::RgbdCalibration& calibration,
           const FeatureOptions& options)
      : orb(cv::ORB::create(options.count, static_cast<float>(kPyramidScale),
                            kPyramidLevels, kBorder_px)),
        registration(calibration) {}

  cv::Ptr<cv::ORB> orb;
  image::DepthRegistrar registration;
};

FeatureExtractor::FeatureExtractor(const camera::RgbdCalibration& calibration,
                                   const FeatureOptions& options)
    : calibration_(calibration),
      options_(options),
      pinhole_{calibration.color.fx(), calibration.color.fy(),
               calibration.color.cx(), calibration.color.cy()},
      is_registered_(calibration.color == calibration.depth &&
                     calibration.color_from_depth == geometry::Rigid3()),
      detector_(std::make_unique<Detector>(calibration, options)) {}

FeatureExtractor::~FeatureExtractor() = default;

absl::StatusOr<FeatureSet> FeatureExtractor::Extract(
    const image::Frame& frame) {
  const camera::Camera& camera = calibration_.color;
  const image::ColorImage& color = frame.color;
  const bool has_depth = frame.depth && Fits(*frame.depth, calibration_.depth);
  if (!Fits(color, camera) || !has_depth) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a frame of ", color.width, " x ", color.height,
        frame.depth ? "" : " without depth", "; the calibration is for ",
        camera.width(), " x ", camera.height(), " with depth"));
  }
  const std::vector<cv::Mat> pyramid = MakePyramid(color);
  std::vector<cv::KeyPoint> keypoints =
      ToKeypoints(Spread(FindCorners(pyramid, options_.contrast), color.width,
                         options_.count),
                  pyramid);
  cv::Mat descriptors;
  detector_->orb->compute(pyramid[0], keypoints, descriptors);

  std::vector<geometry::Vec3> points;
  if (!is_registered_) {
    points = detector_->registration.PointsInColor(*frame.depth);
  }
  std::vector<ImageFeature> features;
  features.reserve(keypoints.size());
  for (size_t i = 0; i < keypoints.size(); ++i) {
    // ORB counts in pixels of the level; a level's pixel (0, 0) covers more
    // than the picture's, and its centre is not the centre of that one.
    const double shift_px = 0.5 * OctaveScale(keypoints[i].octave) - 0.5;
    const camera::Pixel seen{keypoints[i].pt.x + shift_px,
                             keypoints[i].pt.y + shift_px};
    ImageFeature feature{
        .pixel = seen,
        .octave = keypoints[i].octave,
        .angle_rad = keypoints[i].angle * std::numbers::pi / 180};
    if (camera.has_distortion()) {
      const std::optional<camera::Pixel> ray = camera.Unproject(seen);
      if (!ray) continue;
      feature.pixel = {pinhole_.fx * ray->x + pinhole_.cx,
                       pinhole_.fy * ray->y + pinhole_.cy};
    }
    if (is_registered_) {
      feature.depth_m =
          calibration_.depth_scale * RegisteredDepth_m(*frame.depth, seen);
    } else if (const auto point =
                   detector_->registration.PointAt(points, seen)) {
      feature.depth_m = point->z;
    }
    if (feature.depth_m > options_.max_depth_m) feature.depth_m = 0;
    std::memcpy(feature.descriptor.data(),
                descriptors.ptr<uint8_t>(static_cast<int>(i)),
                sizeof(feature.descriptor));
    features.push_back(feature);
  }
  return FeatureSet(color.width, color.height, std::move(features));
}

}  // namespace treeline::rgbd_slam
