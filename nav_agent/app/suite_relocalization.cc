#include "nav_agent/app/suite_relocalization.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace treeline {
namespace {

MonotonicTime Later(MonotonicTime time, double seconds) {
  return time + std::chrono::duration_cast<MonotonicTime::duration>(
                    std::chrono::duration<double>(seconds));
}

LocalizeQuery QueryOf(const RgbdFrame& frame, const std::string& scene,
                      uint64_t seed) {
  LocalizeQuery query;
  query.scene = scene;
  query.seed = seed;
  query.frame.color = frame.frame.color;
  if (frame.frame.depth.has_value()) {
    QueryDepth depth;
    depth.image = *frame.frame.depth;
    depth.unit_m = frame.frame.depth->unit_m;
    query.frame.depth = std::move(depth);
  }
  return query;
}

RelocalizationAnswer AnswerOf(const RgbdFrame& frame, LocalizeAnswer answer,
                              double round_trip_s) {
  return {.stamp = frame.stamp,
          .localized = answer.localized,
          .reason = std::move(answer.reason),
          .map_from_camera = answer.world_from_camera,
          .covariance = answer.covariance,
          .confidence = answer.confidence,
          .inliers = answer.inliers,
          .samples = answer.samples,
          .scene = std::move(answer.scene),
          .model_version = std::move(answer.model_version),
          .round_trip_s = round_trip_s};
}

}  // namespace

void SuiteRelocalization::Ask(const RgbdFrame& frame, double timeout_s) {
  CallOptions call;
  call.timeout = std::chrono::milliseconds(
      static_cast<int64_t>(1000 * options_.real_timeout_s));
  absl::StatusOr<LocalizeAnswer> answer =
      server_->Localize(QueryOf(frame, options_.scene, options_.seed), call);
  double takes_s = std::min(options_.latency_s, timeout_s);
  const absl::MutexLock lock(&mutex_);
  ++questions_;
  if (answer.ok()) {
    answer_ = AnswerOf(frame, *std::move(answer), takes_s);
  } else {
    if (absl::IsDeadlineExceeded(answer.status())) takes_s = timeout_s;
    answer_ = answer.status();
  }
  comes_at_ = Later(clock_->Now(), takes_s);
}

std::optional<absl::StatusOr<RelocalizationAnswer>>
SuiteRelocalization::TakeAnswer() {
  const absl::MutexLock lock(&mutex_);
  if (!answer_.has_value() || clock_->Now() < comes_at_) return std::nullopt;
  return std::exchange(answer_, std::nullopt);
}

bool SuiteRelocalization::IsAsking() const {
  const absl::MutexLock lock(&mutex_);
  return answer_.has_value();
}

void SuiteRelocalization::Cancel() {
  const absl::MutexLock lock(&mutex_);
  answer_.reset();
}

int SuiteRelocalization::questions() const {
  const absl::MutexLock lock(&mutex_);
  return questions_;
}

}  // namespace treeline
