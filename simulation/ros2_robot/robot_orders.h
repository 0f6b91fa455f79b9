// What somebody at the keyboard wants of a robot that is played.
#ifndef SIMULATION_ROS2_ROBOT_ROBOT_ORDERS_H_
#define SIMULATION_ROS2_ROBOT_ROBOT_ORDERS_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace treeline::ros2_robot {

struct RobotOrder {
  enum class Kind {
    kTour,      // somebody drives the world's tour by remote control, once
    kKidnap,    // the robot is elsewhere
    kGoal,      // somebody clicks a goal, as in RViz
    kPlace,     // somebody clicks an initial pose
    kSilence,   // a topic says nothing for a while
    kJump,      // the clock that stamps are of is set ahead
    kNonsense,  // scans and odometry that are none
  };

  Kind kind = Kind::kTour;
  // In the world: where, for kKidnap, kGoal and kPlace.
  double x_m = 0;
  double y_m = 0;
  double yaw_rad = 0;
  // kSilence: scan, odom or clock.
  std::string topic;
  // kSilence: for so long; kJump: by so much.
  double seconds = 0;
};

// INVALID_ARGUMENT says what orders there are.
absl::StatusOr<RobotOrder> ParseOrder(const std::string& line);

// The lines of standard input as they come. Not thread-safe.
class OrderReader {
 public:
  // Since the last call, oldest first; never waits.
  std::vector<std::string> TakeLines();

 private:
  // A line that has begun to come.
  std::string rest_;
  bool is_over_ = false;
};

}  // namespace treeline::ros2_robot

#endif  // SIMULATION_ROS2_ROBOT_ROBOT_ORDERS_H_
