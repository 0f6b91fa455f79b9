// The question to the relocalization server: of which picture, when it was
// asked, and that its answer comes in time or counts as failed.
#ifndef NAV_AGENT_BEHAVIOR_SERVER_QUESTION_H_
#define NAV_AGENT_BEHAVIOR_SERVER_QUESTION_H_

#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "nav_agent/core/relocalization.h"
#include "nav_agent/localization/robot_tracker.h"

namespace treeline::behavior {

// One question at a time. Not thread-safe.
class ServerQuestion {
 public:
  using Answer = absl::StatusOr<core::RelocalizationAnswer>;

  // server must outlive it; null: there is none, and nothing may be asked.
  ServerQuestion(core::RelocalizationPort* server, double deadline_s)
      : server_(server), deadline_s_(deadline_s) {}

  bool has_server() const { return server_ != nullptr; }
  bool is_open() const { return is_open_; }

  // What was open is cancelled. `motion` is the wheels' of the frame's moment.
  void Ask(std::shared_ptr<const core::RgbdFrame> frame,
           const localization::TrackedMotion& motion, base::MonotonicTime now);
  // Closes an open question with its answer, or with DEADLINE_EXCEEDED when the
  // server is late; nullopt: it is still open.
  std::optional<Answer> Take(base::MonotonicTime now);
  void Cancel();

  // Of the question that was asked last; it must have been one.
  const localization::TrackedMotion& motion() const { return *motion_; }
  // null: none was asked yet.
  const std::shared_ptr<const core::RgbdFrame>& frame() const { return frame_; }

 private:
  core::RelocalizationPort* server_;
  double deadline_s_;
  bool is_open_ = false;
  base::MonotonicTime asked_;
  std::optional<localization::TrackedMotion> motion_;
  std::shared_ptr<const core::RgbdFrame> frame_;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_SERVER_QUESTION_H_
