// Keeps queries that failed, for debugging, within a bound on their size.
#ifndef SERVER_APP_FAILED_QUERY_RECORDER_H_
#define SERVER_APP_FAILED_QUERY_RECORDER_H_

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "common/metrics/registry.h"

namespace treeline::server_app {

// Whether it is what a kept query's files are called, without their ending:
// "20261126T045537.608Z-000001-TOO_FEW_INLIERS".
bool IsFailedQueryName(const std::string& name);

struct RecorderOptions {
  // Made, for this user alone, if it is not there.
  std::string folder = {};
  // Most that all kept queries may take on disk.
  uint64_t max_bytes = uint64_t{1} << 30;
  // What may wait to be written; more is dropped.
  size_t max_pending = 16;
  uint64_t max_pending_bytes = uint64_t{64} << 20;
};

struct FailedQuery {
  // "TOO_FEW_INLIERS", "INVALID_ARGUMENT": becomes part of the name.
  std::string reason = {};
  // treeline.v1.LocalizeRequest, serialized.
  std::string request = {};
  // About it, as a JSON object.
  std::string json = {};
};

// A query is FOLDER/TIME-NUMBER-REASON.binpb and, written before it, .json of
// the same name; each appears complete or not at all. The oldest are deleted to
// make room. Files with other names are left alone. Thread-safe.
class FailedQueryRecorder {
 public:
  using WallClock = std::function<std::chrono::system_clock::time_point()>;
  // Told of the first write that failed after one that did not, and with OK of
  // the first that succeeded again.
  using OnHealth = std::function<void(const absl::Status&)>;

  // Takes over what an earlier run left. Errors of the system name the folder.
  static absl::StatusOr<std::unique_ptr<FailedQueryRecorder>> Start(
      RecorderOptions options, WallClock wall_clock, OnHealth on_health);
  // Writes what waits, then returns.
  ~FailedQueryRecorder();

  // Whether a query of this size would be taken now: saves serializing it. If
  // not, it counts as dropped.
  bool HasRoomFor(uint64_t bytes);
  // Never blocks on the disk.
  void Offer(FailedQuery query);

  // Returns when everything offered before is on disk, or failed. For tests.
  void WaitUntilIdle();

  uint64_t written() const { return written_; }
  uint64_t dropped() const { return dropped_; }
  uint64_t failed() const { return failed_; }
  uint64_t bytes_on_disk() const { return bytes_on_disk_; }

 private:
  FailedQueryRecorder(RecorderOptions options, WallClock wall_clock,
                      OnHealth on_health);

  bool Fits(uint64_t bytes) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool HasWorkOrStops() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return stopping_ || !pending_.empty();
  }
  bool IsIdle() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return pending_.empty() && !writing_;
  }
  absl::Status Adopt();
  void Run();
  absl::Status Write(const FailedQuery& query);
  void DeleteOldest();
  std::string NextStem(const std::string& reason);

  const RecorderOptions options_;
  const WallClock wall_clock_;
  const OnHealth on_health_;
  std::atomic<uint64_t> written_ = 0;
  std::atomic<uint64_t> dropped_ = 0;
  std::atomic<uint64_t> failed_ = 0;
  std::atomic<uint64_t> bytes_on_disk_ = 0;

  absl::Mutex mutex_;
  std::deque<FailedQuery> pending_ ABSL_GUARDED_BY(mutex_);
  uint64_t pending_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;

  // Of the thread alone, once it runs: bytes by stem, the oldest first.
  std::map<std::string, uint64_t> kept_;
  uint64_t next_number_ = 1;
  bool healthy_ = true;
  std::thread thread_;
};

// treeline_recorded_queries_total and treeline_recorded_bytes. `recorder` must
// outlive the registry's use.
void AddRecorderMetrics(metrics::Registry& registry,
                        const FailedQueryRecorder& recorder);

}  // namespace treeline::server_app

#endif  // SERVER_APP_FAILED_QUERY_RECORDER_H_
