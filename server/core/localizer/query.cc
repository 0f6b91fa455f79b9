#include "server/core/localizer/query.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "server/core/keyframes/keyframe_features.h"
#include "server/core/localizer/parameters.h"

namespace treeline::localizer {
namespace {

absl::Status CheckSize(absl::string_view what, int width, int height,
                       const camera::Camera& camera) {
  if (width == camera.width() && height == camera.height()) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("the ", what, " image has ", width, " x ", height,
                   " pixels, but its camera is calibrated for ", camera.width(),
                   " x ", camera.height()));
}

bool UsesDepth(const image::Frame& frame, DepthUse depth_use) {
  return depth_use == DepthUse::kRequired ||
         (depth_use == DepthUse::kWhereGiven && frame.depth.has_value());
}

}  // namespace

camera::RgbdCalibration QueryCalibration(const image::Frame& frame,
                                         const forest::ModelInfo& info,
                                         DepthUse depth_use) {
  camera::RgbdCalibration calibration = info.calibration;
  if (!frame.calibration) return calibration;
  if (!UsesDepth(frame, depth_use)) {
    calibration.color = frame.calibration->color;
  } else {
    calibration = *frame.calibration;
    calibration.pose_sensor = info.calibration.pose_sensor;
  }
  return calibration;
}

absl::Status CheckFrame(const image::Frame& frame,
                        const camera::RgbdCalibration& calibration,
                        DepthUse depth_use, absl::string_view method) {
  TL_RETURN_IF_ERROR(CheckSize("colour", frame.color.width, frame.color.height,
                               calibration.color));
  if (depth_use == DepthUse::kRequired && !frame.depth) {
    return absl::InvalidArgumentError(
        absl::StrCat("this scene's method (", method,
                     ") needs a depth image, and the frame has none"));
  }
  if (!UsesDepth(frame, depth_use)) return absl::OkStatus();
  return CheckSize("depth", frame.depth->width, frame.depth->height,
                   calibration.depth);
}

Query::Query(const image::Frame& frame, camera::RgbdCalibration calibration,
             DepthUse depth_use, const LocalizeOptions& options,
             QueryScratch& scratch)
    : frame_(frame),
      depth_(UsesDepth(frame, depth_use) ? &*frame.depth : nullptr),
      options_(options),
      scratch_(scratch) {
  set_calibration(std::move(calibration));
}

void Query::set_calibration(camera::RgbdCalibration calibration) {
  calibration_ = std::move(calibration);
  pixel_ = 1 / camera::MeanFocal_px(calibration_.color);
}

absl::Status Query::CheckStop() const {
  return stop().stop_requested()
             ? absl::CancelledError("the query was cancelled")
             : absl::OkStatus();
}

const features::PlanarImage& Query::image() {
  if (!std::exchange(has_image_, true)) scratch_.image.Assign(color());
  return scratch_.image;
}

const features::GrayPyramid& Query::pyramid() {
  if (!std::exchange(has_pyramid_, true)) scratch_.pyramid.Assign(image());
  return scratch_.pyramid;
}

const features::SiftFeatures& Query::keyframe_features(
    features::SiftKind kind) {
  if (!keyframe_features_) {
    const int count = kind == features::SiftKind::kFast ? kMaxFastQueryFeatures
                                                        : kMaxQueryFeatures;
    keyframe_features_ = keyframes::ExtractKeyframeSift(
        color(), kind,
        {.max_features = count, .least_reduction = feature_reduction_},
        scratch_.fast_sift);
  }
  return *keyframe_features_;
}

}  // namespace treeline::localizer
