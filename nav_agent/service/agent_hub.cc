#include "nav_agent/service/agent_hub.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"

namespace treeline::agent_service {
namespace {

absl::Status ClosedError() {
  return absl::UnavailableError("the agent is stopping");
}

}  // namespace

absl::Status AgentHubOptions::Validate() const {
  if (max_commands < 1 || max_commands > 10000) {
    return absl::InvalidArgumentError(absl::StrCat(
        "commands that may wait are ", max_commands, "; it must be 1..10000"));
  }
  if (commands_in_step < 1 || commands_in_step > max_commands) {
    return absl::InvalidArgumentError(
        absl::StrCat("commands in a step are ", commands_in_step,
                     "; it must be 1..", max_commands));
  }
  if (patience < absl::Milliseconds(1) || patience > absl::Minutes(1)) {
    return absl::InvalidArgumentError(
        "commands must wait for 1 ms to 1 min at most");
  }
  if (max_events < 1 || max_events > 1'000'000) {
    return absl::InvalidArgumentError(absl::StrCat(
        "events that are kept are ", max_events, "; it must be 1..1000000"));
  }
  return absl::OkStatus();
}

absl::Status AgentHub::Do(Command command, bool is_urgent) {
  const auto waiting = std::make_shared<Waiting>();
  waiting->command = std::move(command);
  waiting->is_urgent = is_urgent;
  const absl::Time deadline = absl::Now() + options_.patience;
  const absl::MutexLock lock(&mutex_);
  if (is_closed_) return ClosedError();
  if (!is_urgent &&
      commands_.size() >= static_cast<size_t>(options_.max_commands)) {
    return absl::ResourceExhaustedError(
        absl::StrCat(commands_.size(), " commands wait already"));
  }
  // Before all that are not.
  const auto place =
      is_urgent
          ? std::find_if(commands_.begin(), commands_.end(),
                         [](const auto& other) { return !other->is_urgent; })
          : commands_.end();
  commands_.insert(place, waiting);
  while (!waiting->is_done) {
    if (waiting->is_started) {
      // The caller's variables are in use: it must not go.
      done_.Wait(&mutex_);
      continue;
    }
    const bool is_late = done_.WaitWithDeadline(&mutex_, deadline);
    if (waiting->is_started || waiting->is_done) continue;
    if (!is_late && !is_closed_) continue;
    commands_.erase(std::remove(commands_.begin(), commands_.end(), waiting),
                    commands_.end());
    if (is_closed_) return ClosedError();
    return absl::DeadlineExceededError(
        "the control loop did not take the command in time");
  }
  return waiting->result;
}

void AgentHub::RunCommands(behavior::Navigator& navigator) {
  for (int i = 0; i < options_.commands_in_step; ++i) {
    std::shared_ptr<Waiting> next;
    {
      const absl::MutexLock lock(&mutex_);
      if (commands_.empty()) return;
      next = commands_.front();
      commands_.pop_front();
      next->is_started = true;
    }
    absl::Status result = next->command(navigator);
    const absl::MutexLock lock(&mutex_);
    next->result = std::move(result);
    next->is_done = true;
    done_.SignalAll();
  }
}

size_t AgentHub::waiting() const {
  const absl::MutexLock lock(&mutex_);
  return commands_.size();
}

std::shared_ptr<const AgentState> AgentHub::Latest() const {
  const absl::MutexLock lock(&mutex_);
  return latest_;
}

std::shared_ptr<const AgentState> AgentHub::WaitForNewer(
    uint64_t number, absl::Time deadline) const {
  const absl::MutexLock lock(&mutex_);
  while (!is_closed_) {
    if (latest_ != nullptr && latest_->number > number) return latest_;
    if (newer_.WaitWithDeadline(&mutex_, deadline)) {
      return latest_ != nullptr && latest_->number > number ? latest_ : nullptr;
    }
  }
  return nullptr;
}

void AgentHub::Publish(AgentState state) {
  auto next = std::make_shared<AgentState>(std::move(state));
  // Freed after the lock, if this was its last holder.
  std::shared_ptr<const AgentState> before;
  const absl::MutexLock lock(&mutex_);
  before = latest_;
  next->number = before == nullptr ? 1 : before->number + 1;
  latest_ = std::move(next);
  newer_.SignalAll();
}

void AgentHub::AddEvent(double time_s, const std::string& kind,
                        const std::string& text) {
  const absl::MutexLock lock(&mutex_);
  events_.push_back({++last_event_, time_s, kind, text});
  if (events_.size() > static_cast<size_t>(options_.max_events)) {
    events_.pop_front();
  }
}

std::vector<AgentHub::Event> AgentHub::EventsAfter(uint64_t number,
                                                   size_t at_most) const {
  const absl::MutexLock lock(&mutex_);
  const auto first =
      std::find_if(events_.begin(), events_.end(),
                   [&](const Event& event) { return event.number > number; });
  const auto count = std::min(
      at_most, static_cast<size_t>(std::distance(first, events_.end())));
  return {first, first + static_cast<std::ptrdiff_t>(count)};
}

uint64_t AgentHub::last_event() const {
  const absl::MutexLock lock(&mutex_);
  return last_event_;
}

void AgentHub::Close() {
  const absl::MutexLock lock(&mutex_);
  is_closed_ = true;
  done_.SignalAll();
  newer_.SignalAll();
}

bool AgentHub::is_closed() const {
  const absl::MutexLock lock(&mutex_);
  return is_closed_;
}

}  // namespace treeline::agent_service
