// The goals of Nav2's action NavigateToPose, as its clients know them: what is
// accepted, what becomes of it, and what is told on the way. Knows messages,
// not DDS. States are those of rcl_action
// (https://design.ros2.org/articles/actions.html); what a new goal does to the
// one before it is what Nav2's bt_navigator does: that one is aborted.
#ifndef NAV_AGENT_BRIDGE_NAVIGATE_ACTION_NAVIGATE_ACTION_H_
#define NAV_AGENT_BRIDGE_NAVIGATE_ACTION_NAVIGATE_ACTION_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/ros2/messages/action_messages.h"
#include "nav_agent/core/navigation_cause.h"
#include "nav_agent/service/agent_hub.h"

namespace treeline::navigate_action {

// What the agent does of it. Errors are for people.
struct ActionAgent {
  // The number of the goal; a later one is greater.
  std::function<absl::StatusOr<uint64_t>(const messages::PoseStamped& pose)>
      set_goal;
  std::function<absl::Status(uint64_t goal)> cancel;
};

// The same moment by the agent's clock and as messages are stamped.
struct Moment {
  base::MonotonicTime now;
  messages::Time stamp;
};

// So many goals that have ended are remembered, each for so long.
inline constexpr size_t kMaxEnded = 64;
inline constexpr double kRememberFor_s = 15 * 60;

// Nav2's number for it: those of ComputePathToPose (2xx) and FollowPath (1xx).
uint16_t ErrorCodeOf(core::NavigationCause cause);

// For one thread.
class NavigateAction {
 public:
  explicit NavigateAction(ActionAgent agent) : agent_(std::move(agent)) {}

  struct Answer {
    messages::NavigateToPoseSendGoalResponse response;
    // Why it is not accepted; OK if it is. The message has no room for it.
    absl::Status why;
  };
  // INVALID_ARGUMENT: an id that is known, or a behavior tree; else what
  // set_goal says.
  Answer Take(const messages::NavigateToPoseSendGoalRequest& request,
              const Moment& moment);

  // Goals become CANCELING by it, and CANCELED once the agent says so.
  messages::CancelGoalResponse Cancel(
      const messages::CancelGoalRequest& request);

  // nullopt: it has not ended. UNKNOWN: there is no such goal.
  std::optional<messages::NavigateToPoseGetResultResponse> ResultOf(
      const messages::Uuid& goal_id) const;

  // What the agent has published. The answer: what is told to who drives it;
  // nullopt: nobody does. `map_frame`: of poses.
  std::optional<messages::NavigateToPoseFeedback> Follow(
      const agent_service::AgentState& state, const Moment& moment,
      const std::string& map_frame);

  // The goal under way is aborted: nobody drives to it any more.
  void Abort(const std::string& why, const Moment& moment);

  // Of the goal that Follow tells of, or told of last.
  const messages::Uuid& current_id() const { return current_id_; }
  messages::GoalStatusArray Statuses() const;
  // Whether they differ from those of the last call.
  bool TakeChanged() { return std::exchange(is_changed_, false); }

 private:
  struct Goal {
    messages::GoalInfo info;
    int8_t status = messages::GoalStatus::kExecuting;
    uint64_t number = 0;
    base::MonotonicTime began = {};
    base::MonotonicTime ended = {};
    messages::NavigateToPoseResult result = {};

    bool HasEnded() const { return status >= messages::GoalStatus::kSucceeded; }
  };

  Goal* Current();
  const Goal* Find(const messages::Uuid& id) const;
  bool CancelOne(Goal& goal);
  void End(Goal& goal, int8_t status, base::MonotonicTime now,
           messages::NavigateToPoseResult result);
  void Judge(Goal& goal, const behavior::GoalStatus& driven,
             base::MonotonicTime now);
  void Forget(base::MonotonicTime now);

  const ActionAgent agent_;
  // Oldest first. At most one has not ended: the last.
  std::deque<Goal> goals_;
  messages::Uuid current_id_;
  bool is_changed_ = true;
};

}  // namespace treeline::navigate_action

#endif  // NAV_AGENT_BRIDGE_NAVIGATE_ACTION_NAVIGATE_ACTION_H_
