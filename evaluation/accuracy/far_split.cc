#include "evaluation/accuracy/far_split.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "common/base/random.h"

namespace treeline::accuracy {
namespace {

// Of `near`, from the middle of a hole.
constexpr double kHoleRadius = 0.5;

std::vector<int> FramesWithPose(const FramePoses& poses) {
  std::vector<int> frames;
  for (size_t i = 0; i < poses.size(); ++i) {
    if (poses[i]) frames.push_back(static_cast<int>(i));
  }
  return frames;
}

// Frames for training, and holes cut out of them.
class HoleCutter {
 public:
  HoleCutter(const FramePoses& poses, const HoleOptions& options)
      : poses_(poses),
        options_(options),
        frames_(FramesWithPose(poses)),
        uses_(poses.size(), Use::kNone) {
    for (const int frame : frames_) UseOf(frame) = Use::kTraining;
  }

  FarSplit Cut() {
    for (const int middle : InRandomOrder()) {
      if (Count(Use::kTest) >= ShareOfFrames(options_.test_share)) break;
      if (UseOf(middle) == Use::kTraining) TryHole(middle);
    }
    return {Frames(Use::kTraining), Frames(Use::kTest)};
  }

 private:
  enum class Use { kNone, kTraining, kTooNear, kTest };

  Use& UseOf(int frame) { return uses_[static_cast<size_t>(frame)]; }

  double Gap(int a, int b) const {
    return ViewGap(*poses_[static_cast<size_t>(a)],
                   *poses_[static_cast<size_t>(b)], options_.near);
  }

  double ShareOfFrames(double share) const {
    return share * static_cast<double>(frames_.size());
  }

  double Count(Use use) const {
    return static_cast<double>(std::ranges::count(uses_, use));
  }

  std::vector<int> Frames(Use use) {
    std::vector<int> frames;
    for (const int frame : frames_) {
      if (UseOf(frame) == use) frames.push_back(frame);
    }
    return frames;
  }

  std::vector<int> InRandomOrder() const {
    std::vector<int> order = frames_;
    base::Random random(options_.seed, 0);
    for (size_t i = order.size(); i > 1; --i) {
      std::swap(order[i - 1],
                order[random.NextBelow(static_cast<uint32_t>(i))]);
    }
    return order;
  }

  // Unless too little were left for training.
  void TryHole(int middle) {
    const std::vector<Use> before = uses_;
    std::vector<int> hole;
    for (const int frame : frames_) {
      if (UseOf(frame) == Use::kTest || Gap(middle, frame) > kHoleRadius) {
        continue;
      }
      hole.push_back(frame);
      UseOf(frame) = Use::kTest;
    }
    for (const int frame : frames_) {
      if (UseOf(frame) != Use::kTraining) continue;
      const bool near = std::ranges::any_of(
          hole, [&](int test) { return Gap(test, frame) <= 1; });
      if (near) UseOf(frame) = Use::kTooNear;
    }
    if (Count(Use::kTraining) < ShareOfFrames(options_.min_training)) {
      uses_ = before;
    }
  }

  const FramePoses& poses_;
  const HoleOptions& options_;
  const std::vector<int> frames_;
  std::vector<Use> uses_;
};

}  // namespace

std::vector<int> FramesBeyond(
    const FramePoses& poses,
    const std::vector<geometry::Rigid3>& training_poses,
    const ViewLimits& near) {
  std::vector<int> beyond;
  for (const int frame : FramesWithPose(poses)) {
    const geometry::Rigid3& pose = *poses[static_cast<size_t>(frame)];
    if (ViewGap(pose, training_poses, near) > 1) beyond.push_back(frame);
  }
  return beyond;
}

FarSplit SplitAfterFirst(const FramePoses& poses, int count,
                         const ViewLimits& near) {
  FarSplit split;
  std::vector<geometry::Rigid3> training_poses;
  for (const int frame : FramesWithPose(poses)) {
    if (static_cast<int>(split.training.size()) == count) break;
    split.training.push_back(frame);
    training_poses.push_back(*poses[static_cast<size_t>(frame)]);
  }
  // None of the training frames is beyond itself.
  split.test = FramesBeyond(poses, training_poses, near);
  return split;
}

FarSplit SplitByHoles(const FramePoses& poses, const HoleOptions& options) {
  return HoleCutter(poses, options).Cut();
}

}  // namespace treeline::accuracy
