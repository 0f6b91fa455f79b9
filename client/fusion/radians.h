// Options state angles in degrees, everything else is in radians.
#ifndef CLIENT_FUSION_RADIANS_H_
#define CLIENT_FUSION_RADIANS_H_

#include <numbers>

namespace treeline::drift {

constexpr double Radians(double angle_deg) {
  return angle_deg * std::numbers::pi / 180;
}

constexpr double Degrees(double angle_rad) {
  return angle_rad * 180 / std::numbers::pi;
}

}  // namespace treeline::drift

#endif  // CLIENT_FUSION_RADIANS_H_
