// The points of one view, small enough to keep them all.
#ifndef NAV_AGENT_FUSION_COMPACT_CLOUD_H_
#define NAV_AGENT_FUSION_COMPACT_CLOUD_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "common/camera/camera.h"
#include "common/geometry/vector3.h"
#include "common/image/image.h"
#include "nav_agent/fusion/fusion_options.h"

namespace treeline::fusion {

struct CompactPoint {
  int16_t x = 0;
  int16_t y = 0;
  int16_t z = 0;
  // So much of the ray to it is surely free, in parts of kWholeRay.
  uint16_t free = kWholeRay;
  static constexpr uint16_t kWholeRay = 65535;

  constexpr bool operator==(const CompactPoint&) const = default;
};

// Points in the sensor's frame, in units: point_in_sensor = unit_m * (x, y, z).
// Rays from the sensor's origin end at the first `hits` points; up to the other
// points all is free, and nothing is known of what comes there.
struct CompactCloud {
  double unit_m = 0;
  size_t hits = 0;
  std::vector<CompactPoint> points;

  bool operator==(const CompactCloud&) const = default;
  int64_t bytes() const {
    return static_cast<int64_t>(points.capacity() * sizeof(CompactPoint));
  }
};

// The cloud of a depth image, in the camera's frame: one point for each cell of
// pixel_step squared pixels, the mean of those that agree with its middle
// (within 1 cm + 4 mm/m^2 z^2, three deviations of the sensor's noise). A cell
// gives none if fewer than a quarter of its pixels, or than half of those that
// are measured, agree. Then statistical outlier removal (thesis 6.3.1); see
// FusionOptions. INVALID_ARGUMENT if image and camera differ in size, or the
// image's unit is not in [1e-5, 0.1] m.
absl::StatusOr<CompactCloud> MakeDepthCloud(const image::DepthImage& depth,
                                            const camera::Camera& camera,
                                            const FusionOptions& options);

// The cloud of points in the sensor's frame (m), for instance of a laser scan.
// Points that are not finite are left out.
CompactCloud MakePointCloud(std::span<const geometry::Vec3> points_in_sensor,
                            const FusionOptions& options);

}  // namespace treeline::fusion

#endif  // NAV_AGENT_FUSION_COMPACT_CLOUD_H_
