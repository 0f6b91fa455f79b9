#include "server/core/training/frame_samples.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"

namespace treeline {
namespace {

// Apart from the random streams of frames and nodes.
constexpr uint64_t kSampleStream = 0x736d700000000000;

}  // namespace

std::vector<int> UsableFrames(const Dataset& dataset) {
  std::vector<int> usable;
  for (int i = 0; i < dataset.size(); ++i) {
    const DatasetFrame& frame = dataset.frame(i);
    if (frame.world_from_camera && !frame.depth_path.empty()) {
      usable.push_back(i);
    }
  }
  return usable;
}

absl::Status CheckSizes(const DatasetFrame& entry, const Frame& frame,
                        const RgbdCalibration& calibration) {
  if (frame.color.width == calibration.color.width() &&
      frame.color.height == calibration.color.height() &&
      frame.depth->width == calibration.depth.width() &&
      frame.depth->height == calibration.depth.height()) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      entry.color_path, ": colour ", frame.color.width, " x ",
      frame.color.height, " and depth ", frame.depth->width, " x ",
      frame.depth->height, ", but the calibration is for ",
      calibration.color.width(), " x ", calibration.color.height(), " and ",
      calibration.depth.width(), " x ", calibration.depth.height()));
}

TreeSamples DrawTreeSamples(const DepthGeometry& geometry, const Frame& frame,
                            const PlanarImage& image,
                            const Rigid3& world_from_camera,
                            const TrainingOptions& options, int tree,
                            int frame_index) {
  RgbdSamples drawn;
  DrawSamples(
      geometry, *frame.depth, options.samples_per_frame,
      Random(options.seed, kSampleStream + (static_cast<uint64_t>(tree) << 32) +
                               static_cast<uint64_t>(frame_index)),
      drawn);
  TreeSamples samples;
  samples.x.assign(drawn.x.begin(), drawn.x.end());
  samples.y.assign(drawn.y.begin(), drawn.y.end());
  samples.inverse_depth_q12 = drawn.inverse_depth_q12;
  if (!options.depth_adaptive) {
    std::ranges::fill(samples.inverse_depth_q12,
                      NoDepthQ12(MeanFocal_px(geometry.calibration().color)));
  }
  for (const Vec3& point : drawn.point) {
    const Vec3 in_world = world_from_camera * point;
    samples.point_in_world.push_back({static_cast<float>(in_world.x),
                                      static_cast<float>(in_world.y),
                                      static_cast<float>(in_world.z)});
  }
  samples.descriptor.resize(drawn.size());
  ComputeWht(image, drawn.x, drawn.y, samples.descriptor);
  return samples;
}

}  // namespace treeline
