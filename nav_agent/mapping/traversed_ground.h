// How high the ground is where the robot has driven.
#ifndef NAV_AGENT_MAPPING_TRAVERSED_GROUND_H_
#define NAV_AGENT_MAPPING_TRAVERSED_GROUND_H_

#include <cstdint>
#include <limits>
#include <span>
#include <unordered_map>
#include <vector>

#include "common/geometry/rigid2.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::mapping {

// Places on the way, by square cells as large as what is asked for.
class TraversedGround {
 public:
  // Ground is as high as at a place that was driven over up to reach_m from
  // there, seen from above (m, above 0).
  explicit TraversedGround(double reach_m) : reach_m_(reach_m) {}

  void Add(geometry::Vec3 base_in_map);
  void Clear();
  bool IsLevel(double within_m) const {
    return !(highest_m_ - lowest_m_ > within_m);
  }

  // Whether there is ground near a point, on any floor, that is at most
  // margin_m higher or lower.
  bool IsNear(geometry::Vec3 point_in_map, double margin_m) const;

 private:
  int64_t CellOf(int32_t x, int32_t y) const {
    return (static_cast<int64_t>(x) << 32) ^ static_cast<uint32_t>(y);
  }
  int32_t IndexOf(double at_m) const;

  double reach_m_;
  double lowest_m_ = std::numeric_limits<double>::infinity();
  double highest_m_ = -std::numeric_limits<double>::infinity();
  std::unordered_map<int64_t, std::vector<geometry::Vec3>> places_;
};

// The ranges of a scan without those that end on ground: they become
// kInvalidRange. map_from_laser is of the first beam.
std::vector<float> WithoutGround(std::span<const float> ranges_m,
                                 const core::RangeSensorInfo& laser,
                                 const geometry::Rigid3& map_from_laser,
                                 const TraversedGround& ground,
                                 double margin_m);

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_TRAVERSED_GROUND_H_
