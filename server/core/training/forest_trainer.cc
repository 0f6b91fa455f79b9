#include "server/core/training/forest_trainer.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/parallel_for.h"
#include "common/base/progress.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "server/core/training/frame_samples.h"
#include "server/core/training/quantize_forest.h"
#include "server/core/training/tree_grower.h"

namespace treeline::training {
namespace {

// Random streams of training, apart from those of the nodes.
constexpr uint64_t kFrameStream = 0x66726d0000000000;

// `count` of `frames` at random, in ascending order (a partial shuffle).
std::vector<int> DrawFrames(std::vector<int> frames, int count,
                            base::Random random) {
  const size_t wanted = std::min(frames.size(), static_cast<size_t>(count));
  for (size_t i = 0; i < wanted; ++i) {
    const size_t j =
        i + random.NextBelow(static_cast<uint32_t>(frames.size() - i));
    std::swap(frames[i], frames[j]);
  }
  frames.resize(wanted);
  std::sort(frames.begin(), frames.end());
  return frames;
}

// Of each tree, the frames that it is grown from: of the first ones as large a
// share as they have of all, so that no first tree is without.
std::vector<std::vector<int>> DrawFramesOfTrees(
    const std::vector<int>& usable, std::span<const int> first_frames,
    const TrainingOptions& options) {
  std::vector<int> others;
  std::ranges::set_difference(usable, first_frames, std::back_inserter(others));
  const int64_t count = std::min<int64_t>(options.frames_per_tree,
                                          static_cast<int64_t>(usable.size()));
  const int64_t of_first =
      (count * static_cast<int64_t>(first_frames.size()) +
       static_cast<int64_t>(usable.size()) - 1) /
      static_cast<int64_t>(std::max<size_t>(usable.size(), 1));
  std::vector<std::vector<int>> frames_of_tree;
  for (int t = 0; t < options.trees; ++t) {
    const base::Random random(options.seed,
                              kFrameStream + static_cast<uint64_t>(t));
    std::vector<int> frames =
        DrawFrames(others, static_cast<int>(count - of_first), random);
    const std::vector<int> first =
        DrawFrames({first_frames.begin(), first_frames.end()},
                   static_cast<int>(of_first), random);
    frames.insert(frames.end(), first.begin(), first.end());
    std::ranges::sort(frames);
    frames_of_tree.push_back(std::move(frames));
  }
  return frames_of_tree;
}

// Distinct frames of some trees, in ascending order.
std::vector<int> Union(std::span<const std::vector<int>> frames_of_tree) {
  std::vector<int> frames;
  for (const std::vector<int>& of_tree : frames_of_tree) {
    frames.insert(frames.end(), of_tree.begin(), of_tree.end());
  }
  std::sort(frames.begin(), frames.end());
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  return frames;
}

// A frame in memory, and its samples for each tree that drew it.
struct LoadedFrame {
  absl::Status status;
  features::PlanarImage image;
  std::map<int, TreeSamples> samples;  // by tree
};

class Trainer {
 public:
  Trainer(const dataset::Dataset& dataset,
          const camera::RgbdCalibration& calibration,
          const TrainingOptions& options, std::span<const int> first_frames,
          bool quiet, std::stop_token stop)
      : dataset_(dataset),
        geometry_(calibration),
        options_(options),
        first_frames_(first_frames),
        quiet_(quiet),
        stop_(std::move(stop)) {}

  absl::StatusOr<GrownTrees> Grow(TreeRange range);

 private:
  // Trees [first, last) are grown together.
  absl::Status TrainGroup(int first, int last);
  int GroupEnd(int first, int end) const;
  std::vector<int> FramesOfGroup(int first, int last) const;
  absl::Status LoadFrame(int frame, int first_tree, int last_tree,
                         LoadedFrame& loaded) const;
  absl::Status GrowGroup(int first, int last, const std::vector<int>& frames,
                         std::vector<LoadedFrame>& loaded);
  using Growers = std::vector<std::unique_ptr<TreeGrower>>;
  void GrowInRounds(const Growers& growers) const;
  void JoinOthers(const Growers& growers) const;
  std::vector<GrownTree> Assemble(const Growers& growers) const;
  absl::Status CheckStop() const {
    return stop_.stop_requested()
               ? absl::CancelledError("training was interrupted")
               : absl::OkStatus();
  }

  const dataset::Dataset& dataset_;
  const features::DepthGeometry geometry_;
  const TrainingOptions& options_;
  const std::span<const int> first_frames_;  // empty: all
  const bool quiet_;
  const std::stop_token stop_;
  std::vector<std::vector<int>> frames_of_tree_;
  GrownTrees result_;
};

absl::StatusOr<GrownTrees> Trainer::Grow(TreeRange range) {
  const std::vector<int> usable = UsableFrames(dataset_);
  if (usable.empty()) {
    return absl::FailedPreconditionError(
        absl::StrCat(dataset_.uri(),
                     ": no frame has both a pose and depth, so there is "
                     "nothing to learn from"));
  }
  frames_of_tree_ = DrawFramesOfTrees(usable, first_frames_, options_);
  for (int first = range.first; first < range.last;) {
    const int last = GroupEnd(first, range.last);
    TL_RETURN_IF_ERROR(TrainGroup(first, last));
    first = last;
  }
  return std::move(result_);
}

std::vector<int> Trainer::FramesOfGroup(int first, int last) const {
  return Union(std::span(frames_of_tree_)
                   .subspan(static_cast<size_t>(first),
                            static_cast<size_t>(last - first)));
}

int Trainer::GroupEnd(int first, int end) const {
  const camera::Camera& camera = geometry_.calibration().color;
  const int64_t image_bytes = int64_t{3} * camera.width() * camera.height();
  int last = first + 1;
  while (last < end &&
         image_bytes *
                 static_cast<int64_t>(FramesOfGroup(first, last + 1).size()) <=
             options_.image_memory_bytes) {
    ++last;
  }
  return last;
}

absl::Status Trainer::LoadFrame(int frame_index, int first_tree, int last_tree,
                                LoadedFrame& loaded) const {
  const dataset::DatasetFrame& entry = dataset_.frame(frame_index);
  TL_ASSIGN_OR_RETURN(const image::Frame frame, dataset_.Load(frame_index));
  TL_RETURN_IF_ERROR(
      CheckSizes(entry.color_path, frame, geometry_.calibration()));
  loaded.image.Assign(frame.color);
  const FrameSampler sampler(geometry_, frame, loaded.image,
                             *entry.world_from_camera, options_, frame_index);
  for (int t = first_tree; t < last_tree; ++t) {
    const std::vector<int>& of_tree = frames_of_tree_[static_cast<size_t>(t)];
    const auto place =
        std::lower_bound(of_tree.begin(), of_tree.end(), frame_index);
    if (place == of_tree.end() || *place != frame_index) continue;
    TreeSamples& samples = loaded.samples[t];
    samples = sampler.Draw(t);
    samples.frame.assign(samples.x.size(),
                         static_cast<uint16_t>(place - of_tree.begin()));
  }
  return absl::OkStatus();
}

absl::Status Trainer::TrainGroup(int first, int last) {
  const std::vector<int> frames = FramesOfGroup(first, last);
  std::vector<LoadedFrame> loaded(frames.size());
  {
    base::Progress progress("reading frames",
                            static_cast<int64_t>(frames.size()), quiet_);
    base::ParallelFor(
        static_cast<int64_t>(frames.size()), options_.threads, [&](int64_t i) {
          LoadedFrame& slot = loaded[static_cast<size_t>(i)];
          slot.status = CheckStop();
          if (!slot.status.ok()) return;
          slot.status =
              LoadFrame(frames[static_cast<size_t>(i)], first, last, slot);
          progress.Add(1);
        });
  }
  for (const LoadedFrame& frame : loaded) TL_RETURN_IF_ERROR(frame.status);
  return GrowGroup(first, last, frames, loaded);
}

// What is done to a chunk or a frame of a tree.
struct Task {
  TreeGrower* grower;
  size_t index;
};

template <typename Step>
void RunAll(const std::vector<Task>& tasks, int threads, Step step) {
  base::ParallelFor(static_cast<int64_t>(tasks.size()), threads,
                    [&](int64_t i) {
                      const Task& task = tasks[static_cast<size_t>(i)];
                      (task.grower->*step)(task.index);
                    });
}

// Until all are grown, or training is to stop.
void Trainer::GrowInRounds(const Growers& growers) const {
  int64_t total = 0;
  for (const auto& grower : growers) total += grower->total_work();
  base::Progress progress("growing trees", total, quiet_);
  int64_t finished = 0;
  while (!stop_.stop_requested()) {
    std::vector<Task> chunks;
    std::vector<Task> frames;
    int64_t now_finished = 0;
    for (const auto& grower : growers) {
      const bool grows = grower->BeginRound();
      now_finished += grower->finished_work();
      if (!grows) continue;
      for (size_t c = 0; c < grower->chunks(); ++c) {
        chunks.push_back({grower.get(), c});
      }
      for (size_t f = 0; f < grower->frames(); ++f) {
        frames.push_back({grower.get(), f});
      }
    }
    progress.Add(now_finished - finished);
    finished = now_finished;
    if (chunks.empty()) return;
    // Trees that share a frame read it one after the other.
    std::ranges::stable_sort(frames, {}, &Task::index);
    RunAll(chunks, options_.threads, &TreeGrower::Prepare);
    RunAll(frames, options_.threads, &TreeGrower::EvaluateFrame);
    RunAll(chunks, options_.threads, &TreeGrower::SplitNodes);
  }
}

void Trainer::JoinOthers(const Growers& growers) const {
  std::vector<Task> frames;
  for (const auto& grower : growers) {
    for (size_t f = 0; f < grower->frames(); ++f) {
      frames.push_back({grower.get(), f});
    }
  }
  std::ranges::stable_sort(frames, {}, &Task::index);
  RunAll(frames, options_.threads, &TreeGrower::RouteFrame);
  base::ParallelFor(
      static_cast<int64_t>(growers.size()), options_.threads,
      [&](int64_t i) { growers[static_cast<size_t>(i)]->Join(); });
}

std::vector<GrownTree> Trainer::Assemble(const Growers& growers) const {
  std::vector<GrownTree> grown(growers.size());
  base::ParallelFor(static_cast<int64_t>(growers.size()), options_.threads,
                    [&](int64_t i) {
                      const size_t g = static_cast<size_t>(i);
                      grown[g] = growers[g]->Assemble();
                    });
  return grown;
}

absl::Status Trainer::GrowGroup(int first, int last,
                                const std::vector<int>& frames,
                                std::vector<LoadedFrame>& loaded) {
  const size_t trees = static_cast<size_t>(last - first);
  std::vector<TreeSamples> samples(trees);
  Growers growers(trees);
  base::ParallelFor(
      static_cast<int64_t>(trees), options_.threads, [&](int64_t i) {
        const size_t g = static_cast<size_t>(i);
        const int tree = first + static_cast<int>(i);
        std::vector<const features::PlanarImage*> images;
        std::vector<uint8_t> waits;
        for (int frame : frames_of_tree_[static_cast<size_t>(tree)]) {
          LoadedFrame& slot = loaded[static_cast<size_t>(
              std::lower_bound(frames.begin(), frames.end(), frame) -
              frames.begin())];
          images.push_back(&slot.image);
          waits.push_back(!first_frames_.empty() &&
                          !std::ranges::binary_search(first_frames_, frame));
          TreeSamples& of_frame = slot.samples[tree];
          samples[g].Append(of_frame);
          of_frame = TreeSamples{};
        }
        growers[g] = std::make_unique<TreeGrower>(
            options_, tree, std::move(images), std::move(waits), samples[g]);
      });
  int64_t total = 0;
  for (const TreeSamples& of_tree : samples) {
    total += static_cast<int64_t>(of_tree.size());
  }
  // There may be none in the frames that come first.
  if (std::ranges::all_of(growers, [](const auto& grower) {
        return grower->total_work() == 0;
      })) {
    return absl::FailedPreconditionError(absl::StrCat(
        dataset_.uri(), options_.line_points
                            ? ": no line segment of the frames has usable "
                              "depth; a method without lines may do"
                            : ": no pixel of the frames has usable depth; "
                              "check the depth unit and the depth camera"));
  }
  GrowInRounds(growers);
  TL_RETURN_IF_ERROR(CheckStop());
  if (!first_frames_.empty()) {
    for (GrownTree& tree : Assemble(growers)) {
      result_.first.push_back(std::move(tree));
    }
    JoinOthers(growers);
    GrowInRounds(growers);
    TL_RETURN_IF_ERROR(CheckStop());
  }
  for (GrownTree& tree : Assemble(growers)) {
    result_.trees.push_back(std::move(tree));
  }
  result_.samples += total;
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<GrownTrees> GrowTrees(const dataset::Dataset& dataset,
                                     const camera::RgbdCalibration& calibration,
                                     const TrainingOptions& options,
                                     std::span<const int> first_frames,
                                     TreeRange range, bool quiet,
                                     std::stop_token stop) {
  TL_RETURN_IF_ERROR(options.Validate());
  if (range.first < 0 || range.first >= range.last ||
      range.last > options.trees) {
    return absl::InvalidArgumentError(
        absl::StrCat("trees ", range.first, " to ", range.last - 1,
                     " are not in a forest of ", options.trees));
  }
  if (calibration.pose_sensor != dataset.calibration().pose_sensor) {
    return absl::InvalidArgumentError(
        "the calibration's poses are of another sensor than the dataset's");
  }
  return Trainer(dataset, calibration, options, first_frames, quiet,
                 std::move(stop))
      .Grow(range);
}

int CountDrawnFrames(const dataset::Dataset& dataset,
                     const TrainingOptions& options,
                     std::span<const int> first_frames) {
  return static_cast<int>(
      Union(DrawFramesOfTrees(UsableFrames(dataset), first_frames, options))
          .size());
}

absl::StatusOr<TrainedForests> TrainForests(
    const dataset::Dataset& dataset, const camera::RgbdCalibration& calibration,
    const TrainingOptions& options, std::span<const int> first_frames,
    bool quiet, std::stop_token stop) {
  TL_ASSIGN_OR_RETURN(GrownTrees grown,
                      GrowTrees(dataset, calibration, options, first_frames,
                                {0, options.trees}, quiet, std::move(stop)));
  TrainedForests trained;
  trained.all.frames = CountDrawnFrames(dataset, options, first_frames);
  trained.all.samples = grown.samples;
  trained.all.forest = QuantizeForest(std::move(grown.trees));
  if (!first_frames.empty()) {
    trained.first = QuantizeForest(std::move(grown.first));
  }
  return trained;
}

absl::StatusOr<TrainedForest> TrainForest(
    const dataset::Dataset& dataset, const camera::RgbdCalibration& calibration,
    const TrainingOptions& options, bool quiet, std::stop_token stop) {
  TL_ASSIGN_OR_RETURN(
      TrainedForests trained,
      TrainForests(dataset, calibration, options, {}, quiet, std::move(stop)));
  return std::move(trained.all);
}

}  // namespace treeline::training
