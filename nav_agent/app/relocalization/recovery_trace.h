// A lost robot's way back as one trace: its search, the questions that it asks
// a server, and what its checks make of the answers.
#ifndef NAV_AGENT_APP_RELOCALIZATION_RECOVERY_TRACE_H_
#define NAV_AGENT_APP_RELOCALIZATION_RECOVERY_TRACE_H_

#include <functional>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "common/tracing/tracer.h"
#include "nav_agent/core/relocalization.h"

namespace treeline::relocalization {

// Spans:
//   recovery      from the moment that it counts as lost until it is found, is
//                 told, or gives up and needs help
//     treeline.v1.RelocalizationService/Localize
//                 a question, with the encoding of its picture; the server's
//                 span is its child
//     fix gate    from the answer to the verdict of gravity, map and laser
// A question that is asked while it is not lost begins a trace of its own.
// Nothing of pictures. Thread-safe.
class RecoveryTrace {
 public:
  using WallClock = std::function<tracing::WallTime()>;

  // `tracer` must outlive it.
  RecoveryTrace(tracing::Tracer& tracer, WallClock wall_clock)
      : tracer_(tracer), wall_clock_(std::move(wall_clock)) {}
  // A recovery that lasts ends as "stopped".
  void Stop();

  // An event of the navigator: those of RelocalizationNote count.
  void OnEvent(const std::string& kind, const std::string& text);

  // A question begins; one that is open ends as cancelled. What the call takes
  // along.
  std::string BeginQuestion();
  // It ends with this answer or error; nothing, if none is open.
  void EndQuestion(const absl::StatusOr<core::RelocalizationAnswer>& answer);
  void CancelQuestion();

 private:
  struct Open {
    tracing::TraceContext context;
    std::string parent_span_id;
    tracing::WallTime start;
  };

  tracing::Span Ended(const Open& open, std::string name) const;
  void BeginRecovery(const std::string& why)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void EndRecovery(const std::string& outcome, const std::string& text)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Ends it, and sends it.
  void EndQuestion(tracing::Attributes attributes, const absl::Status& status)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void EndJudgement(const std::string& verdict)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  tracing::Tracer& tracer_;
  const WallClock wall_clock_;
  absl::Mutex mutex_;
  std::optional<Open> recovery_ ABSL_GUARDED_BY(mutex_);
  std::string cause_ ABSL_GUARDED_BY(mutex_);
  int questions_ ABSL_GUARDED_BY(mutex_) = 0;
  std::optional<Open> question_ ABSL_GUARDED_BY(mutex_);
  // Of an answer that nobody has judged yet.
  std::optional<Open> judgement_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::relocalization

#endif  // NAV_AGENT_APP_RELOCALIZATION_RECOVERY_TRACE_H_
