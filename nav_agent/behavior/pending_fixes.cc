#include "nav_agent/behavior/pending_fixes.h"

#include <algorithm>

#include "nav_agent/behavior/parameters.h"

namespace treeline::behavior {
namespace {

// Refused by what the robot knows itself, not for the server's doubt.
bool IsElsewhere(FixVerdict verdict) {
  return verdict == FixVerdict::kAgainstGravity ||
         verdict == FixVerdict::kNotOnGround ||
         verdict == FixVerdict::kAgainstScan;
}

}  // namespace

PendingFixes::Result PendingFixes::Add(const GatedFix& fix,
                                       const FixGateOptions& options,
                                       bool may_take_one, bool is_unique) {
  Result result = {.decision = FixDecision::kLookOn, .fix = fix};
  if (IsRefused(fix.verdict)) {
    if (IsElsewhere(fix.verdict) && fix.is_server_sure &&
        ++refused_ >= kMaxRefusedFixes) {
      result.decision = FixDecision::kServerIsLost;
    }
    return result;
  }
  refused_ = 0;
  const auto agrees = std::ranges::find_if(
      waiting_,
      [&](const GatedFix& other) { return FixesAgree(other, fix, options); });
  if (agrees != waiting_.end()) {
    result.decision = FixDecision::kTakeAgreed;
    result.fix = CombinedFix(*agrees, fix);
    return result;
  }
  const bool is_disputed =
      std::ranges::any_of(waiting_, &GatedFix::is_server_sure);
  const bool is_sure = fix.verdict == FixVerdict::kSure && !is_disputed;
  if (may_take_one && (is_sure || is_unique)) {
    result.decision = FixDecision::kTake;
    return result;
  }
  if (waiting_.size() >= kMaxWaitingFixes) waiting_.erase(waiting_.begin());
  waiting_.push_back(fix);
  return result;
}

std::optional<GatedFix> PendingFixes::TakeFirst(
    const std::function<bool(const GatedFix&)>& is_so) {
  const auto found = std::ranges::find_if(waiting_, is_so);
  if (found == waiting_.end()) return std::nullopt;
  const GatedFix fix = *found;
  waiting_.erase(found);
  return fix;
}

std::optional<double> PendingFixes::LastYaw_rad() const {
  if (waiting_.empty()) return std::nullopt;
  return waiting_.back().motion.odom_from_base.yaw_rad;
}

}  // namespace treeline::behavior
