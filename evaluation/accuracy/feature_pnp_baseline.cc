#include "evaluation/accuracy/feature_pnp_baseline.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "common/image/depth_registration.h"
#include "evaluation/accuracy/evaluation.h"
#include "evaluation/yardsticks/opencv_sift.h"
#include "evaluation/yardsticks/opencv_threads.h"
#include "opencv2/calib3d.hpp"
#include "opencv2/core.hpp"
#include "opencv2/features2d.hpp"
#include "opencv2/flann.hpp"
#include "opencv2/imgproc.hpp"
#include "server/core/features/fast_sift.h"
#include "server/core/training/sift_trainer.h"
#include "server/tools/run_info.h"

namespace treeline::accuracy {
namespace {

// Descriptors within this many nearest ones may stand for other places.
constexpr int kNeighbours = 16;
constexpr int kOrbFeatures = 1000;
constexpr int kMinMatches = 6;

struct Features {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;  // one row a keypoint: 128 floats, or 32 bytes
};

Features ToOpenCv(const features::SiftFeatures& sift) {
  Features features;
  features.descriptors.create(static_cast<int>(sift.size()),
                              features::SiftDescriptor::kDimensions, CV_32F);
  for (size_t i = 0; i < sift.size(); ++i) {
    const features::SiftKeypoint& k = sift.keypoints[i];
    features.keypoints.emplace_back(static_cast<float>(k.pixel.x),
                                    static_cast<float>(k.pixel.y),
                                    k.diameter_px);
    std::ranges::copy(sift.descriptors[i].values,
                      features.descriptors.ptr<float>(static_cast<int>(i)));
  }
  return features;
}

cv::Ptr<cv::Feature2D> MakeExtractor(FeatureKind kind, int count) {
  if (kind == FeatureKind::kSift) return cv::SIFT::create(count);
  return cv::ORB::create(count == 0 ? kOrbFeatures : count);
}

Features Extract(const image::ColorImage& image,
                 const FeaturePnpOptions& options) {
  if (options.kind == FeatureKind::kFastSift) {
    features::FastSiftOptions wanted;
    if (options.features > 0) wanted.max_features = options.features;
    return ToOpenCv(features::FastSift().Extract(image, wanted));
  }
  // OpenCV reads the pixels only.
  const cv::Mat color(image.height, image.width, CV_8UC3,
                      const_cast<uint8_t*>(image.rgb.data()));
  cv::Mat gray;
  cv::cvtColor(color, gray, cv::COLOR_RGB2GRAY);
  Features features;
  MakeExtractor(options.kind, options.features)
      ->detectAndCompute(gray, cv::noArray(), features.keypoints,
                         features.descriptors);
  return features;
}

// The features that method sift works with, as OpenCV finds them.
absl::StatusOr<Features> ExtractLargest(const image::ColorImage& image,
                                        int count) {
  TL_ASSIGN_OR_RETURN(
      const features::SiftFeatures sift,
      yardsticks::ExtractOpenCvSift(image, {.max_features = count}));
  return ToOpenCv(sift);
}

// A query's feature and the place in the scene that it may show.
struct Match {
  camera::Pixel pixel;
  geometry::Vec3 point_in_world;
};

struct PnpResult {
  geometry::Rigid3 color_from_world;
  std::vector<bool> inlier;  // one a match
  int inliers = 0;
};

geometry::Rigid3 ToRigid(const cv::Mat& rotation, const cv::Mat& translation) {
  return {geometry::Rotation3::FromAxisAngle({rotation.at<double>(0),
                                              rotation.at<double>(1),
                                              rotation.at<double>(2)}),
          {translation.at<double>(0), translation.at<double>(1),
           translation.at<double>(2)}};
}

// Marks the matches that `color_from_world` reprojects within `inlier_px`.
PnpResult CountInliers(const camera::Camera& camera,
                       const std::vector<Match>& matches,
                       const geometry::Rigid3& color_from_world,
                       double inlier_px) {
  PnpResult result{color_from_world, std::vector<bool>(matches.size()), 0};
  for (size_t i = 0; i < matches.size(); ++i) {
    const geometry::Vec3 point = color_from_world * matches[i].point_in_world;
    if (point.z <= 0) continue;
    const camera::Pixel pixel = camera.Project(point);
    result.inlier[i] = std::hypot(pixel.x - matches[i].pixel.x,
                                  pixel.y - matches[i].pixel.y) < inlier_px;
    result.inliers += result.inlier[i];
  }
  return result;
}

// Matches as OpenCV takes them: pixels as an ideal pinhole of the camera's
// focal length would see them, so that any camera model will do.
struct PnpProblem {
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  cv::Matx33d intrinsics;
};

PnpProblem MakeProblem(const camera::Camera& camera,
                       const std::vector<Match>& matches,
                       const std::vector<bool>& use) {
  PnpProblem problem;
  problem.intrinsics = {camera.fx(), 0, camera.cx(), 0, camera.fy(),
                        camera.cy(), 0, 0,           1};
  for (size_t i = 0; i < matches.size(); ++i) {
    if (!use[i]) continue;
    const std::optional<camera::Pixel> ray = camera.Unproject(matches[i].pixel);
    if (!ray) continue;
    const geometry::Vec3& point = matches[i].point_in_world;
    problem.points.emplace_back(point.x, point.y, point.z);
    problem.pixels.emplace_back(camera.fx() * ray->x + camera.cx(),
                                camera.fy() * ray->y + camera.cy());
  }
  return problem;
}

// The pose that most matches agree with, refined on all of these.
std::optional<PnpResult> SolvePose(const camera::Camera& camera,
                                   const std::vector<Match>& matches,
                                   const FeaturePnpOptions& options) {
  const PnpProblem problem =
      MakeProblem(camera, matches, std::vector<bool>(matches.size(), true));
  if (problem.points.size() < kMinMatches) return std::nullopt;
  cv::Mat rotation;
  cv::Mat translation;
  // Its random numbers start from a fixed seed in every call.
  if (!cv::solvePnPRansac(problem.points, problem.pixels, problem.intrinsics,
                          cv::noArray(), rotation, translation, false,
                          options.ransac_iterations,
                          static_cast<float>(options.inlier_px), 0.9999,
                          cv::noArray(), cv::SOLVEPNP_AP3P)) {
    return std::nullopt;
  }
  PnpResult result = CountInliers(
      camera, matches, ToRigid(rotation, translation), options.inlier_px);
  for (int round = 0; round < 3 && result.inliers >= kMinMatches; ++round) {
    const PnpProblem inliers = MakeProblem(camera, matches, result.inlier);
    cv::solvePnPRefineLM(inliers.points, inliers.pixels, inliers.intrinsics,
                         cv::noArray(), rotation, translation);
    PnpResult refined = CountInliers(
        camera, matches, ToRigid(rotation, translation), options.inlier_px);
    if (refined.inliers < result.inliers) break;
    result = std::move(refined);
  }
  return result;
}

class FeaturePnpBaseline final : public localizer::Localizer {
 public:
  FeaturePnpBaseline(forest::ModelInfo info, FeaturePnpOptions options,
                     cv::Mat descriptors,
                     std::vector<geometry::Vec3> points_in_world)
      : info_(std::move(info)),
        options_(std::move(options)),
        descriptors_(std::move(descriptors)),
        points_in_world_(std::move(points_in_world)) {
    cv::setRNGSeed(static_cast<int>(options_.seed & 0x7fffffff));
    if (options_.kind != FeatureKind::kOrb) {
      index_ = std::make_unique<cv::flann::Index>(
          descriptors_, cv::flann::KDTreeIndexParams(4));
    } else {
      // 12 tables of 20-bit keys, looked at with all neighbours of one bit:
      // what OpenCV's tutorial on ORB takes.
      index_ = std::make_unique<cv::flann::Index>(
          descriptors_, cv::flann::LshIndexParams(12, 20, 1),
          cvflann::FLANN_DIST_HAMMING);
    }
  }

  absl::StatusOr<localizer::PoseEstimate> Localize(
      const image::Frame& frame,
      const localizer::LocalizeOptions& options) const override {
    try {
      return LocalizeOrThrow(frame, options);
    } catch (const cv::Exception& error) {
      return absl::InternalError(absl::StrCat("OpenCV: ", error.what()));
    }
  }

  const forest::ModelInfo& info() const override { return info_; }
  localizer::DepthUse depth_use() const override {
    return localizer::DepthUse::kIgnored;
  }

 private:
  absl::StatusOr<localizer::PoseEstimate> LocalizeOrThrow(
      const image::Frame& frame,
      const localizer::LocalizeOptions& options) const;
  std::vector<Match> FindMatches(const Features& features) const;

  const forest::ModelInfo info_;
  const FeaturePnpOptions options_;
  const cv::Mat descriptors_;  // one row a point; the index refers to them
  const std::vector<geometry::Vec3> points_in_world_;
  // Searching does not change it, though OpenCV does not say so.
  std::unique_ptr<cv::flann::Index> index_;
};

std::vector<Match> FeaturePnpBaseline::FindMatches(
    const Features& features) const {
  const int count = std::min(kNeighbours, descriptors_.rows);
  const auto rows = static_cast<int>(features.keypoints.size());
  const bool sift = options_.kind != FeatureKind::kOrb;
  // Hashing may find fewer than `count`, and leaves the rest as it was. Squared
  // distances for SIFT, counted bits for ORB.
  cv::Mat neighbours(rows, count, CV_32S, cv::Scalar(-1));
  cv::Mat found_distances(rows, count, sift ? CV_32F : CV_32S, cv::Scalar(0));
  index_->knnSearch(features.descriptors, neighbours, found_distances, count,
                    cv::flann::SearchParams(options_.flann_checks));
  cv::Mat distances;
  found_distances.convertTo(distances, CV_32F);
  std::vector<Match> matches;
  for (int i = 0; i < neighbours.rows; ++i) {
    const int* nearest = neighbours.ptr<int>(i);
    const float* distance = distances.ptr<float>(i);
    if (nearest[0] < 0) continue;
    const geometry::Vec3 best =
        points_in_world_[static_cast<size_t>(nearest[0])];
    bool distinct = true;
    for (int k = 1; k < count && nearest[k] >= 0; ++k) {
      const geometry::Vec3 other =
          points_in_world_[static_cast<size_t>(nearest[k])];
      if (geometry::Norm(other - best) < options_.same_place_m) continue;
      const double ratio = static_cast<double>(distance[0]) /
                           static_cast<double>(std::max(distance[k], 1e-9F));
      distinct = (sift ? std::sqrt(ratio) : ratio) < options_.match_ratio;
      break;
    }
    const cv::Point2f& at = features.keypoints[static_cast<size_t>(i)].pt;
    if (distinct) matches.push_back({{at.x, at.y}, best});
  }
  return matches;
}

absl::StatusOr<localizer::PoseEstimate> FeaturePnpBaseline::LocalizeOrThrow(
    const image::Frame& frame,
    const localizer::LocalizeOptions& options) const {
  const base::SteadyClock clock;
  const base::MonotonicTime start = clock.Now();
  const camera::Camera camera =
      frame.calibration.value_or(info_.calibration).color;
  Features features;
  if (options_.kind != FeatureKind::kFastSift &&
      options_.structure_features > 0 && !info_.units_are_metres) {
    TL_ASSIGN_OR_RETURN(
        features, ExtractLargest(frame.color, options_.structure_features));
  } else {
    features = Extract(frame.color, options_);
  }
  localizer::PoseEstimate estimate;
  const base::MonotonicTime extracted = clock.Now();
  estimate.timings.sample_ms = base::MillisecondsBetween(start, extracted);
  if (options.stop.stop_requested()) {
    return absl::CancelledError("the query was cancelled");
  }
  std::vector<Match> matches;
  if (!features.keypoints.empty()) matches = FindMatches(features);
  const base::MonotonicTime matched = clock.Now();
  estimate.timings.forest_ms = base::MillisecondsBetween(extracted, matched);
  estimate.samples = static_cast<int>(matches.size());
  std::optional<PnpResult> pose;
  if (estimate.samples >= kMinMatches) {
    pose = SolvePose(camera, matches, options_);
    estimate.reason = localizer::NotLocalizedReason::kTooFewInliers;
  }
  if (pose) {
    estimate.world_from_camera = pose->color_from_world.Inverse();
    estimate.inliers = pose->inliers;
    estimate.inlier_ratio =
        static_cast<double>(pose->inliers) / estimate.samples;
    if (estimate.inliers >= options_.min_inliers) {
      estimate.outcome = localizer::Outcome::kLocalized;
      estimate.reason = localizer::NotLocalizedReason::kNone;
    }
  }
  for (size_t i = 0; options.keep_correspondences && i < matches.size(); ++i) {
    const geometry::Vec3 in_world = matches[i].point_in_world;
    estimate.correspondences.push_back(
        {matches[i].pixel,
         pose ? pose->color_from_world * in_world : geometry::Vec3{}, in_world,
         pose && pose->inlier[i]});
  }
  const base::MonotonicTime end = clock.Now();
  estimate.timings.pose_ms = base::MillisecondsBetween(matched, end);
  estimate.timings.total_ms = base::MillisecondsBetween(start, end);
  return estimate;
}

// Collects the features of keyframes that have depth.
class KeyframeCollector {
 public:
  KeyframeCollector(const dataset::Dataset& training,
                    const camera::RgbdCalibration& calibration,
                    const FeaturePnpOptions& options)
      : training_(training),
        calibration_(calibration),
        options_(options),
        registration_(calibration) {}

  // A frame without pose or depth adds nothing.
  absl::Status Add(int i) {
    const dataset::DatasetFrame& entry = training_.frame(i);
    if (training_.structure() != nullptr) return AddFromStructure(i);
    if (!entry.world_from_camera || entry.depth_path.empty()) {
      return absl::OkStatus();
    }
    TL_ASSIGN_OR_RETURN(const image::Frame frame, training_.Load(i));
    const geometry::Rigid3 world_from_color = camera::PoseOfSensor(
        *entry.world_from_camera, training_.calibration().pose_sensor,
        camera::RgbdSensor::kColor, calibration_);
    const Features features = Extract(frame.color, options_);
    const std::vector<geometry::Vec3> points =
        registration_.PointsInColor(*frame.depth);
    ++frames_;
    for (size_t k = 0; k < features.keypoints.size(); ++k) {
      const cv::Point2f& at = features.keypoints[k].pt;
      const auto point = registration_.PointAt(points, {at.x, at.y});
      if (!point) continue;
      descriptors_.push_back(features.descriptors.row(static_cast<int>(k)));
      points_in_world_.push_back(world_from_color * *point);
    }
    return absl::OkStatus();
  }

  // The features that show a point of the structure; see TrainSiftForest.
  absl::Status AddFromStructure(int i) {
    const dataset::SfmModel& model = *training_.structure();
    const dataset::SfmModel::Image& image =
        model.images[static_cast<size_t>(training_.frame(i).structure_image)];
    const training::SiftTrainingOptions defaults;
    TL_ASSIGN_OR_RETURN(const image::Frame frame, training_.Load(i));
    Features features;
    if (options_.kind == FeatureKind::kFastSift) {
      features = Extract(frame.color, options_);
    } else {
      TL_ASSIGN_OR_RETURN(
          features,
          ExtractLargest(frame.color, defaults.features.max_features));
    }
    std::vector<features::SiftKeypoint> keypoints;
    for (const cv::KeyPoint& k : features.keypoints) {
      keypoints.push_back({.pixel = {k.pt.x, k.pt.y}});
    }
    const std::vector<int32_t> points = training::LabelFeatures(
        keypoints, image.keypoints, defaults.label_radius_px);
    ++frames_;
    for (size_t k = 0; k < points.size(); ++k) {
      if (points[k] < 0) continue;
      descriptors_.push_back(features.descriptors.row(static_cast<int>(k)));
      points_in_world_.push_back(
          model.points[static_cast<size_t>(points[k])].position_in_world);
    }
    return absl::OkStatus();
  }

  int frames() const { return frames_; }
  cv::Mat& descriptors() { return descriptors_; }
  std::vector<geometry::Vec3>& points_in_world() { return points_in_world_; }

 private:
  const dataset::Dataset& training_;
  const camera::RgbdCalibration calibration_;
  const FeaturePnpOptions& options_;
  const image::DepthRegistrar registration_;
  int frames_ = 0;
  cv::Mat descriptors_;
  std::vector<geometry::Vec3> points_in_world_;
};

forest::ModelInfo DescribeBaseline(const dataset::Dataset& training,
                                   const camera::RgbdCalibration& calibration,
                                   const FeaturePnpOptions& options) {
  forest::ModelInfo info;
  info.method = BaselineName(options.kind);
  info.software_version = base::Version();
  info.created_utc = tools::UtcNow();
  info.dataset = training.uri();
  info.seed = options.seed;
  info.options = {
      {"keyframes", absl::StrCat(options.keyframes)},
      {"features", absl::StrCat(options.features)},
      {"match-ratio", absl::StrCat(options.match_ratio)},
      {"same-place-m", absl::StrCat(options.same_place_m)},
      {"flann-checks", absl::StrCat(options.flann_checks)},
      {"inlier-px", absl::StrCat(options.inlier_px)},
      {"ransac-iterations", absl::StrCat(options.ransac_iterations)},
      {"min-inliers", absl::StrCat(options.min_inliers)},
      {"opencv", CV_VERSION}};
  info.calibration = calibration;
  info.calibration.pose_sensor = camera::RgbdSensor::kColor;
  info.units_are_metres = training.units_are_metres();
  return info;
}

void AddBounds(const std::vector<geometry::Vec3>& points,
               forest::ModelInfo& info) {
  info.bounds_min_in_world = info.bounds_max_in_world = points.front();
  for (const geometry::Vec3& p : points) {
    geometry::Vec3& low = info.bounds_min_in_world;
    geometry::Vec3& high = info.bounds_max_in_world;
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y),
            std::max(high.z, p.z)};
  }
}

absl::StatusOr<std::unique_ptr<localizer::Localizer>> BuildOrThrow(
    const dataset::Dataset& training,
    const camera::RgbdCalibration& calibration,
    const FeaturePnpOptions& options) {
  const base::SteadyClock clock;
  const base::MonotonicTime start = clock.Now();
  yardsticks::RunOpenCvOnCallingThread();
  const int count = options.keyframes == 0
                        ? training.size()
                        : std::min(options.keyframes, training.size());
  KeyframeCollector collector(training, calibration, options);
  {
    base::Progress progress("keyframes", count, options.quiet);
    for (int k = 0; k < count; ++k) {
      if (options.stop.stop_requested()) {
        return absl::CancelledError("building the baseline was interrupted");
      }
      const int64_t i = int64_t{k} * training.size() / count;
      TL_RETURN_IF_ERROR(collector.Add(static_cast<int>(i)));
      progress.Add(1);
    }
  }
  std::vector<geometry::Vec3>& points = collector.points_in_world();
  if (points.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        training.uri(), ": none of ", count,
        " keyframes has a pose, depth and a feature on measured depth"));
  }
  forest::ModelInfo info = DescribeBaseline(training, calibration, options);
  info.training_frames = collector.frames();
  info.training_samples = static_cast<int64_t>(points.size());
  info.file_bytes = points.size() *
                    (collector.descriptors().step[0] + sizeof(geometry::Vec3));
  AddBounds(points, info);
  info.training_s = base::MillisecondsBetween(start, clock.Now()) / 1e3;
  return std::make_unique<FeaturePnpBaseline>(
      std::move(info), options, collector.descriptors(), std::move(points));
}

}  // namespace

const char* BaselineName(FeatureKind kind) {
  switch (kind) {
    case FeatureKind::kSift:
      return "sift-pnp";
    case FeatureKind::kOrb:
      return "orb-pnp";
    case FeatureKind::kFastSift:
      return "fast-sift-pnp";
  }
  return "";
}

std::optional<FeatureKind> BaselineOfName(absl::string_view name) {
  for (FeatureKind kind :
       {FeatureKind::kSift, FeatureKind::kOrb, FeatureKind::kFastSift}) {
    if (name == BaselineName(kind)) return kind;
  }
  return std::nullopt;
}

absl::Status FeaturePnpOptions::Validate() const {
  if (keyframes < 0 || features < 0 || flann_checks < 1 ||
      flann_checks > 100000 || ransac_iterations < 1 || min_inliers < 4) {
    return absl::InvalidArgumentError(
        "baseline: keyframes and features must be at least 0, FLANN checks in "
        "[1, 100000], RANSAC iterations at least 1, inliers at least 4");
  }
  if (!(match_ratio > 0 && match_ratio <= 1) || !(inlier_px > 0) ||
      !(same_place_m >= 0)) {
    return absl::InvalidArgumentError(
        "baseline: the match ratio must be in (0, 1], distances positive");
  }
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<localizer::Localizer>> BuildFeaturePnpBaseline(
    const dataset::Dataset& training,
    const camera::RgbdCalibration& calibration,
    const FeaturePnpOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  try {
    return BuildOrThrow(training, calibration, options);
  } catch (const cv::Exception& error) {
    return absl::InternalError(absl::StrCat("OpenCV: ", error.what()));
  }
}

}  // namespace treeline::accuracy
