#include "server/core/training/sift_trainer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "Eigen/Core"
#include "Eigen/LU"
#include "absl/strings/str_cat.h"
#include "common/base/parallel_for.h"
#include "common/base/progress.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "server/core/training/sift_tree_grower.h"

namespace treeline::training {
namespace {

constexpr uint64_t kImageStream = 0x736966745f696d67;
// Points this many times the range of the middle 99 % beyond it are left out.
constexpr double kOutlierRange = 0.5;
constexpr double kOutlierQuantile = 0.005;
// Nobody measures a keypoint better than this (px).
constexpr double kPixelSigma_px = 1;

double Quantile(std::vector<double> values, double q) {
  const auto middle =
      values.begin() +
      static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// What a point's observations in the training images leave uncertain.
class PointInformation {
 public:
  // A ray of unit length in the world, seen from `distance` away.
  void Add(geometry::Vec3 ray, double distance, double focal_px) {
    const double sigma = kPixelSigma_px / focal_px * distance;
    const Eigen::Vector3d v(ray.x, ray.y, ray.z);
    information_ +=
        (Eigen::Matrix3d::Identity() - v * v.transpose()) / (sigma * sigma);
    ++count_;
  }
  // xx xy xz yy yz zz. Beyond `limit` (a standard deviation) all is the same.
  std::array<float, 6> Covariance(double limit) const {
    const Eigen::Matrix3d c =
        (information_ + Eigen::Matrix3d::Identity() / (limit * limit))
            .inverse();
    return {static_cast<float>(c(0, 0)), static_cast<float>(c(0, 1)),
            static_cast<float>(c(0, 2)), static_cast<float>(c(1, 1)),
            static_cast<float>(c(1, 2)), static_cast<float>(c(2, 2))};
  }

 private:
  Eigen::Matrix3d information_ = Eigen::Matrix3d::Zero();
  int count_ = 0;
};

// The labelled features of one image.
struct ImageSamples {
  absl::Status status;
  SiftSamples samples;
};

class SiftTrainer {
 public:
  SiftTrainer(const dataset::Dataset& dataset,
              const SiftTrainingOptions& options, bool quiet,
              const std::stop_token& stop)
      : dataset_(dataset), options_(options), quiet_(quiet), stop_(stop) {}

  absl::StatusOr<TrainedSiftForest> Train() {
    if (dataset_.structure() == nullptr) {
      return absl::FailedPreconditionError(
          absl::StrCat(dataset_.uri(),
                       ": method sift learns from a structure from motion; "
                       "give colmap:MODEL_DIR,IMAGES_DIR or nvm:FILE"));
    }
    MeasureScene();
    TL_RETURN_IF_ERROR(ReadImages());
    GrowTrees();
    TL_RETURN_IF_ERROR(CheckStop());
    Assemble();
    return std::move(result_);
  }

 private:
  absl::Status CheckStop() const {
    return stop_.stop_requested()
               ? absl::CancelledError("training was interrupted")
               : absl::OkStatus();
  }

  // Uncertainties, viewing distance, and which points are near the others.
  void MeasureScene() {
    const dataset::SfmModel& model = *dataset_.structure();
    information_.resize(model.points.size());
    std::vector<double> distances;
    std::array<std::vector<double>, 3> coordinates;
    for (int i = 0; i < dataset_.size(); ++i) {
      const dataset::SfmModel::Image& image = ImageOf(i);
      const geometry::Vec3 center =
          image.camera_from_world.Inverse().translation;
      const double focal_px = camera::MeanFocal_px(
          model.cameras[static_cast<size_t>(image.camera)]);
      for (const dataset::SfmModel::Keypoint& keypoint : image.keypoints) {
        if (keypoint.point < 0) continue;
        const size_t p = static_cast<size_t>(keypoint.point);
        const geometry::Vec3 ray = model.points[p].position_in_world - center;
        const double distance = geometry::Norm(ray);
        if (!(distance > 0)) continue;
        information_[p].Add(ray / distance, distance, focal_px);
        distances.push_back(distance);
        for (int k = 0; k < 3; ++k) {
          coordinates[static_cast<size_t>(k)].push_back(
              model.points[p].position_in_world[k]);
        }
      }
    }
    is_near_.assign(model.points.size(), !distances.empty());
    if (distances.empty()) return;
    result_.viewing_distance = Quantile(std::move(distances), 0.5);
    for (int k = 0; k < 3; ++k) {
      std::vector<double>& values = coordinates[static_cast<size_t>(k)];
      const double low = Quantile(values, kOutlierQuantile);
      const double high = Quantile(values, 1 - kOutlierQuantile);
      const double margin = kOutlierRange * (high - low) + 1e-9;
      for (size_t p = 0; p < model.points.size(); ++p) {
        const double x = model.points[p].position_in_world[k];
        if (x < low - margin || x > high + margin) is_near_[p] = false;
      }
    }
  }

  const dataset::SfmModel::Image& ImageOf(int frame) const {
    return dataset_.structure()
        ->images[static_cast<size_t>(dataset_.frame(frame).structure_image)];
  }

  absl::Status ReadImage(int frame, SiftSamples& samples) const {
    TL_ASSIGN_OR_RETURN(const image::Frame loaded, dataset_.Load(frame));
    const features::SiftFeatures features =
        features::ExtractSift(loaded.color, options_.features);
    const std::vector<int32_t> points = LabelFeatures(
        features.keypoints, ImageOf(frame).keypoints, options_.label_radius_px);
    for (size_t i = 0; i < points.size(); ++i) {
      if (points[i] < 0 || !is_near_[static_cast<size_t>(points[i])]) continue;
      samples.descriptor.push_back(features.descriptors[i]);
      samples.point.push_back(points[i]);
    }
    return absl::OkStatus();
  }

  absl::Status ReadImages() {
    std::vector<ImageSamples> images(static_cast<size_t>(dataset_.size()));
    {
      base::Progress progress("features", dataset_.size(), quiet_);
      base::ParallelFor(dataset_.size(), options_.threads, [&](int64_t i) {
        ImageSamples& image = images[static_cast<size_t>(i)];
        image.status = CheckStop();
        if (!image.status.ok()) return;
        image.status = ReadImage(static_cast<int>(i), image.samples);
        progress.Add(1);
      });
    }
    for (const ImageSamples& image : images) {
      TL_RETURN_IF_ERROR(image.status);
      image_begin_.push_back(static_cast<uint32_t>(samples_.point.size()));
      samples_.descriptor.insert(samples_.descriptor.end(),
                                 image.samples.descriptor.begin(),
                                 image.samples.descriptor.end());
      samples_.point.insert(samples_.point.end(), image.samples.point.begin(),
                            image.samples.point.end());
    }
    image_begin_.push_back(static_cast<uint32_t>(samples_.point.size()));
    if (!samples_.point.empty()) return absl::OkStatus();
    return absl::FailedPreconditionError(absl::StrCat(
        dataset_.uri(), ": no feature of ", dataset_.size(),
        " images lies on a keypoint of the model that has a point; are these "
        "the images, in the size, that the model was computed from?"));
  }

  // The samples of the images that a tree draws.
  std::vector<uint32_t> DrawSamples(int tree, std::vector<bool>& used) const {
    std::vector<size_t> images(static_cast<size_t>(dataset_.size()));
    std::iota(images.begin(), images.end(), size_t{0});
    const size_t wanted =
        std::min(images.size(), static_cast<size_t>(options_.images_per_tree));
    base::Random random(options_.seed,
                        kImageStream + static_cast<uint64_t>(tree));
    for (size_t i = 0; i < wanted; ++i) {
      const size_t left = images.size() - i;
      std::swap(images[i],
                images[i + random.NextBelow(static_cast<uint32_t>(left))]);
    }
    images.resize(wanted);
    std::ranges::sort(images);
    std::vector<uint32_t> chosen;
    for (const size_t image : images) {
      used[image] = true;
      for (uint32_t s = image_begin_[image]; s < image_begin_[image + 1]; ++s) {
        chosen.push_back(s);
      }
    }
    return chosen;
  }

  void GrowTrees() {
    const dataset::SfmModel& model = *dataset_.structure();
    std::vector<Label> position;
    for (const dataset::SfmModel::Point& point : model.points) {
      const geometry::Vec3& p = point.position_in_world;
      position.push_back({static_cast<float>(p.x), static_cast<float>(p.y),
                          static_cast<float>(p.z)});
    }
    std::vector<bool> used(static_cast<size_t>(dataset_.size()));
    std::vector<std::vector<uint32_t>> chosen;
    for (int t = 0; t < options_.trees; ++t) {
      chosen.push_back(DrawSamples(t, used));
      result_.samples += static_cast<int64_t>(chosen.back().size());
    }
    result_.images = static_cast<int>(std::ranges::count(used, true));
    grown_.resize(chosen.size());
    base::Progress progress("growing trees", options_.trees, quiet_);
    base::ParallelFor(options_.trees, options_.threads, [&](int64_t t) {
      const size_t tree = static_cast<size_t>(t);
      grown_[tree] = GrowSiftTree(samples_, position, std::move(chosen[tree]),
                                  options_, static_cast<int>(t), stop_);
      progress.Add(1);
    });
  }

  // One forest of all trees, positions relative to its bounds.
  void Assemble() {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const dataset::SfmModel& model = *dataset_.structure();
    geometry::Vec3 low{kInfinity, kInfinity, kInfinity};
    geometry::Vec3 high = -low;
    for (const int32_t point : samples_.point) {
      const geometry::Vec3& p =
          model.points[static_cast<size_t>(point)].position_in_world;
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y),
              std::max(high.z, p.z)};
    }
    forest::Forest& forest = result_.forest;
    forest.bounds_min_in_world = low;
    forest.bounds_max_in_world = high;
    for (const GrownSiftTree& tree : grown_) {
      const uint32_t base = static_cast<uint32_t>(forest.payloads.size());
      for (forest::Node node : tree.nodes) {
        if (node.is_leaf()) {
          node = forest::Node::Leaf(node.leaf() + base, node.modes());
        }
        forest.nodes.push_back(node);
      }
      forest.tree_offsets.push_back(static_cast<uint32_t>(forest.nodes.size()));
      for (const GrownSiftTree::Mode& mode : tree.modes) {
        forest.sift_descriptors.push_back(mode.descriptor);
        forest.payloads.push_back(PayloadOf(mode));
      }
    }
  }

  forest::LeafPayload PayloadOf(const GrownSiftTree::Mode& mode) const {
    const size_t point = static_cast<size_t>(mode.point);
    const geometry::Vec3& position =
        dataset_.structure()->points[point].position_in_world;
    const geometry::Vec3& low = result_.forest.bounds_min_in_world;
    const geometry::Vec3& high = result_.forest.bounds_max_in_world;
    forest::LeafPayload payload;
    for (int k = 0; k < 3; ++k) {
      const double range = high[k] - low[k];
      const double share = range > 0 ? (position[k] - low[k]) / range : 0;
      payload.mean[static_cast<size_t>(k)] =
          static_cast<uint16_t>(std::lround(65535 * share));
    }
    const std::array<float, 6> covariance =
        information_[point].Covariance(result_.viewing_distance);
    for (size_t k = 0; k < 6; ++k) {
      payload.covariance[k] = forest::ToBfloat16(covariance[k]);
    }
    payload.count =
        static_cast<uint16_t>(std::min<uint32_t>(mode.count, 65535));
    return payload;
  }

  const dataset::Dataset& dataset_;
  const SiftTrainingOptions& options_;
  const bool quiet_;
  const std::stop_token stop_;
  std::vector<PointInformation> information_;  // by point
  std::vector<bool> is_near_;                  // by point
  SiftSamples samples_;
  std::vector<uint32_t> image_begin_;  // frame i's samples begin there
  std::vector<GrownSiftTree> grown_;
  TrainedSiftForest result_;
};

}  // namespace

absl::Status SiftTrainingOptions::Validate() const {
  const auto check = [](absl::string_view name, int value, int low, int high) {
    if (value >= low && value <= high) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrCat(
        name, " is ", value, "; it must be between ", low, " and ", high));
  };
  TL_RETURN_IF_ERROR(check("trees", trees, 1, 64));
  TL_RETURN_IF_ERROR(check("images per tree", images_per_tree, 1, 65535));
  TL_RETURN_IF_ERROR(check("features", features.max_features, 0, 1000000));
  TL_RETURN_IF_ERROR(check("balanced levels", balanced_levels, 0, 40));
  TL_RETURN_IF_ERROR(check("maximum depth", max_depth, 1, 40));
  TL_RETURN_IF_ERROR(
      check("samples of a leaf", leaf_samples, 1, forest::Node::kMaxModes));
  TL_RETURN_IF_ERROR(check("split candidates", split_candidates, 1, 1000));
  if (!(label_radius_px > 0 && label_radius_px <= 10)) {
    return absl::InvalidArgumentError(
        absl::StrCat("the radius of labels is ", label_radius_px,
                     " px; it must be above 0 and at most 10"));
  }
  return absl::OkStatus();
}

absl::StatusOr<TrainedSiftForest> TrainSiftForest(
    const dataset::Dataset& dataset, const SiftTrainingOptions& options,
    bool quiet, const std::stop_token& stop) {
  TL_RETURN_IF_ERROR(options.Validate());
  return SiftTrainer(dataset, options, quiet, stop).Train();
}

std::vector<int32_t> LabelFeatures(
    std::span<const features::SiftKeypoint> features,
    std::span<const dataset::SfmModel::Keypoint> keypoints, double radius_px) {
  // Keypoints by cells of the radius: a feature's neighbours lie in nine.
  const auto cell = [&](double x) {
    return static_cast<int64_t>(std::floor(x / radius_px));
  };
  const auto key = [](int64_t x, int64_t y) {
    return static_cast<uint64_t>(x) << 32 ^
           (static_cast<uint64_t>(y) & 0xffffffff);
  };
  std::unordered_map<uint64_t, std::vector<size_t>> in_cell;
  for (size_t i = 0; i < keypoints.size(); ++i) {
    const camera::Pixel& p = keypoints[i].pixel;
    // Written so that no wild number is converted.
    if (keypoints[i].point < 0 || !(std::abs(p.x) < 1e6) ||
        !(std::abs(p.y) < 1e6)) {
      continue;
    }
    in_cell[key(cell(p.x), cell(p.y))].push_back(i);
  }
  std::vector<int32_t> points(features.size(), -1);
  for (size_t f = 0; f < features.size(); ++f) {
    const camera::Pixel& at = features[f].pixel;
    double best = radius_px;
    size_t best_keypoint = keypoints.size();
    for (int64_t dy = -1; dy <= 1; ++dy) {
      for (int64_t dx = -1; dx <= 1; ++dx) {
        const auto found = in_cell.find(key(cell(at.x) + dx, cell(at.y) + dy));
        if (found == in_cell.end()) continue;
        for (const size_t i : found->second) {
          const camera::Pixel& p = keypoints[i].pixel;
          const double distance = std::hypot(p.x - at.x, p.y - at.y);
          if (distance < best || (distance == best && i < best_keypoint)) {
            best = distance;
            best_keypoint = i;
            points[f] = keypoints[i].point;
          }
        }
      }
    }
  }
  return points;
}

}  // namespace treeline::training
