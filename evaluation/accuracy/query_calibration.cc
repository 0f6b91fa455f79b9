#include "evaluation/accuracy/query_calibration.h"

#include <cmath>

namespace treeline::accuracy {
namespace {

bool HasOtherSize(const camera::Camera& a, const camera::Camera& b) {
  return a.width() != b.width() || a.height() != b.height();
}

}  // namespace

bool MayBeOneCamera(const camera::Camera& a, const camera::Camera& b) {
  constexpr double kNear = 0.03;
  const auto is_near = [](double x, double y, double size) {
    return std::abs(x - y) <= kNear * size;
  };
  return !HasOtherSize(a, b) && is_near(a.fx(), b.fx(), b.fx()) &&
         is_near(a.fy(), b.fy(), b.fy()) &&
         is_near(a.cx(), b.cx(), b.width()) &&
         is_near(a.cy(), b.cy(), b.height());
}

std::optional<camera::RgbdCalibration> QueryCalibration(
    const dataset::Dataset& dataset, const dataset::DatasetOptions& options,
    const camera::RgbdCalibration& scene_calibration) {
  // Its frames say themselves what they were taken with.
  if (dataset.structure() != nullptr) return std::nullopt;
  const camera::RgbdCalibration& recorded = dataset.calibration();
  camera::RgbdCalibration query = scene_calibration;
  if (dataset.depth_is_registered()) {
    if (MayBeOneCamera(recorded.color, scene_calibration.color)) {
      return std::nullopt;
    }
    query.color = recorded.color;
    query.depth = recorded.depth;
    query.color_from_depth = recorded.color_from_depth;
    return query;
  }
  if (HasOtherSize(recorded.color, query.color) ||
      HasOtherSize(recorded.depth, query.depth)) {
    // Another device: the scene's cameras say nothing of it.
    query.color = recorded.color;
    query.depth = recorded.depth;
    if (dataset.states_its_cameras()) {
      query.color_from_depth = recorded.color_from_depth;
    }
    return query;
  }
  if (!options.color_camera.empty() &&
      !MayBeOneCamera(recorded.color, query.color)) {
    query.color = recorded.color;
  }
  if (!options.depth_camera.empty() &&
      !MayBeOneCamera(recorded.depth, query.depth)) {
    query.depth = recorded.depth;
  }
  if (query == scene_calibration) return std::nullopt;
  return query;
}

}  // namespace treeline::accuracy
