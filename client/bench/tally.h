// What came of the calls of a run.
#ifndef CLIENT_BENCH_TALLY_H_
#define CLIENT_BENCH_TALLY_H_

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "client/bench/answer_checker.h"
#include "client/bench/latency_histogram.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline::bench {

// What a call came to, as far as a load test is concerned.
enum class CallKind {
  kOk,         // answered: localized or not
  kShed,       // turned away by a server that has too much to do
  kDeadline,   // DEADLINE_EXCEEDED, whoever noticed
  kCancelled,  // by this client, or reported as such
  kFailed,     // anything else
};
inline constexpr int kCallKinds = 5;
const char* Name(CallKind kind);

// By CallKind.
using CallCounts = std::array<int64_t, kCallKinds>;

// One finished call.
struct CallResult {
  absl::Status status = {};
  // Whether the server said when to try again.
  bool pushback = false;
  // From the time it was to be sent, which for a closed loop is when it was.
  double latency_ms = 0;
  double from_send_ms = 0;
  // Seconds from the beginning of what is measured to when it was to be sent;
  // negative: of the warm-up.
  double scheduled_s = 0;
  // With an OK status.
  const v1::LocalizeResponse* response = nullptr;
  AnswerChecker::Verdict verdict = {};
};
CallKind KindOf(const CallResult& result);

struct Latencies {
  LatencyHistogram from_schedule;
  LatencyHistogram from_send;
};

// Where the server's time went, and what is left of the round trip.
struct ServerSplit {
  LatencyHistogram queue, decode, sample, forest, pose, localize, total;
  // Parts of `pose`.
  LatencyHistogram features, verify;
  // From sending to the answer, without the server's total: the wire, gRPC,
  // and this client.
  LatencyHistogram outside;
  // From sending to the answer, without decoding and localizing: all that the
  // service adds to its localizer.
  LatencyHistogram overhead;
};

struct Checks {
  int64_t as_before_load = 0;
  int64_t as_first_under_load = 0;
  int64_t first_of_a_version = 0;
  int64_t different = 0;
  int64_t with_truth = 0;
  int64_t within_tolerance = 0;
  int64_t wrong_poses = 0;
};

// A part of a run.
struct Interval {
  CallCounts counts = {};
  LatencyHistogram ok;
};

// By status code and reason; the reason is empty where the server gave none.
using OutcomeKey = std::pair<absl::StatusCode, std::string>;

// Everything about a run; copied out of the tally.
// (clang-tidy 14 takes the loop of its implicit copy for ours.)
// NOLINTNEXTLINE(bugprone-reserved-identifier)
struct TallyState {
  CallCounts counts = {};
  int64_t localized = 0;
  std::array<Latencies, kCallKinds> latencies;
  std::map<OutcomeKey, Latencies> outcomes;
  // Of each reasonless status one message, for people.
  std::map<OutcomeKey, std::string> messages;
  ServerSplit server;
  Checks checks;
  std::vector<Interval> intervals;
  std::map<std::string, int64_t> answered_by;  // "scene/version"

  int64_t total() const;
};

// What a progress line shows.
struct Glance {
  CallCounts counts = {};
  double p50_ms = 0;
  double p99_ms = 0;
};

// Thread-safe.
class Tally {
 public:
  // Results of the warm-up count among all calls alone.
  void Add(const CallResult& result);

  // Forgets what was measured. Intervals are this long from now on.
  void Reset(double interval_s = 1);

  // Of what is measured, since the last Reset.
  TallyState State() const;
  // The same in short, and fast.
  Glance Look() const;

  // Every call there was, warm-up included, since the beginning.
  std::map<OutcomeKey, int64_t> AllCalls() const;

 private:
  void AddAnswer(const CallResult& result)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  mutable absl::Mutex mutex_;
  TallyState state_ ABSL_GUARDED_BY(mutex_);
  double interval_s_ ABSL_GUARDED_BY(mutex_) = 1;
  std::map<OutcomeKey, int64_t> all_calls_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_TALLY_H_
