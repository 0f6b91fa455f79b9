#include "simulation/simulator/tour_driver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/geometry/planar_pose.h"
#include "common/geometry/rigid2.h"

namespace treeline::simulator {
namespace {

// A robot that looks further away than the first from where it should go turns
// on the spot, until it looks there within the second.
constexpr double kTurnFrom_rad = 0.7;
constexpr double kTurnUntil_rad = 0.15;
constexpr double kTurnGain_hz = 2;
// So far ahead the nearest point of the line is looked for.
constexpr double kWindow_m = 1.0;
constexpr double kWindowStep_m = 0.02;
// A look around that does not get on is given up after so many commands (50 ms
// each): something is in the way.
constexpr double kNoTurn_rad = 0.002;
constexpr int kStuckCommands = 40;
// In curves the robot takes no more than this to the side.
constexpr double kLateral_mps2 = 0.4;

}  // namespace

absl::Status TourOptions::Validate() const {
  if (!(speed_mps > 0 && speed_mps <= 5)) {
    return absl::InvalidArgumentError(
        absl::StrCat("a tour at ", speed_mps, " m/s; up to 5 is possible"));
  }
  if (!(look_ahead_m >= 0.1 && look_ahead_m <= 5) ||
      !(arrival_m > 0 && arrival_m <= 5) ||
      !(give_way_m >= 0 && give_way_m <= 10)) {
    return absl::InvalidArgumentError(
        "a tour looks 0.1 to 5 m ahead and arrives within 5 m");
  }
  if (!(look_around_every_m >= 0 && look_around_every_m <= 100) ||
      !(look_around_radps > 0 && look_around_radps <= 3)) {
    return absl::InvalidArgumentError(
        "a survey looks around every 0 to 100 m, at up to 3 rad/s");
  }
  return absl::OkStatus();
}

TourDriver::TourDriver(std::vector<geometry::Vec3> corners,
                       const TourOptions& options)
    : corners_(std::move(corners)), options_(options) {
  if (corners_.empty()) corners_.push_back({});
  if (options_.repeats && !(corners_.front() == corners_.back())) {
    corners_.push_back(corners_.front());
  }
  starts_.push_back(0);
  for (size_t i = 1; i < corners_.size(); ++i) {
    starts_.push_back(starts_.back() +
                      geometry::Norm(corners_[i] - corners_[i - 1]));
  }
}

geometry::Vec3 TourDriver::PointAt(double along_m) const {
  double along = along_m;
  if (options_.repeats && length_m() > 0) along = std::fmod(along, length_m());
  const auto after = std::upper_bound(starts_.begin(), starts_.end(), along);
  if (after == starts_.end()) return corners_.back();
  const size_t i = static_cast<size_t>(after - starts_.begin());
  const double t = (along - starts_[i - 1]) / (starts_[i] - starts_[i - 1]);
  return corners_[i - 1] + t * (corners_[i] - corners_[i - 1]);
}

void TourDriver::Advance(geometry::Vec3 position) {
  double best_m = std::numeric_limits<double>::infinity();
  double best_along_m = along_m_;
  for (double ahead_m = 0; ahead_m <= kWindow_m; ahead_m += kWindowStep_m) {
    const double distance_m =
        geometry::Norm(PointAt(along_m_ + ahead_m) - position);
    if (distance_m < best_m - 1e-9) {
      best_m = distance_m;
      best_along_m = along_m_ + ahead_m;
    }
  }
  along_m_ = best_along_m;
  if (options_.repeats && length_m() > 0 && along_m_ >= length_m()) {
    along_m_ -= length_m();
    ++rounds_;
  }
  along_m_ = std::min(along_m_, length_m());
}

void TourDriver::JoinNearest(geometry::Vec3 position) {
  double best_m = std::numeric_limits<double>::infinity();
  for (double along_m = 0; along_m <= length_m(); along_m += kWindowStep_m) {
    const double distance_m = geometry::Norm(PointAt(along_m) - position);
    if (distance_m >= best_m) continue;
    best_m = distance_m;
    along_m_ = along_m;
  }
}

bool TourDriver::LooksAround(double yaw_rad) {
  if (options_.look_around_every_m <= 0) return false;
  if (!is_looking_) {
    if (progress_m() < next_look_m_) return false;
    next_look_m_ = progress_m() + options_.look_around_every_m;
    is_looking_ = true;
    looked_rad_ = 0;
    stuck_ = 0;
    last_yaw_rad_ = yaw_rad;
    return true;
  }
  const double turned_rad =
      geometry::NormalizedAngle_rad(yaw_rad - last_yaw_rad_);
  last_yaw_rad_ = yaw_rad;
  looked_rad_ += turned_rad;
  stuck_ = std::abs(turned_rad) < kNoTurn_rad ? stuck_ + 1 : 0;
  is_looking_ = looked_rad_ < 2 * std::numbers::pi && stuck_ < kStuckCommands;
  return is_looking_;
}

core::VelocityCommand TourDriver::CommandAt(
    const geometry::Rigid3& world_from_base) {
  if (is_done_) return {};
  Advance(world_from_base.translation);
  if (!options_.repeats && along_m_ > length_m() - kWindow_m &&
      geometry::Norm(corners_.back() - world_from_base.translation) <
          options_.arrival_m) {
    is_done_ = true;
    return {};
  }
  if (LooksAround(geometry::Yaw_rad(world_from_base.rotation))) {
    return {.yaw_rate_radps = options_.look_around_radps};
  }
  const geometry::Vec3 target = PointAt(along_m_ + options_.look_ahead_m);
  const geometry::Vec3 in_base = world_from_base.Inverse() * target;
  const double bearing_rad = std::atan2(in_base.y, in_base.x);
  if (std::abs(bearing_rad) > kTurnFrom_rad) turns_ = true;
  if (std::abs(bearing_rad) < kTurnUntil_rad) turns_ = false;
  if (turns_) return {.yaw_rate_radps = kTurnGain_hz * bearing_rad};
  const double squared = in_base.x * in_base.x + in_base.y * in_base.y;
  const double curvature = squared > 1e-6 ? 2 * in_base.y / squared : 0;
  double speed_mps = options_.speed_mps;
  if (std::abs(curvature) > 1e-6) {
    speed_mps =
        std::min(speed_mps, std::sqrt(kLateral_mps2 / std::abs(curvature)));
  }
  if (!options_.repeats) {
    // Slower towards the end, but never so slow that it is not reached.
    speed_mps = std::min(speed_mps, std::max(0.1, length_m() - along_m_));
  }
  return {.forward_mps = speed_mps, .yaw_rate_radps = speed_mps * curvature};
}

}  // namespace treeline::simulator
