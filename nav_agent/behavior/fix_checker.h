// Asks the robot's witnesses about a server's answer, and has it judged by them
// (fix_gate.h).
#ifndef NAV_AGENT_BEHAVIOR_FIX_CHECKER_H_
#define NAV_AGENT_BEHAVIOR_FIX_CHECKER_H_

#include <memory>
#include <optional>
#include <utility>

#include "nav_agent/behavior/fix_gate.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/localization/robot_tracker.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline::behavior {

// Stateless; thread-safe as the tracker is.
class FixChecker {
 public:
  FixChecker(std::shared_ptr<const traversability::NavigationMap> map,
             const core::RobotModel& robot, const FixGateOptions& options)
      : map_(std::move(map)), robot_(robot), options_(options) {}

  // `motion` is the wheels' of the frame's moment. The tracker's newest scan
  // must be of about the same place: the pose is carried on by the wheels. The
  // fix's pose is moved to where that scan fits best, within the options'
  // search_m and search_rad. A witness is not asked about a fix that one before
  // it refuses.
  GatedFix Check(const core::RelocalizationAnswer& answer,
                 const localization::TrackedMotion& motion,
                 const localization::RobotTracker& tracker) const;

  const FixGateOptions& options() const { return options_; }

 private:
  // Also puts the fix's pose on that ground.
  GroundWitness AskMap(const geometry::Vec3& base_in_map,
                       const localization::RobotTracker& tracker,
                       GatedFix& fix) const;
  // The ground beside obstacles of a level that the scan sees through.
  std::optional<core::LevelPlace> GroundAmongGhosts(
      int level, const geometry::Vec3& base_in_map,
      const localization::RobotTracker& tracker, const GatedFix& fix) const;
  // Also moves the fix's pose to where the scan fits best.
  ScanWitness AskLaser(const localization::RobotTracker& tracker,
                       GatedFix& fix) const;

  std::shared_ptr<const traversability::NavigationMap> map_;
  core::RobotModel robot_;
  FixGateOptions options_;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_FIX_CHECKER_H_
