// A line in the log for a finished call.
#ifndef SERVER_APP_CALL_LOG_H_
#define SERVER_APP_CALL_LOG_H_

#include <cstdint>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "common/log/log_line.h"
#include "common/log/program_log.h"
#include "server/service/call_observer.h"

namespace treeline::server_app {

// "rpc=Localize status=OK peer=... scene=... version=... outcome=LOCALIZED
// inliers=432 samples=500 queue_ms=0.0 decode_ms=2.9 ... total_ms=7.1" in one
// line, or the same as JSON. What a client chose is escaped.
logging::LogLine EventOf(const service::CallRecord& record,
                         logging::LogFormat format);

// Answered calls are logged at debug, calls that failed at info, and the
// server's own faults at error. Of failed calls at most kMaxLines a second are
// written; the next line says how many were not. Thread-safe.
class CallLog final : public service::CallObserver {
 public:
  static constexpr int kMaxLines = 20;

  // Both must outlive this.
  CallLog(logging::ProgramLog& log, const base::Clock& clock);
  void OnCall(const service::CallRecord& record) override;

 private:
  // Whether a failed call may be written now; if so, how many were not since.
  bool Admit(int64_t& suppressed);

  logging::ProgramLog& log_;
  const base::Clock& clock_;
  absl::Mutex mutex_;
  base::MonotonicTime window_start_ ABSL_GUARDED_BY(mutex_);
  int lines_in_window_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t suppressed_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace treeline::server_app

#endif  // SERVER_APP_CALL_LOG_H_
