#include "server/core/training/forest_refiller.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/parallel_for.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "server/core/training/frame_samples.h"
#include "server/core/training/quantize_forest.h"

namespace treeline::training {

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
  LeafFiller filler(base, refill, /*max_gathered=*/0);
  std::vector<std::vector<RoutedSamples>> routed(frames.size());
  std::vector<absl::Status> statuses(frames.size());
  const auto route = [&](size_t i) -> absl::Status {
    const int frame_index = frames[i];
    const dataset::DatasetFrame& entry = dataset.frame(frame_index);
    TL_ASSIGN_OR_RETURN(const image::Frame frame, dataset.Load(frame_index));
    TL_RETURN_IF_ERROR(CheckSizes(entry.color_path, frame, calibration));
    const features::PlanarImage image(frame.color);
    const FrameSampler sampler(geometry, frame, image, *entry.world_from_camera,
                               options, frame_index);
    for (size_t t = 0; t < trees; ++t) {
      const int tree = static_cast<int>(t);
      routed[i].push_back(filler.Route(tree, image, sampler.Draw(tree)));
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
                      const int tree = static_cast<int>(t);
                      for (const std::vector<RoutedSamples>& frame : routed) {
                        filler.Add(tree, frame[static_cast<size_t>(t)]);
                      }
                      grown[static_cast<size_t>(t)] = filler.Assemble(tree);
                    });
  TrainedForest result;
  result.frames = static_cast<int>(frames.size());
  for (const auto& frame : routed) {
    for (const RoutedSamples& samples : frame) {
      result.samples += static_cast<int64_t>(samples.size());
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
