// The relocalization port of suites: a real server is asked through real
// sockets, and simulated time passes as if it had answered in a fixed time.
#ifndef NAV_AGENT_APP_SUITE_RELOCALIZATION_H_
#define NAV_AGENT_APP_SUITE_RELOCALIZATION_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "client/relocalizer/relocalizer.h"
#include "common/base/clock.h"
#include "nav_agent/core/relocalization.h"

namespace treeline {

struct SuiteRelocalizationOptions {
  std::string scene;
  uint64_t seed = 0;
  // What an answer takes in simulated time (s): the server's 0.1 s, the way
  // there and back over a wireless network, with room to spare.
  double latency_s = 0.5;
  // What a call may take in real time (s). Then it is DEADLINE_EXCEEDED, and
  // comes when the question's own time is over.
  double real_timeout_s = 60;
};

// Ask waits for the server in real time, so that a run's result depends neither
// on how fast this machine is nor on what else it does.
class SuiteRelocalization final : public RelocalizationPort {
 public:
  // Both must outlive it. The clock is the simulation's.
  SuiteRelocalization(Relocalizer& server, const Clock& clock,
                      const SuiteRelocalizationOptions& options)
      : server_(&server), clock_(&clock), options_(options) {}

  void Ask(const RgbdFrame& frame, double timeout_s) override;
  std::optional<absl::StatusOr<RelocalizationAnswer>> TakeAnswer() override;
  bool IsAsking() const override;
  void Cancel() override;

  // How often it was asked.
  int questions() const;

 private:
  Relocalizer* server_;
  const Clock* clock_;
  SuiteRelocalizationOptions options_;
  mutable absl::Mutex mutex_;
  std::optional<absl::StatusOr<RelocalizationAnswer>> answer_
      ABSL_GUARDED_BY(mutex_);
  MonotonicTime comes_at_ ABSL_GUARDED_BY(mutex_);
  int questions_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace treeline

#endif  // NAV_AGENT_APP_SUITE_RELOCALIZATION_H_
