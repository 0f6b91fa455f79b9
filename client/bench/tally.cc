#include "client/bench/tally.h"

#include <algorithm>
#include <numeric>

#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"

namespace treeline::bench {
namespace {

// A run of a day has so many seconds.
constexpr size_t kMaxIntervals = 24 * 3600;

void AddSplit(const CallResult& result, ServerSplit& server) {
  const v1::Timings& timings = result.response->timings();
  server.queue.Add(timings.queue_ms());
  server.decode.Add(timings.decode_ms());
  server.sample.Add(timings.sample_ms());
  server.forest.Add(timings.forest_ms());
  server.pose.Add(timings.pose_ms());
  server.features.Add(timings.features_ms());
  server.verify.Add(timings.verify_ms());
  server.localize.Add(timings.localize_ms());
  server.total.Add(timings.total_ms());
  server.outside.Add(result.from_send_ms - timings.total_ms());
  server.overhead.Add(result.from_send_ms - timings.decode_ms() -
                      timings.localize_ms());
}

void AddVerdict(const AnswerChecker::Verdict& verdict, Checks& checks) {
  switch (verdict.bits) {
    case AnswerChecker::Bits::kAsBeforeLoad:
      ++checks.as_before_load;
      break;
    case AnswerChecker::Bits::kAsFirstUnderLoad:
      ++checks.as_first_under_load;
      break;
    case AnswerChecker::Bits::kNew:
      ++checks.first_of_a_version;
      break;
    case AnswerChecker::Bits::kDifferent:
      ++checks.different;
      break;
  }
  if (verdict.within_tolerance) {
    ++checks.with_truth;
    checks.within_tolerance += *verdict.within_tolerance;
  }
  checks.wrong_poses += verdict.wrong_pose;
}

}  // namespace

const char* Name(CallKind kind) {
  switch (kind) {
    case CallKind::kOk:
      return "ok";
    case CallKind::kShed:
      return "shed";
    case CallKind::kDeadline:
      return "deadline";
    case CallKind::kCancelled:
      return "cancelled";
    case CallKind::kFailed:
      break;
  }
  return "failed";
}

CallKind KindOf(const CallResult& result) {
  switch (result.status.code()) {
    case absl::StatusCode::kOk:
      return CallKind::kOk;
    case absl::StatusCode::kDeadlineExceeded:
      return CallKind::kDeadline;
    case absl::StatusCode::kCancelled:
      return CallKind::kCancelled;
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kResourceExhausted:
      // The connection's own failures come without a word about later.
      return result.pushback || base::RetryAfterOf(result.status).has_value()
                 ? CallKind::kShed
                 : CallKind::kFailed;
    default:
      return CallKind::kFailed;
  }
}

int64_t TallyState::total() const {
  return std::accumulate(counts.begin(), counts.end(), int64_t{0});
}

void Tally::Add(const CallResult& result) {
  const auto kind = static_cast<size_t>(KindOf(result));
  const OutcomeKey key{result.status.code(),
                       base::ErrorInfoOf(result.status).reason};
  absl::MutexLock lock(&mutex_);
  ++all_calls_[key];
  if (result.scheduled_s < 0) return;
  ++state_.counts[kind];
  for (Latencies* latencies :
       {&state_.latencies[kind], &state_.outcomes[key]}) {
    latencies->from_schedule.Add(result.latency_ms);
    latencies->from_send.Add(result.from_send_ms);
  }
  if (!result.status.ok() && key.second.empty()) {
    state_.messages.try_emplace(key, result.status.message().data(),
                                result.status.message().size());
  }
  const size_t at = std::min(
      static_cast<size_t>(result.scheduled_s / interval_s_), kMaxIntervals - 1);
  if (at >= state_.intervals.size()) state_.intervals.resize(at + 1);
  ++state_.intervals[at].counts[kind];
  if (result.status.ok()) {
    state_.intervals[at].ok.Add(result.latency_ms);
    AddAnswer(result);
  }
}

void Tally::AddAnswer(const CallResult& result) {
  AddVerdict(result.verdict, state_.checks);
  if (result.response == nullptr) return;
  state_.localized += result.response->outcome() == v1::OUTCOME_LOCALIZED;
  ++state_.answered_by[absl::StrCat(result.response->scene(), "/",
                                    result.response->model_version())];
  // The GeoPose Protocol has none.
  if (result.response->has_timings()) AddSplit(result, state_.server);
}

TallyState Tally::State() const {
  absl::MutexLock lock(&mutex_);
  return state_;
}

Glance Tally::Look() const {
  absl::MutexLock lock(&mutex_);
  const LatencyHistogram& ok =
      state_.latencies[static_cast<size_t>(CallKind::kOk)].from_schedule;
  const Glance glance{.counts = state_.counts,
                      .p50_ms = ok.Percentile_ms(50),
                      .p99_ms = ok.Percentile_ms(99)};
  return glance;
}

void Tally::Reset(double interval_s) {
  absl::MutexLock lock(&mutex_);
  state_ = {};
  interval_s_ = interval_s;
}

std::map<OutcomeKey, int64_t> Tally::AllCalls() const {
  absl::MutexLock lock(&mutex_);
  return all_calls_;
}

}  // namespace treeline::bench
