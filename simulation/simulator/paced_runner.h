// Lets simulated time pass as fast as real time, or at another pace.
#ifndef SIMULATION_SIMULATOR_PACED_RUNNER_H_
#define SIMULATION_SIMULATOR_PACED_RUNNER_H_

#include <functional>
#include <optional>
#include <stop_token>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "simulation/simulator/fault.h"

namespace treeline::simulator {

// How much simulated time is due when. Where the simulation cannot keep up, it
// falls behind real time rather than hurrying afterwards. Not thread-safe.
class Pace {
 public:
  // factor: simulated seconds in a real one; infinity: as many as can be.
  explicit Pace(double factor) : factor_(factor) {}

  // Simulated time that should pass now, at most kMaxAtOnce.
  SimTime Due(base::MonotonicTime now);
  // Real time until something is due. Zero while it is.
  SimTime Wait(base::MonotonicTime now) const;
  // Nothing is due for the real time until now: somebody had paused it.
  void Skip(base::MonotonicTime now) { last_ = now; }

  static constexpr SimTime kMaxAtOnce = std::chrono::milliseconds(100);
  static constexpr SimTime kMin = std::chrono::milliseconds(5);

 private:
  double factor_;
  std::optional<base::MonotonicTime> last_;
};

// Runs `step` at a pace, and can be paused and stepped. Thread-safe.
class PacedRunner {
 public:
  // step: lets simulated time pass, called by the thread that calls Run, never
  // twice at once. clock: real time; must outlive the runner.
  PacedRunner(std::function<void(SimTime)> step, double factor,
              const base::Clock& clock);

  // Returns when a stop is requested.
  void Run(const std::stop_token& stop);

  // Pause returns at once; the step that is being taken is finished.
  void Pause();
  void Resume();
  bool is_paused() const;
  // While paused: lets so much pass, once.
  void StepOnce(SimTime duration);
  // Simulated time that has passed in Run.
  SimTime passed() const;

 private:
  // Under the lock: what is to be done now, zero for nothing.
  SimTime Next() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::function<void(SimTime)> step_;
  const base::Clock* clock_;
  mutable absl::Mutex mutex_;
  Pace pace_ ABSL_GUARDED_BY(mutex_);
  bool is_paused_ ABSL_GUARDED_BY(mutex_) = false;
  SimTime single_step_ ABSL_GUARDED_BY(mutex_){0};
  SimTime passed_ ABSL_GUARDED_BY(mutex_){0};
};

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_PACED_RUNNER_H_
