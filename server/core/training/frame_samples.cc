#include "server/core/training/frame_samples.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"
#include "server/core/features/gray_pyramid.h"

namespace treeline::training {
namespace {

// Apart from the random streams of frames and nodes.
constexpr uint64_t kSampleStream = 0x736d700000000000;

}  // namespace

std::vector<int> UsableFrames(const dataset::Dataset& dataset) {
  std::vector<int> usable;
  for (int i = 0; i < dataset.size(); ++i) {
    const dataset::DatasetFrame& frame = dataset.frame(i);
    if (frame.world_from_camera && !frame.depth_path.empty()) {
      usable.push_back(i);
    }
  }
  return usable;
}

absl::Status CheckSizes(absl::string_view name, const image::Frame& frame,
                        const camera::RgbdCalibration& calibration) {
  if (frame.color.width == calibration.color.width() &&
      frame.color.height == calibration.color.height() &&
      frame.depth->width == calibration.depth.width() &&
      frame.depth->height == calibration.depth.height()) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      name, ": colour ", frame.color.width, " x ", frame.color.height,
      " and depth ", frame.depth->width, " x ", frame.depth->height,
      ", but the calibration is for ", calibration.color.width(), " x ",
      calibration.color.height(), " and ", calibration.depth.width(), " x ",
      calibration.depth.height()));
}

FrameSampler::FrameSampler(const features::DepthGeometry& geometry,
                           const image::Frame& frame,
                           const features::PlanarImage& image,
                           const geometry::Rigid3& world_from_camera,
                           const TrainingOptions& options, int frame_index)
    : geometry_(geometry),
      frame_(frame),
      image_(image),
      world_from_camera_(world_from_camera),
      options_(options),
      frame_index_(frame_index) {
  if (!options.line_points) return;
  features::GrayPyramid pyramid;
  pyramid.Assign(image);
  features::LiftSegments(geometry, *frame.depth,
                         features::DetectLineSegments(pyramid, {}), {}, lines_);
}

TreeSamples FrameSampler::Draw(int tree) const {
  const base::Random random(
      options_.seed, kSampleStream + (static_cast<uint64_t>(tree) << 32) +
                         static_cast<uint64_t>(frame_index_));
  features::RgbdSamples drawn;
  if (options_.line_points) {
    features::LinePoints on_lines;
    features::DrawLinePoints(lines_, options_.samples_per_frame, random,
                             on_lines);
    drawn = std::move(on_lines.samples);
  } else {
    features::DrawSamples(geometry_, *frame_.depth, options_.samples_per_frame,
                          random, drawn);
  }
  TreeSamples samples;
  samples.x.assign(drawn.x.begin(), drawn.x.end());
  samples.y.assign(drawn.y.begin(), drawn.y.end());
  samples.inverse_depth_q12 = drawn.inverse_depth_q12;
  if (!options_.depth_adaptive) {
    std::ranges::fill(samples.inverse_depth_q12,
                      features::NoDepthQ12(
                          camera::MeanFocal_px(geometry_.calibration().color)));
  }
  for (const geometry::Vec3& point : drawn.point) {
    const geometry::Vec3 in_world = world_from_camera_ * point;
    samples.point_in_world.push_back({static_cast<float>(in_world.x),
                                      static_cast<float>(in_world.y),
                                      static_cast<float>(in_world.z)});
  }
  samples.descriptor.resize(drawn.size());
  features::ComputeWht(image_, drawn.x, drawn.y, samples.descriptor);
  return samples;
}

}  // namespace treeline::training
