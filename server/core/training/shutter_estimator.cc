#include "server/core/training/shutter_estimator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "Eigen/Cholesky"
#include "Eigen/Core"
#include "common/base/parallel_for.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "common/image/depth_registration.h"
#include "server/core/features/sift_matching.h"
#include "server/core/keyframes/keyframe_features.h"

namespace treeline::training {
namespace {

enum Unknown : int {
  kOffset,
  kReadout,
  kRotationX,
  kRotationY,
  kRotationZ,
  kFocal,
  kUnknowns
};
using Values = std::array<double, kUnknowns>;
using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Vector = Eigen::Matrix<double, kUnknowns, 1>;

// Of numerical differentiation (s, s, rad, rad, rad, 1).
constexpr Values kStep = {1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4};
// What is expected beforehand: it decides where nothing moves.
constexpr Values kPriorSigma = {0.03, 0.05, 0.05, 0.05, 0.05, 0.05};
constexpr int kIterations = 10;
// The robust scale is that many median distances, and no less than pixels.
constexpr double kScaleMedians = 3;
constexpr double kMinScale_px = 2;
// Further away is no match.
constexpr double kMaxDistance_px = 40;
constexpr size_t kMinPoints = 300;

// What counts as a rolling shutter: at least so long, so many standard
// deviations from 0, and so much nearer.
constexpr double kMinReadout_s = 0.004;
constexpr double kMaxSureReadout_s = 0.1;
constexpr double kMinSigmas = 8;
constexpr double kMinGain = 0.02;
// Rotations below are as exact as poses are (rad/s, root mean square).
constexpr double kMinTurnRate_rad_s = 0.1;

// Of a recording: frames, evenly spread; each is compared with those of the
// others that turned most differently, if they looked about the same way.
constexpr int kMaxFrames = 60;
constexpr int kFeatures = 700;
constexpr size_t kPartners = 10;
constexpr double kMaxViewAngle_rad = 0.45;
constexpr double kMaxRatio = 0.8;
// Of a pair, the surest.
constexpr size_t kMaxPairMatches = 40;

struct Distance {
  double x = 0;
  double y = 0;
  double norm() const { return std::hypot(x, y); }
};

Distance DistanceOf(const MovingView& from, const MovingView& to,
                    const SharedPoint& point, const Values& p) {
  using geometry::Rotation3;
  const Rotation3 mounted =
      Rotation3::FromAxisAngle({p[kRotationX], p[kRotationY], p[kRotationZ]});
  const double zoom = 1 + p[kFocal];
  const double s_from = p[kOffset] + p[kReadout] * point.share_in_from;
  const double s_to = p[kOffset] + p[kReadout] * point.share_in_to;
  const geometry::Vec3 seen{zoom * point.point_in_from.x,
                            zoom * point.point_in_from.y,
                            point.point_in_from.z};
  const geometry::Vec3 in_world =
      from.world_from_color *
      (Rotation3::FromAxisAngle(s_from * from.turn_rate_rad_s) *
       (mounted * seen));
  const geometry::Vec3 in_to =
      mounted.Inverse() *
      (Rotation3::FromAxisAngle(-s_to * to.turn_rate_rad_s) *
       (to.world_from_color.Inverse() * in_world));
  if (!(in_to.z > 0)) return {kMaxDistance_px, kMaxDistance_px};
  return {in_to.x / in_to.z - zoom * point.ray_in_to.x,
          in_to.y / in_to.z - zoom * point.ray_in_to.y};
}

class Fit {
 public:
  Fit(std::span<const MovingView> views, std::span<const SharedPoint> points,
      double pixel)
      : views_(views), points_(points), pixel_(pixel) {}

  std::optional<ShutterEstimate> Run() {
    Values values{};
    ShutterEstimate estimate;
    // With all rows at once, too, what is common to all views is free.
    for (const bool is_rolling : {false, true}) {
      for (int i = 0; i < kIterations; ++i) {
        if (!Step(is_rolling, values)) return std::nullopt;
      }
      (is_rolling ? estimate.median_after : estimate.median_before) =
          Median(values);
    }
    estimate.shutter = {.readout_s = values[kReadout],
                        .offset_s = values[kOffset]};
    estimate.readout_sigma_s = ReadoutSigma();
    return estimate;
  }

 private:
  Distance DistanceAt(const SharedPoint& point, const Values& values) const {
    return DistanceOf(views_[static_cast<size_t>(point.from)],
                      views_[static_cast<size_t>(point.to)], point, values);
  }

  double Median(const Values& values) const {
    std::vector<double> distances;
    for (const SharedPoint& point : points_) {
      const double distance = DistanceAt(point, values).norm();
      if (distance < kMaxDistance_px * pixel_) distances.push_back(distance);
    }
    if (distances.empty()) return kMaxDistance_px * pixel_;
    const auto middle =
        distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    return *middle;
  }

  // One Gauss-Newton step on weighted squares (Geman and McClure, 1985).
  bool Step(bool is_rolling, Values& values) {
    const double scale =
        std::max(kMinScale_px * pixel_, kScaleMedians * Median(values));
    information_.setZero();
    gradients_.assign(views_.size(), Vector::Zero());
    size_t used = 0;
    for (const SharedPoint& point : points_) {
      const Distance at = DistanceAt(point, values);
      const double distance = at.norm();
      if (distance >= kMaxDistance_px * pixel_) continue;
      ++used;
      const double shrink = 1 / (1 + distance * distance / (scale * scale));
      Eigen::Matrix<double, 2, kUnknowns> slope;
      for (int k = 0; k < kUnknowns; ++k) {
        Values moved = values;
        moved[static_cast<size_t>(k)] += kStep[static_cast<size_t>(k)];
        const Distance there = DistanceAt(point, moved);
        slope(0, k) = (there.x - at.x) / kStep[static_cast<size_t>(k)];
        slope(1, k) = (there.y - at.y) / kStep[static_cast<size_t>(k)];
      }
      if (!is_rolling) slope.leftCols<2>().setZero();
      const double weight = shrink * shrink / (scale * scale);
      information_ += weight * slope.transpose() * slope;
      gradients_[static_cast<size_t>(point.to)] +=
          weight * slope.transpose() * Eigen::Vector2d(at.x, at.y);
    }
    if (used < kMinPoints) return false;
    Vector gradient = Vector::Zero();
    for (const Vector& one : gradients_) gradient += one;
    for (int k = 0; k < kUnknowns; ++k) {
      const double sigma = kPriorSigma[static_cast<size_t>(k)];
      information_(k, k) += 1 / (sigma * sigma);
      gradient(k) += values[static_cast<size_t>(k)] / (sigma * sigma);
    }
    const Vector step = information_.ldlt().solve(gradient);
    if (!step.allFinite()) return false;
    for (int k = 0; k < kUnknowns; ++k) {
      values[static_cast<size_t>(k)] -= step(k);
    }
    return true;
  }

  // From how much what single views say differs (White 1980, by clusters).
  double ReadoutSigma() const {
    Matrix scatter = Matrix::Zero();
    for (const Vector& one : gradients_) scatter += one * one.transpose();
    const Matrix inverse = information_.ldlt().solve(Matrix::Identity());
    const Matrix covariance = inverse * (scatter + information_) * inverse;
    return std::sqrt(covariance(kReadout, kReadout));
  }

  const std::span<const MovingView> views_;
  const std::span<const SharedPoint> points_;
  const double pixel_;
  Matrix information_ = Matrix::Zero();
  // What the points seen from each view say.
  std::vector<Vector> gradients_;
};

// A frame's features, and the points that they stand on.
struct ViewFeatures {
  features::SiftFeatures sift;
  std::vector<std::optional<geometry::Vec3>> points;
  std::vector<std::optional<camera::Pixel>> rays;
};

std::vector<int> ChooseFrames(const dataset::Dataset& dataset) {
  std::vector<int> usable;
  for (int i = 0; i < dataset.size(); ++i) {
    const dataset::DatasetFrame& frame = dataset.frame(i);
    if (frame.world_from_camera && frame.motion && !frame.depth_path.empty()) {
      usable.push_back(i);
    }
  }
  const size_t count = std::min<size_t>(usable.size(), kMaxFrames);
  std::vector<int> chosen;
  for (size_t k = 0; k < count; ++k) {
    chosen.push_back(usable[k * usable.size() / count]);
  }
  return chosen;
}

ViewFeatures FeaturesOf(const image::Frame& frame,
                        const camera::RgbdCalibration& calibration,
                        const image::DepthRegistrar& registration) {
  features::FastSift fast_sift;
  ViewFeatures found;
  found.sift =
      keyframes::ExtractKeyframeSift(frame.color, features::SiftKind::kFast,
                                     {.max_features = kFeatures}, fast_sift);
  const std::vector<geometry::Vec3> in_color =
      registration.PointsInColor(*frame.depth);
  for (const features::SiftKeypoint& keypoint : found.sift.keypoints) {
    found.points.push_back(registration.PointAt(in_color, keypoint.pixel));
    found.rays.push_back(calibration.color.Unproject(keypoint.pixel));
  }
  return found;
}

void AppendShared(int from, int to, const ViewFeatures& a,
                  const ViewFeatures& b, int height,
                  std::vector<SharedPoint>& points) {
  const auto nearest = [](const ViewFeatures& queries,
                          const ViewFeatures& references) {
    std::vector<features::NearestSift> found(queries.sift.size());
    features::FindNearestSift(
        queries.sift.descriptors,
        {.data = references.sift.descriptors.front().values.data(),
         .size = references.sift.size()},
        found);
    return found;
  };
  if (a.sift.size() < 2 || b.sift.size() < 2) return;
  const std::vector<features::NearestSift> forth = nearest(a, b);
  const std::vector<features::NearestSift> back = nearest(b, a);
  std::vector<std::pair<double, size_t>> sure;
  for (size_t i = 0; i < forth.size(); ++i) {
    const double ratio =
        std::sqrt(1.0 * forth[i].squared_distance /
                  std::max(1, forth[i].second_squared_distance));
    const size_t j = forth[i].index;
    if (ratio > kMaxRatio || back[j].index != i || !a.points[i] || !b.rays[j]) {
      continue;
    }
    sure.emplace_back(ratio, i);
  }
  std::ranges::sort(sure);
  if (sure.size() > kMaxPairMatches) sure.resize(kMaxPairMatches);
  for (const auto& [ratio, i] : sure) {
    const size_t j = forth[i].index;
    points.push_back(
        {.from = from,
         .to = to,
         .point_in_from = *a.points[i],
         .ray_in_to = *b.rays[j],
         .share_in_from = image::RowShare(a.sift.keypoints[i].pixel.y, height),
         .share_in_to = image::RowShare(b.sift.keypoints[j].pixel.y, height)});
  }
}

// Those that view `i` is compared with.
std::vector<size_t> PartnersOf(size_t i, std::span<const MovingView> views) {
  const geometry::Vec3 ahead{0, 0, 1};
  std::vector<std::pair<double, size_t>> found;
  for (size_t k = 0; k < views.size(); ++k) {
    const double cosine =
        geometry::Dot(views[i].world_from_color.rotation * ahead,
                      views[k].world_from_color.rotation * ahead);
    if (k == i || cosine < std::cos(kMaxViewAngle_rad)) continue;
    found.emplace_back(
        -geometry::Norm(views[i].turn_rate_rad_s - views[k].turn_rate_rad_s),
        k);
  }
  std::ranges::sort(found);
  std::vector<size_t> partners;
  for (size_t k = 0; k < std::min(found.size(), kPartners); ++k) {
    partners.push_back(found[k].second);
  }
  return partners;
}

bool Turns(std::span<const MovingView> views) {
  double sum = 0;
  for (const MovingView& view : views) {
    sum += geometry::SquaredNorm(view.turn_rate_rad_s);
  }
  return sum > kMinTurnRate_rad_s * kMinTurnRate_rad_s *
                   static_cast<double>(views.size());
}

}  // namespace

std::optional<ShutterEstimate> EstimateShutter(
    std::span<const MovingView> views, std::span<const SharedPoint> points,
    double pixel) {
  return Fit(views, points, pixel).Run();
}

bool IsRolling(const ShutterEstimate& estimate) {
  const double readout_s = estimate.shutter.readout_s;
  return readout_s >= kMinReadout_s && readout_s <= kMaxSureReadout_s &&
         readout_s >= kMinSigmas * estimate.readout_sigma_s &&
         std::abs(estimate.shutter.offset_s) <= image::kMaxShutterOffset_s &&
         estimate.median_after <= (1 - kMinGain) * estimate.median_before;
}

absl::StatusOr<std::optional<ShutterEstimate>> FindShutter(
    const dataset::Dataset& dataset, const camera::RgbdCalibration& calibration,
    int threads, bool quiet, const std::stop_token& stop) {
  const std::vector<int> chosen = ChooseFrames(dataset);
  std::vector<MovingView> views;
  for (const int i : chosen) {
    const dataset::DatasetFrame& frame = dataset.frame(i);
    camera::RgbdCalibration posed = calibration;
    posed.pose_sensor = dataset.calibration().pose_sensor;
    views.push_back({.world_from_color = camera::PoseOfSensor(
                         *frame.world_from_camera, posed.pose_sensor,
                         camera::RgbdSensor::kColor, posed),
                     .turn_rate_rad_s = image::TurnRateOf(
                         camera::RgbdSensor::kColor, posed, *frame.motion)});
  }
  if (views.empty() || !Turns(views)) return std::nullopt;
  const image::DepthRegistrar registration(calibration);
  std::vector<ViewFeatures> features(views.size());
  std::vector<absl::Status> statuses(views.size());
  std::vector<std::vector<SharedPoint>> shared(views.size());
  base::Progress progress("shutter", static_cast<int64_t>(2 * views.size()),
                          quiet);
  const int64_t count = static_cast<int64_t>(views.size());
  base::ParallelFor(count, threads, [&](int64_t i) {
    if (stop.stop_requested()) return;
    const size_t slot = static_cast<size_t>(i);
    const absl::StatusOr<image::Frame> frame = dataset.Load(chosen[slot]);
    statuses[slot] = frame.status();
    if (frame.ok() && frame->depth) {
      features[slot] = FeaturesOf(*frame, calibration, registration);
    }
    progress.Add(1);
  });
  for (const absl::Status& status : statuses) TL_RETURN_IF_ERROR(status);
  base::ParallelFor(count, threads, [&](int64_t i) {
    if (stop.stop_requested()) return;
    const size_t slot = static_cast<size_t>(i);
    for (const size_t other : PartnersOf(slot, views)) {
      AppendShared(static_cast<int>(i), static_cast<int>(other), features[slot],
                   features[other], calibration.color.height(), shared[slot]);
    }
    progress.Add(1);
  });
  if (stop.stop_requested()) return absl::CancelledError("interrupted");
  std::vector<SharedPoint> points;
  for (const std::vector<SharedPoint>& some : shared) {
    points.insert(points.end(), some.begin(), some.end());
  }
  const std::optional<ShutterEstimate> estimate =
      EstimateShutter(views, points, 1 / calibration.color.fx());
  fprintf(stderr,
          "shutter: %.2f +- %.2f ms, offset %.2f ms, median %.3f -> %.3f px, "
          "%zu points\n",
          1e3 * estimate->shutter.readout_s, 1e3 * estimate->readout_sigma_s,
          1e3 * estimate->shutter.offset_s,
          estimate->median_before * calibration.color.fx(),
          estimate->median_after * calibration.color.fx(), points.size());
  if (!estimate || !IsRolling(*estimate)) return std::nullopt;
  return estimate;
}

}  // namespace treeline::training
