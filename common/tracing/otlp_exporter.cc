#include "common/tracing/otlp_exporter.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "absl/time/time.h"
#include "common/base/status_macros.h"
#include "common/tracing/otlp_message.h"

namespace treeline::tracing {

absl::StatusOr<std::unique_ptr<OtlpExporter>> OtlpExporter::Start(
    const TracingOptions& options, const std::string& version,
    OnHealth on_health, const ExporterLimits& limits) {
  if (!options.enabled()) {
    return absl::InvalidArgumentError("traces have no address to go to");
  }
  TL_ASSIGN_OR_RETURN(std::unique_ptr<OtlpClient> client,
                      OtlpClient::Open(options));
  std::unique_ptr<OtlpExporter> exporter(new OtlpExporter(
      options, version, std::move(client), std::move(on_health), limits));
  exporter->thread_ = std::thread([self = exporter.get()] { self->Run(); });
  return exporter;
}

OtlpExporter::OtlpExporter(const TracingOptions& options, std::string version,
                           std::unique_ptr<OtlpClient> client,
                           OnHealth on_health, const ExporterLimits& limits)
    : resource_(options.resource),
      version_(std::move(version)),
      limits_(limits),
      on_health_(std::move(on_health)),
      client_(std::move(client)),
      next_wait_(limits.first_wait) {}

OtlpExporter::~OtlpExporter() { Stop(std::chrono::milliseconds(0)); }

void OtlpExporter::Add(std::vector<Span> spans) {
  const absl::MutexLock lock(&mutex_);
  if (stopping_ || queue_.size() + spans.size() > limits_.max_queued) {
    dropped_ += spans.size();
    return;
  }
  const bool was_empty = queue_.empty();
  std::move(spans.begin(), spans.end(), std::back_inserter(queue_));
  if (was_empty || queue_.size() >= limits_.max_batch) changed_.Signal();
}

void OtlpExporter::Stop(std::chrono::milliseconds patience) {
  {
    const absl::MutexLock lock(&mutex_);
    if (!stopping_) {
      stopping_ = true;
      give_up_ = std::chrono::steady_clock::now() + patience;
    }
    changed_.SignalAll();
  }
  if (thread_.joinable()) thread_.join();
}

SpanCounts OtlpExporter::counts() const {
  return {.sent = sent_, .dropped = dropped_, .failed = failed_};
}

bool OtlpExporter::GivesUp() const {
  const absl::MutexLock lock(&mutex_);
  return std::chrono::steady_clock::now() >= give_up_;
}

void OtlpExporter::Run() {
  for (;;) {
    const std::vector<Span> batch = NextBatch();
    if (batch.empty()) return;
    Deliver(batch);
  }
}

std::vector<Span> OtlpExporter::NextBatch() {
  const absl::MutexLock lock(&mutex_);
  while (queue_.empty() && !stopping_) changed_.Wait(&mutex_);
  const absl::Time ready = absl::Now() + absl::FromChrono(limits_.delay);
  while (queue_.size() < limits_.max_batch && !stopping_) {
    if (changed_.WaitWithDeadline(&mutex_, ready)) break;
  }
  const size_t count = std::min(queue_.size(), limits_.max_batch);
  const auto end = queue_.begin() + static_cast<std::ptrdiff_t>(count);
  std::vector<Span> batch(std::make_move_iterator(queue_.begin()),
                          std::make_move_iterator(end));
  queue_.erase(queue_.begin(), end);
  return batch;
}

void OtlpExporter::Deliver(const std::vector<Span>& batch) {
  const std::string message = OtlpMessage(resource_, version_, batch);
  for (int attempt = 1;; ++attempt) {
    if (GivesUp()) {
      dropped_ += batch.size();
      return;
    }
    const PostResult result =
        client_->Post(message, [this] { return GivesUp(); });
    if (absl::IsCancelled(result.status)) {
      dropped_ += batch.size();
      return;
    }
    NoteHealth(result.status);
    if (result.status.ok()) {
      sent_ += batch.size();
      next_wait_ = limits_.first_wait;
      return;
    }
    if (!absl::IsUnavailable(result.status)) {
      failed_ += batch.size();
      return;
    }
    const std::chrono::milliseconds wait =
        std::max(next_wait_, result.retry_after.value_or(next_wait_));
    next_wait_ = std::min(2 * next_wait_, limits_.longest_wait);
    // Who stops has no time for second tries.
    if (attempt >= limits_.max_attempts || !Wait(wait)) {
      (attempt >= limits_.max_attempts ? failed_ : dropped_) += batch.size();
      return;
    }
  }
}

bool OtlpExporter::Wait(std::chrono::milliseconds duration) {
  const absl::MutexLock lock(&mutex_);
  const absl::Time end = absl::Now() + absl::FromChrono(duration);
  while (!stopping_) {
    if (changed_.WaitWithDeadline(&mutex_, end)) break;
  }
  return !stopping_;
}

void OtlpExporter::NoteHealth(const absl::Status& status) {
  if (status.ok() == std::exchange(healthy_, status.ok())) return;
  if (on_health_) on_health_(status);
}

}  // namespace treeline::tracing
