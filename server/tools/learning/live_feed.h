// Frames at the pace at which they arrive, for a learner that may be slower.
#ifndef SERVER_TOOLS_LEARNING_LIVE_FEED_H_
#define SERVER_TOOLS_LEARNING_LIVE_FEED_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <variant>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "server/tools/learning/live_source.h"

namespace treeline::learning {

// A frame whose pictures were read; they are still encoded.
struct ArrivedFrame {
  std::string name;
  std::string color;
  std::string depth;
  geometry::Rigid3 world_from_sensor;
  base::MonotonicTime at;
};

using Arrival = std::variant<ArrivedFrame, PoseCorrection, EndOfFrames>;

struct LiveFeedOptions {
  // Frames a second that a source is asked for; 0: as fast as it gives them.
  double rate_hz = 0;
  // Where the learner is behind by `capacity` frames, the source waits for it
  // instead of frames being skipped.
  bool waits = false;
  // Frames that wait at most.
  size_t capacity = 60;
};

struct LiveFeedCounts {
  int64_t arrived = 0;  // skipped and unreadable ones among them
  int64_t skipped = 0;
  int64_t unreadable = 0;
  absl::Status first_unreadable;  // why
};

// Reads a source on a thread of its own. Thread-safe.
class LiveFeed {
 public:
  // Ends with the source, or soon after `stop`.
  LiveFeed(std::unique_ptr<LiveSource> source, const LiveFeedOptions& options,
           const std::stop_token& stop);
  ~LiveFeed();
  LiveFeed(const LiveFeed&) = delete;
  LiveFeed& operator=(const LiveFeed&) = delete;

  // Waits for what arrives; nullopt: nothing more. Frames may be skipped, all
  // else never is.
  std::optional<Arrival> Next();

  LiveFeedCounts counts() const;
  // What arrived could not be decoded, or learnt.
  void CountUnreadable(const absl::Status& why);
  // When the last frame arrived, skipped ones too.
  base::MonotonicTime last_arrival() const;
  // Why the source ended, if not because there are no more frames.
  absl::Status status() const;

 private:
  void Run();
  void WaitUntil(base::MonotonicTime due) const;
  // Whether there is room for a frame, for which it waits if it may.
  bool TakeRoom();
  void Push(const LiveFrame& frame, base::MonotonicTime at);
  void PushOther(Arrival other);

  const std::unique_ptr<LiveSource> source_;
  const LiveFeedOptions options_;
  const base::SteadyClock clock_;
  std::stop_source own_stop_;
  std::stop_callback<std::function<void()>> on_stop_;
  mutable absl::Mutex mutex_;
  std::deque<Arrival> arrivals_ ABSL_GUARDED_BY(mutex_);
  size_t frames_ ABSL_GUARDED_BY(mutex_) = 0;  // of these
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
  LiveFeedCounts counts_ ABSL_GUARDED_BY(mutex_);
  base::MonotonicTime last_arrival_ ABSL_GUARDED_BY(mutex_);
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
  std::jthread thread_;  // the last: it uses the others
};

}  // namespace treeline::learning

#endif  // SERVER_TOOLS_LEARNING_LIVE_FEED_H_
