// The robot as a thing in the world: it rolls, climbs, bumps and falls.
#ifndef SIMULATION_SIMULATOR_ROBOT_BODY_H_
#define SIMULATION_SIMULATOR_ROBOT_BODY_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "simulation/simulator/collider.h"
#include "simulation/simulator/differential_drive.h"
#include "simulation/simulator/footing.h"
#include "simulation/simulator/sim_event.h"

namespace treeline::simulator {

// A robot on slopes steeper than this many times its limit tips over.
inline constexpr double kTippingFactor = 1.5;

// Not thread-safe. Terrain and stage must outlive it.
class RobotBody {
 public:
  RobotBody(const Terrain& terrain, const Stage& stage,
            const core::RobotModel& robot, const WheelOdometryErrors& errors,
            uint64_t seed);

  // Puts the robot down on the ground nearest to height_m, standing. NOT_FOUND:
  // there is no ground, or not below all of it; FAILED_PRECONDITION: it is too
  // steep, or something stands there (what); then it stays where it was.
  absl::Status PutDown(geometry::Vec2 position, double yaw_rad, double height_m,
                       SimTime now);

  // One step of DifferentialDrive::kStep_s, the `step`th, that ends at `now`.
  // Adds what happened to `events`.
  void Step(const core::VelocityCommand& command, const WheelFaults& faults,
            int64_t step, SimTime now, std::vector<SimEvent>& events);

  const Stance& stance() const { return stance_; }
  DifferentialDrive& drive() { return drive_; }
  const DifferentialDrive& drive() const { return drive_; }
  bool is_fallen() const { return is_fallen_; }
  // Whether the last step was stopped by something.
  bool is_blocked() const { return is_blocked_; }
  // True motion since the beginning; teleports do not count.
  double distance_m() const { return distance_m_; }
  double turned_rad() const { return turned_rad_; }
  // True speeds in the last step.
  double forward_mps() const { return forward_mps_; }
  double yaw_rate_radps() const { return yaw_rate_radps_; }

 private:
  // Something that the robot touches, or touched a moment ago.
  struct Touch {
    std::string what;
    int actor = -1;
    geometry::Vec3 point;
    SimTime last{0};
  };
  struct Proposal {
    geometry::Vec2 position;
    double yaw_rad = 0;
  };

  Proposal Moved(const PlanarMotion& motion) const;
  void Fall(SimEventKind kind, geometry::Vec3 at, SimTime now,
            std::vector<SimEvent>& events);
  void WatchSlope(SimTime now, std::vector<SimEvent>& events);
  // Whether something is in the way of standing at `next`.
  bool IsStopped(const Stance& next, const PlanarMotion& motion,
                 const std::vector<Actor>& actors, SimTime now,
                 std::vector<SimEvent>& events);
  // Records a contact unless it goes on from before. Whether it stops the
  // motion: one with somebody who walked into the robot does only if the robot
  // moves towards it.
  bool Meet(const Contact& contact, const PlanarMotion& motion,
            const std::vector<Actor>& actors, SimTime now,
            std::vector<SimEvent>& events);
  // At right angles to the footprint's edge that is nearest to a point, which
  // lies `arm` from the base: outwards.
  geometry::Vec2 OutwardAt(geometry::Vec2 arm_in_world) const;
  double ApproachOfBody_mps(const Contact& contact,
                            const std::vector<Actor>& actors, SimTime now,
                            geometry::Vec2 outward) const;
  bool IsKnown(const Contact& contact, SimTime now);

  const Stage* stage_;
  core::RobotModel robot_;
  Footing footing_;
  Collider collider_;
  DifferentialDrive drive_;
  Stance stance_;
  bool is_fallen_ = false;
  bool is_blocked_ = false;
  bool is_steep_ = false;
  double distance_m_ = 0;
  double turned_rad_ = 0;
  double forward_mps_ = 0;
  double yaw_rate_radps_ = 0;
  std::vector<Touch> touches_;
};

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_ROBOT_BODY_H_
