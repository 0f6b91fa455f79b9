#include "server/core/training/forest_refiller.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/parallel_for.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "server/core/forest/backtracking.h"
#include "server/core/training/frame_samples.h"
#include "server/core/training/quantize_forest.h"
#include "server/core/training/tree_pruner.h"

namespace treeline::training {
namespace {

// Samples within this distance of a mode's mean belong to it (m).
constexpr double kModeRadius_m = 0.1;
// Modes a leaf keeps, those with most samples.
constexpr size_t kMaxModes = 16;

// The samples that one frame sends down one tree.
struct RoutedSamples {
  std::vector<uint32_t> leaf;  // the leaf's node, within the tree
  std::vector<Label> point_in_world;
  std::vector<features::WhtDescriptor> descriptor;
};

// Samples of a leaf that lie near each other, as sums.
class Mode {
 public:
  explicit Mode(const GrownLeaf& leaf) : count_(leaf.count) {
    const double n = leaf.count;
    sum_ = n * leaf.mean_in_world;
    const geometry::Vec3& m = leaf.mean_in_world;
    const std::array<double, 6> square = Products(m);
    for (size_t k = 0; k < 6; ++k) {
      products_[k] = n * (static_cast<double>(leaf.covariance[k]) + square[k]);
    }
    for (size_t k = 0; k < descriptor_.size(); ++k) {
      descriptor_[k] = n * leaf.descriptor.values[k];
    }
  }

  geometry::Vec3 mean() const { return sum_ / count_; }
  double count() const { return count_; }

  void Add(geometry::Vec3 point, const features::WhtDescriptor& descriptor) {
    ++count_;
    sum_ = sum_ + point;
    const std::array<double, 6> square = Products(point);
    for (size_t k = 0; k < 6; ++k) products_[k] += square[k];
    for (size_t k = 0; k < descriptor_.size(); ++k) {
      descriptor_[k] += descriptor.values[k];
    }
  }

  GrownLeaf ToLeaf() const {
    GrownLeaf leaf;
    leaf.count = static_cast<uint32_t>(count_);
    leaf.mean_in_world = mean();
    const std::array<double, 6> square = Products(leaf.mean_in_world);
    for (size_t k = 0; k < 6; ++k) {
      leaf.covariance[k] =
          static_cast<float>(products_[k] / count_ - square[k]);
    }
    // Rounding must not make a variance negative.
    for (const size_t k : {0u, 3u, 5u}) {
      leaf.covariance[k] = std::max(leaf.covariance[k], 0.0f);
    }
    for (size_t k = 0; k < descriptor_.size(); ++k) {
      leaf.descriptor.values[k] =
          static_cast<int8_t>(std::lround(descriptor_[k] / count_));
    }
    return leaf;
  }

 private:
  static std::array<double, 6> Products(geometry::Vec3 v) {
    return {v.x * v.x, v.x * v.y, v.x * v.z, v.y * v.y, v.y * v.z, v.z * v.z};
  }

  double count_ = 0;
  geometry::Vec3 sum_;
  std::array<double, 6> products_{};
  std::array<double, 64> descriptor_{};
};

void AddToNearest(geometry::Vec3 point,
                  const features::WhtDescriptor& descriptor,
                  std::vector<Mode>& modes) {
  double nearest = kModeRadius_m * kModeRadius_m;
  Mode* chosen = nullptr;
  for (Mode& mode : modes) {
    const double distance = geometry::SquaredNorm(mode.mean() - point);
    if (distance < nearest) {
      nearest = distance;
      chosen = &mode;
    }
  }
  if (chosen != nullptr) {
    chosen->Add(point, descriptor);
  } else {
    modes.emplace_back(GrownLeaf{point, {}, 1, descriptor});
  }
}

GrownTree RefillTree(const forest::ForestView& base, int t, Refill refill,
                     const std::vector<std::vector<RoutedSamples>>& routed) {
  const std::span<const forest::Node> nodes = base.tree(t);
  std::vector<std::vector<Mode>> modes(nodes.size());
  if (refill == Refill::kExtend) {
    const GrownTree old = GrownTreeOf(base, t);
    for (size_t i = 0; i < old.nodes.size(); ++i) {
      const forest::Node& node = old.nodes[i];
      for (uint32_t k = 0; node.is_leaf() && k < node.modes(); ++k) {
        modes[i].emplace_back(old.leaves[node.leaf() + k]);
      }
    }
  }
  for (const std::vector<RoutedSamples>& frame : routed) {
    const RoutedSamples& samples = frame[static_cast<size_t>(t)];
    for (size_t i = 0; i < samples.leaf.size(); ++i) {
      const Label& p = samples.point_in_world[i];
      AddToNearest({p.x, p.y, p.z}, samples.descriptor[i],
                   modes[samples.leaf[i]]);
    }
  }
  for (std::vector<Mode>& of_leaf : modes) {
    std::ranges::stable_sort(of_leaf, std::greater<>(), &Mode::count);
    if (of_leaf.size() > kMaxModes) {
      of_leaf.erase(of_leaf.begin() + kMaxModes, of_leaf.end());
    }
  }
  return TreeWithModes(nodes, [&](size_t node) {
    std::vector<GrownLeaf> leaves;
    for (const Mode& mode : modes[node]) leaves.push_back(mode.ToLeaf());
    return leaves;
  });
}

}  // namespace

absl::StatusOr<TrainedForest> RefillForest(
    const forest::ForestView& base, const dataset::Dataset& dataset,
    const camera::RgbdCalibration& calibration, const TrainingOptions& options,
    Refill refill, bool quiet, const std::stop_token& stop) {
  const std::vector<int> frames = UsableFrames(dataset);
  if (frames.empty()) {
    return absl::FailedPreconditionError(
        absl::StrCat(dataset.uri(),
                     ": no frame has both a pose and depth, so there is "
                     "nothing to learn from"));
  }
  const size_t trees = static_cast<size_t>(base.trees());
  const features::DepthGeometry geometry(calibration);
  // Leaves are numbered across trees; samples want to know the node. A copy of
  // the nodes whose leaves carry their own place does that.
  std::vector<forest::Node> places(base.nodes.begin(), base.nodes.end());
  for (size_t t = 0; t < trees; ++t) {
    for (size_t i = base.tree_offsets[t]; i < base.tree_offsets[t + 1]; ++i) {
      if (!places[i].is_leaf()) continue;
      places[i] =
          forest::Node::Leaf(static_cast<uint32_t>(i - base.tree_offsets[t]));
    }
  }
  std::vector<std::vector<RoutedSamples>> routed(frames.size());
  std::vector<absl::Status> statuses(frames.size());
  const auto route = [&](size_t i) -> absl::Status {
    const int frame_index = frames[i];
    const dataset::DatasetFrame& entry = dataset.frame(frame_index);
    TL_ASSIGN_OR_RETURN(const image::Frame frame, dataset.Load(frame_index));
    TL_RETURN_IF_ERROR(CheckSizes(entry, frame, calibration));
    const features::PlanarImage image(frame.color);
    const FrameSampler sampler(geometry, frame, image, *entry.world_from_camera,
                               options, frame_index);
    for (size_t t = 0; t < trees; ++t) {
      TreeSamples samples = sampler.Draw(static_cast<int>(t));
      RoutedSamples& out = routed[i].emplace_back();
      const std::vector<int32_t> x(samples.x.begin(), samples.x.end());
      const std::vector<int32_t> y(samples.y.begin(), samples.y.end());
      out.leaf.resize(x.size());
      forest::VisitLeaves(std::span(places).subspan(
                              base.tree_offsets[t],
                              base.tree_offsets[t + 1] - base.tree_offsets[t]),
                          image, {x, y, samples.inverse_depth_q12}, 1,
                          out.leaf);
      out.point_in_world = std::move(samples.point_in_world);
      out.descriptor = std::move(samples.descriptor);
    }
    return absl::OkStatus();
  };
  {
    base::Progress progress("refilling leaves",
                            static_cast<int64_t>(frames.size()), quiet);
    base::ParallelFor(
        static_cast<int64_t>(frames.size()), options.threads, [&](int64_t i) {
          if (stop.stop_requested()) return;
          statuses[static_cast<size_t>(i)] = route(static_cast<size_t>(i));
          progress.Add(1);
        });
  }
  if (stop.stop_requested()) {
    return absl::CancelledError("training was interrupted");
  }
  for (const absl::Status& status : statuses) TL_RETURN_IF_ERROR(status);
  std::vector<GrownTree> grown(trees);
  base::ParallelFor(static_cast<int64_t>(trees), options.threads,
                    [&](int64_t t) {
                      grown[static_cast<size_t>(t)] =
                          RefillTree(base, static_cast<int>(t), refill, routed);
                    });
  TrainedForest result;
  result.frames = static_cast<int>(frames.size());
  for (const auto& frame : routed) {
    for (const RoutedSamples& samples : frame) {
      result.samples += static_cast<int64_t>(samples.leaf.size());
    }
  }
  if (std::ranges::any_of(
          grown, [](const GrownTree& tree) { return tree.leaves.empty(); })) {
    return absl::FailedPreconditionError(
        absl::StrCat(dataset.uri(),
                     ": no pixel of the frames has usable depth; check the "
                     "depth unit and the depth camera"));
  }
  result.forest = QuantizeForest(std::move(grown));
  return result;
}

}  // namespace treeline::training
