// What may be done to a simulated robot and its world.
#ifndef NAV_AGENT_SERVICE_SIMULATION_CONTROL_H_
#define NAV_AGENT_SERVICE_SIMULATION_CONTROL_H_

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/core/level_pose.h"

namespace treeline::agent_service {

struct RequestedFault {
  std::string target;
  std::string kind;
  // 0: until the end (s).
  double duration_s = 0;
  // A share or seconds, by the kind.
  double amount = 1;
};

// Called by the stepping thread. Poses are of the map.
class SimulationControl {
 public:
  virtual ~SimulationControl() = default;

  // Takes the robot to `pose`. Both return where it stands then. NOT_FOUND: no
  // ground, no such place; FAILED_PRECONDITION: no room.
  virtual absl::StatusOr<geometry::Rigid3> Kidnap(
      const core::LevelPose& pose) = 0;
  virtual absl::StatusOr<geometry::Rigid3> KidnapTo(
      const std::string& place) = 0;
  virtual absl::StatusOr<geometry::Rigid3> KidnapAnywhere() = 0;
  // A box with sides of size_m. Returns its name.
  virtual absl::StatusOr<std::string> AddObstacle(const core::LevelPose& pose,
                                                  double size_m) = 0;
  virtual absl::Status RemoveObstacle(const std::string& name) = 0;
  virtual absl::Status InjectFault(const RequestedFault& fault) = 0;
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_SIMULATION_CONTROL_H_
