#include "simulation/recorder/walk.h"

#include <cmath>
#include <numbers>

#include "common/base/random.h"

namespace treeline::recorder {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRound_s = 15;

}  // namespace

Walk::Walk(const worlds::WalkArea& area, uint64_t seed) : area_(area) {
  base::Random random(seed, 0x3a1c);
  for (double& phase : phases_) phase = random.NextUnit();
  direction_ = random.NextBelow(2) == 0 ? 1 : -1;
}

double Walk::Wave(int k, double period_s, double time_s) const {
  return std::sin(2 * kPi *
                  (time_s / period_s + phases_[static_cast<size_t>(k)]));
}

geometry::Rigid3 Walk::WorldFromCameraAt(double t) const {
  // Around an ellipse that widens and narrows; periods have no common multiple
  // worth speaking of, so that no round is like another.
  const double angle = direction_ * (2 * kPi * (t / kRound_s + phases_[0]) +
                                     0.5 * Wave(1, 11.3, t));
  const double reach = 0.72 + 0.28 * Wave(2, 17.9, t);
  const double x_m =
      area_.center_x_m + reach * area_.half_x_m * std::cos(angle);
  const double y_m =
      area_.center_y_m + reach * area_.half_y_m * std::sin(angle);
  const double z_m = 1.4 + 0.14 * Wave(3, 7.1, t) + 0.06 * Wave(4, 3.1, t);

  // Mostly across the room, swinging towards the walls on either side.
  const double yaw_rad = angle + kPi + 0.75 * Wave(5, 9.7, t) +
                         0.45 * Wave(6, 6.1, t) + 0.06 * Wave(7, 1.7, t);
  const double pitch_rad =  // up
      -0.20 + 0.17 * Wave(8, 8.3, t) + 0.05 * Wave(9, 2.3, t);
  const double roll_rad = 0.05 * Wave(10, 5.3, t) + 0.02 * Wave(11, 1.9, t);

  const geometry::Vec3 forward = {std::cos(pitch_rad) * std::cos(yaw_rad),
                                  std::cos(pitch_rad) * std::sin(yaw_rad),
                                  std::sin(pitch_rad)};
  const geometry::Vec3 right = Normalized(Cross(forward, {0, 0, 1}));
  const geometry::Vec3 down = Cross(forward, right);
  const geometry::Mat3 axes{{right.x, down.x, forward.x, right.y, down.y,
                             forward.y, right.z, down.z, forward.z}};
  return {geometry::Rotation3::FromMatrix(axes) *
              geometry::Rotation3::FromAxisAngle({0, 0, roll_rad}),
          {x_m, y_m, z_m}};
}

}  // namespace treeline::recorder
