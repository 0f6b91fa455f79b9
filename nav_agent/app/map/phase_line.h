// Progress of what is done in phases.
#ifndef NAV_AGENT_APP_MAP_PHASE_LINE_H_
#define NAV_AGENT_APP_MAP_PHASE_LINE_H_

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

#include "common/base/progress.h"

namespace treeline::map_app {

// One progress line for each phase.
class PhaseLine {
 public:
  explicit PhaseLine(bool quiet) : quiet_(quiet) {}

  void Show(const std::string& phase, double part) {
    if (phase != phase_) {
      line_.emplace(phase, kUnits, quiet_);
      phase_ = phase;
      shown_ = 0;
    }
    const auto now = static_cast<int64_t>(part * kUnits);
    if (now > shown_) line_->Add(now - shown_);
    shown_ = std::max(shown_, now);
  }

 private:
  static constexpr int64_t kUnits = 1000;

  bool quiet_;
  std::string phase_;
  int64_t shown_ = 0;
  std::optional<base::Progress> line_;
};

}  // namespace treeline::map_app

#endif  // NAV_AGENT_APP_MAP_PHASE_LINE_H_
