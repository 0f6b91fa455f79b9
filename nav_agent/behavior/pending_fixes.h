// What a lost robot makes of one fix after another: takes it, waits for a view
// that agrees, or stops believing that the server knows this place.
#ifndef NAV_AGENT_BEHAVIOR_PENDING_FIXES_H_
#define NAV_AGENT_BEHAVIOR_PENDING_FIXES_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "nav_agent/behavior/fix_gate.h"

namespace treeline::behavior {

enum class FixDecision : uint8_t {
  kLookOn,       // refused, or waits for a view that agrees
  kTake,         // one view is enough for a trial
  kTakeAgreed,   // two views agree
  kServerIsLost  // the server knows another place than this one
};

// Not thread-safe.
class PendingFixes {
 public:
  struct Result {
    FixDecision decision = FixDecision::kLookOn;
    // What to take; of views that agree, what they say together.
    GatedFix fix;
  };
  // may_take_one: a single view may be believed, if it is sure and none before
  // disputes it, or if is_unique: the laser alone says so, too.
  Result Add(const GatedFix& fix, const FixGateOptions& options,
             bool may_take_one, bool is_unique);

  // Takes out the first that waits and is so; nullopt: none.
  std::optional<GatedFix> TakeFirst(
      const std::function<bool(const GatedFix&)>& is_so);

  bool empty() const { return waiting_.empty(); }
  size_t size() const { return waiting_.size(); }
  // Where the robot looked for the last one, in the frame of the odometry;
  // nullopt: none waits.
  std::optional<double> LastYaw_rad() const;
  void Clear() { waiting_.clear(); }
  // That one waits, and no other.
  void Reset(const GatedFix& fix) { waiting_ = {fix}; }

 private:
  std::vector<GatedFix> waiting_;
  // Fixes in a row that the server is sure of, and the robot's own sensors
  // refuse.
  int refused_ = 0;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_PENDING_FIXES_H_
