#include "nav_agent/bridge/robot_ports/ros_time.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <utility>

#include "absl/strings/str_cat.h"

namespace treeline::robot_ports {
namespace {

using std::chrono::nanoseconds;

// What is less is taken for messages out of order, or for the slow correction
// of a clock.
constexpr int64_t kJump_ns = 100'000'000;
// A simulation leaps further only if its clock was set, or we heard nothing for
// a while.
constexpr int64_t kLeap_ns = 2'000'000'000;
constexpr double kSilent_s = 0.5;
// Clocks of machines that nobody sets differ by less, and messages are late by
// less.
constexpr int64_t kOtherClock_ns = 10'000'000'000;

int64_t Nanoseconds(base::MonotonicTime time) {
  return std::chrono::duration_cast<nanoseconds>(time.time_since_epoch())
      .count();
}

base::MonotonicTime AtNanoseconds(int64_t time_ns) {
  return base::MonotonicTime(nanoseconds(time_ns));
}

// So rough that a clock that is wrong is told of once.
const char* Roughly(int64_t duration_ns) {
  constexpr int64_t kMinute_ns = 60'000'000'000;
  if (duration_ns < kMinute_ns) return "more than 10 s";
  if (duration_ns < 60 * kMinute_ns) return "minutes";
  return duration_ns < 24 * 60 * kMinute_ns ? "hours" : "days";
}

}  // namespace

int64_t SystemNow_ns() {
  return std::chrono::duration_cast<nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

RosTime::RosTime(bool is_simulated, const base::Clock& steady,
                 SystemClock system_now_ns)
    : is_simulated_(is_simulated),
      steady_(steady),
      system_now_ns_(std::move(system_now_ns)) {}

base::MonotonicTime RosTime::NowLocked() const {
  if (!is_simulated_) return steady_.Now();
  if (!clock_ns_.has_value()) return told_;
  const double since_ns =
      static_cast<double>(Nanoseconds(steady_.Now()) - Nanoseconds(came_));
  const int64_t carried_ns =
      std::min(static_cast<int64_t>(pace_ * since_ns), period_ns_);
  told_ = std::max(told_, AtNanoseconds(*clock_ns_ + shift_ns_ + carried_ns));
  return told_;
}

base::MonotonicTime RosTime::Now() const {
  const absl::MutexLock lock(&mutex_);
  return NowLocked();
}

void RosTime::Set(const messages::Clock& clock) {
  const absl::MutexLock lock(&mutex_);
  const int64_t now_ns = messages::Nanoseconds(clock.clock);
  const base::MonotonicTime real = steady_.Now();
  if (!clock_ns_.has_value()) {
    clock_ns_ = now_ns;
    came_ = real;
    return;
  }
  const int64_t step_ns = now_ns - *clock_ns_;
  if (step_ns <= 0 && step_ns > -kJump_ns) return;
  if (step_ns <= 0 || step_ns > kLeap_ns) {
    // Time that has passed has passed; where it was set back, it goes on.
    if (step_ns <= 0) shift_ns_ = Nanoseconds(NowLocked()) - now_ns;
    period_ns_ = 0;
    pace_ = 0;
    ++jumps_;
  } else {
    const int64_t real_ns = Nanoseconds(real) - Nanoseconds(came_);
    period_ns_ = step_ns;
    pace_ = real_ns > 0
                ? static_cast<double>(step_ns) / static_cast<double>(real_ns)
                : 0;
  }
  clock_ns_ = now_ns;
  came_ = real;
}

int64_t RosTime::Shift_ns() const {
  if (is_simulated_) return shift_ns_;
  return Nanoseconds(steady_.Now()) - system_now_ns_();
}

void RosTime::Watch() {
  const absl::MutexLock lock(&mutex_);
  if (is_simulated_) return;
  const int64_t shift_ns = Shift_ns();
  if (last_shift_ns_.has_value() &&
      std::abs(shift_ns - *last_shift_ns_) >= kJump_ns) {
    ++jumps_;
  }
  last_shift_ns_ = shift_ns;
}

base::MonotonicTime RosTime::TimeOf(const messages::Time& stamp) const {
  const absl::MutexLock lock(&mutex_);
  return AtNanoseconds(messages::Nanoseconds(stamp) + Shift_ns());
}

absl::Status RosTime::CheckStamp(const messages::Time& stamp) const {
  const int64_t stamp_ns = messages::Nanoseconds(stamp);
  if (stamp_ns == 0) {
    return absl::InvalidArgumentError(
        "its stamp is 0: whoever publishes it must stamp it");
  }
  const absl::MutexLock lock(&mutex_);
  // Nobody has told the time yet.
  if (is_simulated_ && !clock_ns_.has_value()) return absl::OkStatus();
  const int64_t now_ns = Nanoseconds(NowLocked()) - Shift_ns();
  if (std::abs(stamp_ns - now_ns) <= kOtherClock_ns) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "its stamp is ", Roughly(std::abs(stamp_ns - now_ns)),
      stamp_ns < now_ns ? " old: " : " ahead: ",
      is_simulated_
          ? "whoever publishes it does not go by /clock (use_sim_time)"
          : "in a simulation, set use_sim_time; else set the clocks of both "
            "machines (chrony)"));
}

messages::Time RosTime::StampOf(base::MonotonicTime time) const {
  const absl::MutexLock lock(&mutex_);
  return messages::TimeOf(Nanoseconds(time) - Shift_ns());
}

int64_t RosTime::jumps() const {
  const absl::MutexLock lock(&mutex_);
  return jumps_;
}

bool RosTime::is_running() const {
  if (!is_simulated_) return true;
  const absl::MutexLock lock(&mutex_);
  return clock_ns_.has_value() &&
         base::SecondsBetween(came_, steady_.Now()) < kSilent_s;
}

}  // namespace treeline::robot_ports
