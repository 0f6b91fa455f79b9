// Where the wheels say that a robot went, for wheels as they may be.
#ifndef NAV_AGENT_CALIBRATION_WHEEL_PATH_H_
#define NAV_AGENT_CALIBRATION_WHEEL_PATH_H_

#include <optional>
#include <span>
#include <vector>

#include "common/geometry/rigid2.h"
#include "nav_agent/calibration/drive.h"

namespace treeline::calibration {

// What a wheel counts is multiplied by its scale: above 1, it is larger than
// assumed.
struct Wheels {
  double left_scale = 1;
  double right_scale = 1;
  double track_m = 0.54;

  constexpr bool operator==(const Wheels&) const = default;
};

// Readings must outlive it. Immutable, thread-safe.
class WheelPath {
 public:
  // Readings farther apart than longest_gap_s are not connected.
  WheelPath(std::span<const DriveReading> readings, double longest_gap_s);

  // How the base moved: begin_from_end, along an arc between any two readings,
  //
  //   turn = (s_r right - s_l left) / track,  way = (s_l left + s_r right) / 2,
  //
  // with what was rolled shared out evenly over the time between them. nullopt:
  // not all of the time has readings, there is a gap, or a counter was reset.
  std::optional<geometry::Rigid2> Motion(double begin_s, double end_s,
                                         const Wheels& wheels) const;
  // What was rolled there, back and forth added up (m).
  double Way_m(double begin_s, double end_s) const;
  // The turn that the yaw rate makes (rad), trapezoids between readings.
  std::optional<double> GyroscopeTurn_rad(double begin_s, double end_s) const;
  // Whether the yaw rate is measured, rather than computed of the wheels of a
  // robot with this track.
  bool HasGyroscope(double track_m) const;

 private:
  // The reading at or before; -1: before the first.
  long Before(double time_s) const;
  bool IsCovered(double begin_s, double end_s) const;

  std::span<const DriveReading> readings_;
  // Of each reading: how many steps up to it are gaps or resets, the way, and
  // the gyroscope's turn.
  std::vector<int> breaks_;
  std::vector<double> ways_m_;
  std::vector<double> turns_rad_;
};

}  // namespace treeline::calibration

#endif  // NAV_AGENT_CALIBRATION_WHEEL_PATH_H_
