#include "server/tools/learning/live_feed.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "absl/time/time.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"

namespace treeline::learning {
namespace {

constexpr std::chrono::milliseconds kStopPoll{20};
constexpr uint64_t kMaxPictureBytes = uint64_t{64} << 20;

}  // namespace

LiveFeed::LiveFeed(std::unique_ptr<LiveSource> source,
                   const LiveFeedOptions& options, const std::stop_token& stop)
    : source_(std::move(source)),
      options_(options),
      on_stop_(stop, [this] { own_stop_.request_stop(); }),
      thread_([this] { Run(); }) {}

LiveFeed::~LiveFeed() { own_stop_.request_stop(); }

void LiveFeed::Run() {
  const std::stop_token stop = own_stop_.get_token();
  const base::MonotonicTime start = clock_.Now();
  for (int64_t number = 0;; ++number) {
    absl::StatusOr<std::optional<LiveItem>> item = source_->Next(stop);
    if (absl::IsInvalidArgument(item.status()) && !stop.stop_requested()) {
      absl::MutexLock lock(&mutex_);
      ++counts_.arrived;
      ++counts_.unreadable;
      counts_.first_unreadable.Update(item.status());
      continue;
    }
    if (!item.ok() || !*item || stop.stop_requested()) {
      absl::MutexLock lock(&mutex_);
      if (!stop.stop_requested()) status_ = item.status();
      ended_ = true;
      return;
    }
    if (auto* correction = std::get_if<PoseCorrection>(&**item)) {
      PushOther(std::move(*correction));
      continue;
    }
    if (std::holds_alternative<EndOfFrames>(**item)) {
      PushOther(EndOfFrames());
      continue;
    }
    if (options_.rate_hz > 0) {
      WaitUntil(start +
                std::chrono::duration_cast<base::MonotonicTime::duration>(
                    std::chrono::duration<double>(static_cast<double>(number) /
                                                  options_.rate_hz)));
      if (stop.stop_requested()) continue;
    }
    Push(std::get<LiveFrame>(**item), clock_.Now());
  }
}

void LiveFeed::WaitUntil(base::MonotonicTime due) const {
  while (!own_stop_.stop_requested()) {
    const base::MonotonicTime now = clock_.Now();
    if (now >= due) return;
    std::this_thread::sleep_for(
        std::min<base::MonotonicTime::duration>(due - now, kStopPoll));
  }
}

bool LiveFeed::TakeRoom() {
  const auto has_room = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return frames_ < options_.capacity;
  };
  absl::MutexLock lock(&mutex_);
  while (!has_room() && options_.waits && !own_stop_.stop_requested()) {
    mutex_.AwaitWithTimeout(absl::Condition(&has_room),
                            absl::FromChrono(kStopPoll));
  }
  return has_room();
}

void LiveFeed::Push(const LiveFrame& frame, base::MonotonicTime at) {
  const bool has_room = TakeRoom();
  {
    absl::MutexLock lock(&mutex_);
    ++counts_.arrived;
    counts_.skipped += has_room ? 0 : 1;
    last_arrival_ = at;
  }
  if (!has_room) return;
  ArrivedFrame arrived{.name = frame.color_path,
                       .color = {},
                       .depth = {},
                       .world_from_sensor = frame.world_from_sensor,
                       .at = at};
  absl::StatusOr<std::string> color =
      base::ReadFile(frame.color_path, kMaxPictureBytes);
  absl::StatusOr<std::string> depth =
      base::ReadFile(frame.depth_path, kMaxPictureBytes);
  if (!color.ok() || !depth.ok()) {
    CountUnreadable(color.ok() ? depth.status() : color.status());
    return;
  }
  arrived.color = *std::move(color);
  arrived.depth = *std::move(depth);
  absl::MutexLock lock(&mutex_);
  arrivals_.emplace_back(std::move(arrived));
  ++frames_;
}

void LiveFeed::PushOther(Arrival other) {
  absl::MutexLock lock(&mutex_);
  arrivals_.push_back(std::move(other));
}

std::optional<Arrival> LiveFeed::Next() {
  const auto is_ready = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return ended_ || !arrivals_.empty();
  };
  absl::MutexLock lock(&mutex_, absl::Condition(&is_ready));
  if (arrivals_.empty()) return std::nullopt;
  Arrival arrival = std::move(arrivals_.front());
  arrivals_.pop_front();
  if (std::holds_alternative<ArrivedFrame>(arrival)) --frames_;
  return arrival;
}

LiveFeedCounts LiveFeed::counts() const {
  absl::MutexLock lock(&mutex_);
  return counts_;
}

void LiveFeed::CountUnreadable(const absl::Status& why) {
  absl::MutexLock lock(&mutex_);
  ++counts_.unreadable;
  counts_.first_unreadable.Update(why);
}

base::MonotonicTime LiveFeed::last_arrival() const {
  absl::MutexLock lock(&mutex_);
  return last_arrival_;
}

absl::Status LiveFeed::status() const {
  absl::MutexLock lock(&mutex_);
  return status_;
}

}  // namespace treeline::learning
