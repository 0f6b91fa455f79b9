// One question on its way through the pipeline.
#ifndef SERVER_CORE_LOCALIZER_QUERY_H_
#define SERVER_CORE_LOCALIZER_QUERY_H_

#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/camera/rgbd_calibration.h"
#include "common/image/frame.h"
#include "server/core/features/fast_sift.h"
#include "server/core/features/gray_pyramid.h"
#include "server/core/features/line_segments.h"
#include "server/core/features/planar_image.h"
#include "server/core/features/rgbd_samples.h"
#include "server/core/features/sift_extractor.h"
#include "server/core/features/sift_features.h"
#include "server/core/forest/backtracking.h"
#include "server/core/forest/model_info.h"
#include "server/core/localizer/localizer.h"

namespace treeline::localizer {

// Random streams of a query, for Random(seed, stream).
inline constexpr uint64_t kSampleStream = 1;
inline constexpr uint64_t kLineStream = 3;
inline constexpr uint64_t kOrderStream = 4;
// ... and for the seeds of RANSAC.
inline constexpr uint64_t kForestRansacStream = 2;
inline constexpr uint64_t kKeyframeRansacStream = 3;

// Working memory of one query.
struct QueryScratch {
  features::PlanarImage image;
  features::GrayPyramid pyramid;
  features::RgbdSamples samples;
  features::LinePoints segments;     // all points on line segments
  features::LinePoints line_points;  // those sampled
  std::vector<features::WhtDescriptor> descriptors;
  features::FastSift fast_sift;
  features::SiftExtractor sift;
  forest::BacktrackingScratch backtracking;
  std::vector<forest::LeafMatch> matches;
};

// The cameras of a frame: its own where it has some, else the scene's. Poses
// are of the scene's pose sensor. Without depth that is used, of all that a
// frame has of its own its colour camera counts.
camera::RgbdCalibration QueryCalibration(const image::Frame& frame,
                                         const forest::ModelInfo& info,
                                         DepthUse depth_use);

// INVALID_ARGUMENT unless the images that are used are there and have the
// sizes of their cameras; `method` is named in the message.
absl::Status CheckFrame(const image::Frame& frame,
                        const camera::RgbdCalibration& calibration,
                        DepthUse depth_use, absl::string_view method);

// The frame, what is computed from it for whichever stage asks first, and the
// time spent. Of one thread. All that it is made of must outlive it.
class Query {
 public:
  // `frame` has passed CheckFrame.
  Query(const image::Frame& frame, camera::RgbdCalibration calibration,
        DepthUse depth_use, const LocalizeOptions& options,
        QueryScratch& scratch);

  const image::ColorImage& color() const { return frame_.color; }
  // Null where there is none or the method ignores it.
  const image::DepthImage* depth() const { return depth_; }
  const camera::RgbdCalibration& calibration() const { return calibration_; }
  const camera::Camera& camera() const { return calibration_.color; }
  // Nobody stated the colour camera.
  bool is_camera_assumed() const { return frame_.is_camera_assumed; }
  // One pixel of the colour camera in units of its rays.
  double pixel() const { return pixel_; }
  // Other cameras for the same frame, of the same sizes: what does not depend
  // on them is kept.
  void set_calibration(camera::RgbdCalibration calibration);
  // The stated focal length may be a guess: it has to be confirmed by features.
  bool is_focal_doubtful() const { return is_focal_doubtful_; }
  void set_focal_doubtful() { is_focal_doubtful_ = true; }
  // Another focal length than the stated one may be the answer's.
  bool is_focal_open() const { return is_focal_open_; }
  void set_focal_open(bool open) { is_focal_open_ = open; }
  // Another lens may be, too.
  bool is_lens_open() const { return is_lens_open_; }
  void set_lens_open(bool open) { is_lens_open_ = open; }
  // The scale of depth is still open: where one explains what is seen better,
  // depth is measured anew by it.
  bool is_depth_scale_open() const { return is_depth_scale_open_; }
  void set_depth_scale_open(bool open) { is_depth_scale_open_ = open; }
  // See FeatureReduction; counts for features that are sought afterwards.
  void set_feature_reduction(int reduction) { feature_reduction_ = reduction; }
  const LocalizeOptions& options() const { return options_; }
  uint64_t seed() const { return options_.seed; }
  const std::stop_token& stop() const { return options_.stop; }
  // CANCELLED once the query's stop was requested.
  absl::Status CheckStop() const;

  const features::PlanarImage& image();
  const features::GrayPyramid& pyramid();
  // As keyframes store them; see ExtractKeyframeSift. Of one kind a query.
  const features::SiftFeatures& keyframe_features(features::SiftKind kind);

  QueryScratch& scratch() { return scratch_; }
  LocalizeTimings& timings() { return timings_; }

 private:
  const image::Frame& frame_;
  camera::RgbdCalibration calibration_;
  const image::DepthImage* const depth_;
  const LocalizeOptions& options_;
  double pixel_ = 0;
  bool is_focal_doubtful_ = false;
  bool is_focal_open_ = false;
  bool is_lens_open_ = false;
  bool is_depth_scale_open_ = false;
  int feature_reduction_ = 1;
  QueryScratch& scratch_;
  bool has_image_ = false;
  bool has_pyramid_ = false;
  std::optional<features::SiftFeatures> keyframe_features_;
  LocalizeTimings timings_;
};

// Adds the time that it lives to a stage's.
class StageTimer {
 public:
  explicit StageTimer(double& stage_ms)
      : stage_ms_(stage_ms), start_(base::SteadyClock().Now()) {}
  ~StageTimer() {
    stage_ms_ += base::MillisecondsBetween(start_, base::SteadyClock().Now());
  }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  double& stage_ms_;
  const base::MonotonicTime start_;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_QUERY_H_
