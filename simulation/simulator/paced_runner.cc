#include "simulation/simulator/paced_runner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "absl/time/clock.h"
#include "absl/time/time.h"

namespace treeline::simulator {
namespace {

// A runner that waits looks up so often for a stop or the end of a pause.
constexpr SimTime kLongestWait = std::chrono::milliseconds(20);

}  // namespace

SimTime Pace::Due(base::MonotonicTime now) {
  if (!last_.has_value()) {
    last_ = now;
    return SimTime(0);
  }
  if (std::isinf(factor_)) return kMaxAtOnce;
  const SimTime due = FromSeconds(
      factor_ * std::chrono::duration<double>(now - *last_).count());
  if (due < kMin) return SimTime(0);
  last_ = now;
  return std::min(due, kMaxAtOnce);
}

SimTime Pace::Wait(base::MonotonicTime now) const {
  if (!last_.has_value() || std::isinf(factor_)) return SimTime(0);
  const double passed_s = std::chrono::duration<double>(now - *last_).count();
  return FromSeconds(std::max(0.0, Seconds(kMin) / factor_ - passed_s));
}

PacedRunner::PacedRunner(std::function<void(SimTime)> step, double factor,
                         const base::Clock& clock)
    : step_(std::move(step)), clock_(&clock), pace_(factor) {}

SimTime PacedRunner::Next() {
  const base::MonotonicTime now = clock_->Now();
  if (!is_paused_) return pace_.Due(now);
  pace_.Skip(now);
  return std::exchange(single_step_, SimTime(0));
}

void PacedRunner::Run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    SimTime next{0};
    SimTime wait{0};
    {
      const absl::MutexLock lock(&mutex_);
      next = Next();
      wait = is_paused_ ? kLongestWait : pace_.Wait(clock_->Now());
    }
    if (next > SimTime(0)) {
      step_(next);
      const absl::MutexLock lock(&mutex_);
      passed_ += next;
      continue;
    }
    absl::SleepFor(absl::FromChrono(std::min(wait, kLongestWait)));
  }
}

void PacedRunner::Pause() {
  const absl::MutexLock lock(&mutex_);
  is_paused_ = true;
}

void PacedRunner::Resume() {
  const absl::MutexLock lock(&mutex_);
  is_paused_ = false;
}

bool PacedRunner::is_paused() const {
  const absl::MutexLock lock(&mutex_);
  return is_paused_;
}

void PacedRunner::StepOnce(SimTime duration) {
  const absl::MutexLock lock(&mutex_);
  single_step_ += duration;
}

SimTime PacedRunner::passed() const {
  const absl::MutexLock lock(&mutex_);
  return passed_;
}

}  // namespace treeline::simulator
