#include "server/core/training/pose_watch.h"

#include <optional>
#include <utility>

#include "common/base/status_macros.h"
#include "server/core/training/pose_convention.h"

namespace treeline::training {
namespace {

constexpr size_t kFirstLook = 20;
constexpr size_t kFrames = 60;
constexpr size_t kLongestStride = 16;

}  // namespace

PoseWatch::PoseWatch(std::string name,
                     const camera::RgbdCalibration& calibration, int threads)
    : name_(std::move(name)), calibration_(calibration), threads_(threads) {}

absl::Status PoseWatch::Add(const image::DepthImage& depth,
                            const geometry::Rigid3& world_from_sensor) {
  if (stride_ > kLongestStride || came_++ % stride_ != 0 ||
      depth.width != calibration_.depth.width() ||
      depth.height != calibration_.depth.height()) {
    return absl::OkStatus();
  }
  frames_.push_back({depth, world_from_sensor});
  if (stride_ == 1 && frames_.size() == kFirstLook) return Check();
  if (frames_.size() < kFrames) return absl::OkStatus();
  TL_RETURN_IF_ERROR(Check());
  stride_ *= 2;
  std::vector<PosedDepth> kept;
  for (size_t i = 0; i < frames_.size() && stride_ <= kLongestStride; i += 2) {
    kept.push_back(std::move(frames_[i]));
  }
  frames_ = std::move(kept);
  return absl::OkStatus();
}

absl::Status PoseWatch::Check() const {
  const std::optional<OtherConvention> other =
      FindOtherConvention(frames_, calibration_, threads_);
  return other ? ConventionError(name_, *other) : absl::OkStatus();
}

}  // namespace treeline::training
