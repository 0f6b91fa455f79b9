// Training samples of one frame.
#ifndef SERVER_CORE_TRAINING_FRAME_SAMPLES_H_
#define SERVER_CORE_TRAINING_FRAME_SAMPLES_H_

#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "common/dataset/dataset.h"
#include "common/geometry/rigid3.h"
#include "server/core/features/line_segments.h"
#include "server/core/features/planar_image.h"
#include "server/core/features/rgbd_samples.h"
#include "server/core/training/training_options.h"
#include "server/core/training/tree_grower.h"

namespace treeline::training {

// Frames that have a pose and depth, in ascending order.
std::vector<int> UsableFrames(const dataset::Dataset& dataset);

// INVALID_ARGUMENT, naming the frame, unless the images have the sizes that the
// calibration is for.
absl::Status CheckSizes(absl::string_view name, const image::Frame& frame,
                        const camera::RgbdCalibration& calibration);

// Draws samples of frame number `frame_index`, of which `image` is the colour:
// from all of it, or with options.line_points from its line segments, which are
// looked for once. All arguments must outlive it.
class FrameSampler {
 public:
  FrameSampler(const features::DepthGeometry& geometry,
               const image::Frame& frame, const features::PlanarImage& image,
               const geometry::Rigid3& world_from_camera,
               const TrainingOptions& options, int frame_index);

  // The samples that `tree` draws; TreeSamples::frame is left empty. Depends on
  // options.seed, the tree and the frame's number alone.
  TreeSamples Draw(int tree) const;

 private:
  const features::DepthGeometry& geometry_;
  const image::Frame& frame_;
  const features::PlanarImage& image_;
  const geometry::Rigid3& world_from_camera_;
  const TrainingOptions& options_;
  const int frame_index_;
  features::LinePoints lines_;
};

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_FRAME_SAMPLES_H_
