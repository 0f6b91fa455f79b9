// Active localization (thesis 7.2.3): to where a lost robot should turn so that
// the next picture is likely to say where it is.
#ifndef NAV_AGENT_BEHAVIOR_NEXT_BEST_VIEW_H_
#define NAV_AGENT_BEHAVIOR_NEXT_BEST_VIEW_H_

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "common/geometry/rigid2.h"

namespace treeline::behavior {

// The probability that a picture localizes, for each of 24 directions around
// where the robot stands, in the frame of its odometry. It begins with what the
// laser sees in the camera's field of view: walls near by fill the picture with
// little, open space without depth is little better, and 1.5 to 6 m of things
// at different distances is best. An answer changes its direction, and those
// beside it by how much of the picture they share. Deterministic.
class NextBestView {
 public:
  static constexpr size_t kDirections = 24;

  // Forgets all answers: the robot stands elsewhere.
  void Begin(const geometry::Rigid2& odom_from_base);
  bool has_begun() const { return here_.has_value(); }
  // How far the robot has moved since, without turns (m).
  double MovedFrom_m(const geometry::Rigid2& odom_from_base) const;

  // What the laser sees, in the base's frame; directions that it has not seen
  // yet get their prior, seen ones the better of both.
  void AddScan(const geometry::Rigid2& odom_from_base,
               const std::vector<geometry::Vec2>& ends);
  // A picture was asked about; `promise` in [0, 1] is how near the answer was
  // to being believed (its confidence; less if it was refused).
  void AddAnswer(double yaw_in_odom_rad, double promise);

  // The direction to look in next (rad, in the odometry's frame): the best
  // chance, less what the turn takes. A second view that is to confirm a weak
  // first one should share some of it, but not most: `near_rad` is then where
  // that was. nullopt: nothing promises more than `least`.
  std::optional<double> Next(double yaw_in_odom_rad,
                             std::optional<double> near_rad,
                             double least) const;
  double Chance(double yaw_in_odom_rad) const;

 private:
  std::optional<geometry::Rigid2> here_;
  std::array<double, kDirections> prior_{};
  std::array<bool, kDirections> is_seen_{};
  // Of answers: what they promise, and how much is known.
  std::array<double, kDirections> promise_{};
  std::array<double, kDirections> known_{};
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_NEXT_BEST_VIEW_H_
