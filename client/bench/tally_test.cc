#include "client/bench/tally.h"

#include <chrono>

#include "common/base/error_info.h"
#include "gtest/gtest.h"

namespace treeline::bench {
namespace {

CallResult Failure(const absl::Status& status) {
  return {.status = status, .latency_ms = 5, .from_send_ms = 5};
}

int64_t Count(const TallyState& state, CallKind kind) {
  return state.counts[static_cast<size_t>(kind)];
}

TEST(KindOf, ShedIsWhatTheServerAskedToTryLater) {
  const absl::Status plain = absl::UnavailableError("connection refused");
  EXPECT_EQ(KindOf(Failure(plain)), CallKind::kFailed);
  EXPECT_EQ(
      KindOf(Failure(base::WithRetryAfter(plain, std::chrono::seconds(1)))),
      CallKind::kShed);
  CallResult with_trailer = Failure(plain);
  with_trailer.pushback = true;
  EXPECT_EQ(KindOf(with_trailer), CallKind::kShed);
}

TEST(KindOf, CodesHaveTheirKinds) {
  EXPECT_EQ(KindOf({}), CallKind::kOk);
  EXPECT_EQ(KindOf(Failure(absl::DeadlineExceededError("late"))),
            CallKind::kDeadline);
  EXPECT_EQ(KindOf(Failure(absl::CancelledError(""))), CallKind::kCancelled);
  EXPECT_EQ(KindOf(Failure(absl::InternalError(""))), CallKind::kFailed);
}

TEST(Tally, CountsByKindAndByReason) {
  Tally tally;
  tally.Add({});
  tally.Add({});
  tally.Add(
      Failure(base::WithReason(absl::NotFoundError("attic"), "NO_SCENE")));
  tally.Add(Failure(absl::NotFoundError("what")));
  const TallyState state = tally.State();
  EXPECT_EQ(state.total(), 4);
  EXPECT_EQ(Count(state, CallKind::kOk), 2);
  EXPECT_EQ(Count(state, CallKind::kFailed), 2);
  const OutcomeKey with_reason{absl::StatusCode::kNotFound, "NO_SCENE"};
  const OutcomeKey without{absl::StatusCode::kNotFound, ""};
  EXPECT_EQ(state.outcomes.at(with_reason).from_send.count(), 1);
  EXPECT_EQ(state.outcomes.at(without).from_send.count(), 1);
  EXPECT_EQ(state.messages.at(without), "what");
  EXPECT_EQ(state.messages.count(with_reason), 0u);
  EXPECT_EQ(tally.AllCalls().at(with_reason), 1);
}

TEST(Tally, TheWarmUpIsAmongAllCallsAlone) {
  Tally tally;
  tally.Add({.latency_ms = 3, .scheduled_s = -0.5});
  EXPECT_EQ(tally.State().total(), 0);
  EXPECT_EQ(tally.AllCalls().at({absl::StatusCode::kOk, ""}), 1);
}

TEST(Tally, SecondsAreThoseOfTheSchedule) {
  Tally tally;
  tally.Add({.latency_ms = 1, .scheduled_s = 0.9});
  tally.Add({.latency_ms = 4000, .scheduled_s = 2.0});
  const TallyState state = tally.State();
  ASSERT_EQ(state.intervals.size(), 3u);
  EXPECT_EQ(state.intervals[0].counts[0], 1);
  EXPECT_EQ(state.intervals[1].counts[0], 0);
  EXPECT_EQ(state.intervals[2].ok.max_ms(), 4000);
}

TEST(Tally, IntervalsMayBeLonger) {
  Tally tally;
  tally.Reset(5);
  tally.Add({.scheduled_s = 4.9});
  tally.Add({.scheduled_s = 5.1});
  const TallyState state = tally.State();
  ASSERT_EQ(state.intervals.size(), 2u);
  EXPECT_EQ(state.intervals[1].counts[0], 1);
}

TEST(Tally, AnswersAreSplitAndChecked) {
  v1::LocalizeResponse response;
  response.set_outcome(v1::OUTCOME_LOCALIZED);
  response.set_scene("room");
  response.set_model_version("2");
  response.mutable_timings()->set_queue_ms(1);
  response.mutable_timings()->set_decode_ms(2);
  response.mutable_timings()->set_localize_ms(4);
  response.mutable_timings()->set_total_ms(8);
  Tally tally;
  tally.Add({.latency_ms = 12,
             .from_send_ms = 10,
             .response = &response,
             .verdict = {.bits = AnswerChecker::Bits::kAsBeforeLoad,
                         .within_tolerance = true}});
  const TallyState state = tally.State();
  EXPECT_EQ(state.localized, 1);
  EXPECT_EQ(state.answered_by.at("room/2"), 1);
  EXPECT_EQ(state.checks.as_before_load, 1);
  EXPECT_EQ(state.checks.within_tolerance, 1);
  EXPECT_EQ(state.server.queue.max_ms(), 1);
  EXPECT_EQ(state.server.outside.max_ms(), 2);
  EXPECT_EQ(state.server.overhead.max_ms(), 4);
}

TEST(Tally, ResetForgetsWhatWasMeasured) {
  Tally tally;
  tally.Add({});
  tally.Reset();
  EXPECT_EQ(tally.State().total(), 0);
  EXPECT_EQ(tally.Look().counts[0], 0);
  EXPECT_EQ(tally.AllCalls().size(), 1u);
}

}  // namespace
}  // namespace treeline::bench
