#include "nav_agent/behavior/server_question.h"

#include <utility>

#include "common/base/clock.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/relocalization_parts.h"

namespace treeline::behavior {

void ServerQuestion::Ask(std::shared_ptr<const core::RgbdFrame> frame,
                         const localization::TrackedMotion& motion,
                         base::MonotonicTime now) {
  frame_ = std::move(frame);
  motion_ = motion;
  asked_ = now;
  is_open_ = true;
  server_->Ask(*frame_, deadline_s_);
}

std::optional<ServerQuestion::Answer> ServerQuestion::Take(
    base::MonotonicTime now) {
  std::optional<Answer> answer = server_->TakeAnswer();
  if (!answer.has_value() &&
      base::SecondsBetween(asked_, now) > deadline_s_ + kAnswerGrace_s) {
    server_->Cancel();
    answer = Answer(absl::DeadlineExceededError("no answer in time"));
  }
  if (answer.has_value()) is_open_ = false;
  return answer;
}

void ServerQuestion::Cancel() {
  if (server_ != nullptr) server_->Cancel();
  is_open_ = false;
}

}  // namespace treeline::behavior
