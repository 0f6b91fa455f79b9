// Drives a robot along a line by its true pose: for mapping drives and tests.
// A helper of the simulator; no robot knows its true pose.
#ifndef SIMULATION_SIMULATOR_TOUR_DRIVER_H_
#define SIMULATION_SIMULATOR_TOUR_DRIVER_H_

#include <cstddef>
#include <vector>

#include "absl/status/status.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::simulator {

struct TourOptions {
  // In (0, 5].
  double speed_mps = 0.5;
  // The point that is steered for lies so far ahead on the line.
  double look_ahead_m = 0.5;
  // Corners may be cut by less than about look_ahead_m; the end is reached
  // when it is this near.
  double arrival_m = 0.15;
  // The robot waits while a person or a cart is this near before it; 0: it
  // drives on. [0, 10]
  double give_way_m = 0.6;
  // Round and round, or once.
  bool repeats = false;
  // A survey: after each so many metres of the line the robot turns once on the
  // spot, so that its camera sees everything from there; 0: never. [0, 100]
  double look_around_every_m = 0;
  // How fast, in (0, 3].
  double look_around_radps = 0.7;

  absl::Status Validate() const;
};

// Pure pursuit (Coulter 1992): the arc through the robot and a point ahead on
// the line has curvature 2 y / (x^2 + y^2) in the robot's frame. Where the
// point is not in front, the robot turns on the spot first. Not thread-safe.
class TourDriver {
 public:
  // Corners of a line on the ground; their heights tell floors apart that lie
  // over one another. At least one.
  TourDriver(std::vector<geometry::Vec3> corners, const TourOptions& options);

  // What to do at this pose. Nothing when the tour is done.
  core::VelocityCommand CommandAt(const geometry::Rigid3& world_from_base);
  // Goes on from the point of the line that is nearest: somebody carried the
  // robot there.
  void JoinNearest(geometry::Vec3 position);
  const TourOptions& options() const { return options_; }
  bool is_done() const { return is_done_; }
  // Of the whole line.
  double length_m() const { return starts_.back(); }
  // How far along it the robot has come, rounds included.
  double progress_m() const { return rounds_ * length_m() + along_m_; }

 private:
  geometry::Vec3 PointAt(double along_m) const;
  void Advance(geometry::Vec3 position);
  // Whether the robot turns on the spot to look around.
  bool LooksAround(double yaw_rad);

  std::vector<geometry::Vec3> corners_;
  TourOptions options_;
  // Of each corner, how far along the line it lies.
  std::vector<double> starts_;
  double along_m_ = 0;
  int rounds_ = 0;
  bool is_done_ = false;
  bool turns_ = false;
  // How far along the line the next look around is; while there is one, how far
  // it has turned, and for how many commands it did not.
  double next_look_m_ = 0;
  bool is_looking_ = false;
  double looked_rad_ = 0;
  double last_yaw_rad_ = 0;
  int stuck_ = 0;
};

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_TOUR_DRIVER_H_
