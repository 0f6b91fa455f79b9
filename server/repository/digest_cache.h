// Fetched models in a folder, each named by its digest:
//
//   FOLDER/sha256/<digest>.treeline  complete and once verified
//   FOLDER/sha256/<digest>.part      being fetched, or left by one who died
//
// Several processes may share a folder.
#ifndef SERVER_REPOSITORY_DIGEST_CACHE_H_
#define SERVER_REPOSITORY_DIGEST_CACHE_H_

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "server/repository/sha256.h"

namespace treeline::repository {

struct DigestCacheOptions {
  // Made where missing.
  std::string folder;
  // Of all files together; 0: as much as the disk holds. What was used longest
  // ago makes room, but not what this process keeps (Keep) or was handed within
  // `handed_out`. Another process may lose a file that it keeps: it fetches the
  // file again when it opens it again.
  uint64_t limit_bytes = 0;
  std::chrono::milliseconds handed_out{60000};
  // Parts that nobody writes and that nobody went on with for so long go when
  // the cache is opened.
  std::chrono::seconds stale_after{3600};
  // Read and hash a file each time it is asked for.
  bool verify = false;
  // For how long another process may leave a part as it is before those who
  // wait for it give up.
  std::chrono::milliseconds patience{60000};
};

class DigestCache;

// A part that this process alone writes. Stays for a later attempt when the
// object goes, unless it was discarded or empty. Not thread-safe.
class CacheDownload {
 public:
  ~CacheDownload();
  CacheDownload(const CacheDownload&) = delete;
  CacheDownload& operator=(const CacheDownload&) = delete;

  // Bytes that are there.
  uint64_t size() const { return size_; }
  // Bytes that there should be.
  uint64_t promised() const { return promised_; }
  // Whether some were there when it began.
  bool resumed() const { return resumed_; }
  // Forgets what is there.
  absl::Status Restart();
  // DATA_LOSS: more than was promised. RESOURCE_EXHAUSTED, CACHE_FULL: no
  // space; the part is gone then.
  absl::Status Append(absl::string_view bytes);
  // Puts the file in place and returns its path. DATA_LOSS, MODEL_CORRUPT: it
  // is not what was promised; the part is gone then.
  absl::StatusOr<std::string> Commit();

 private:
  friend class DigestCache;
  CacheDownload(DigestCache& cache, std::string digest, uint64_t bytes, int fd);
  absl::Status TakeWhatIsThere(const std::stop_token& stop);
  absl::Status WriteError(int error);
  void Discard();

  DigestCache& cache_;
  const std::string digest_;
  const uint64_t promised_;
  int fd_;  // holds the lock of the part
  uint64_t size_ = 0;
  bool resumed_ = false;
  bool gone_ = false;
  Sha256 hash_;
};

// Thread-safe.
class DigestCache {
 public:
  static absl::StatusOr<std::unique_ptr<DigestCache>> Open(
      DigestCacheOptions options, const base::Clock& clock);

  // The path of a file that is there, and counts as used now. NOT_FOUND: it is
  // not, or was not what it should be and is gone.
  absl::StatusOr<std::string> Find(const std::string& digest, uint64_t bytes,
                                   const std::stop_token& stop);

  // Makes room for a file and waits until nobody else writes its part. Null:
  // another one has put it in place meanwhile. RESOURCE_EXHAUSTED, CACHE_FULL;
  // UNAVAILABLE: who writes it makes no progress; CANCELLED.
  absl::StatusOr<std::unique_ptr<CacheDownload>> Begin(
      const std::string& digest, uint64_t bytes, const std::stop_token& stop);

  // While what is returned lives, the file is not deleted to make room for
  // others. It need not be there yet.
  std::shared_ptr<const void> Keep(const std::string& digest)
      ABSL_LOCKS_EXCLUDED(mutex_);

  std::string PathOf(const std::string& digest) const;

 private:
  friend class CacheDownload;
  struct CachedFile {
    std::string name;
    uint64_t bytes = 0;
    int64_t used_ns = 0;
  };

  DigestCache(DigestCacheOptions options, const base::Clock& clock);
  std::string PartPathOf(const std::string& digest) const;
  void RemoveStaleParts() const;
  absl::StatusOr<int> LockPart(const std::string& digest, uint64_t bytes,
                               const std::stop_token& stop) const;
  absl::Status Verify(const std::string& path, const std::string& digest,
                      const std::stop_token& stop) const;
  // Reserves `bytes`, of which some are there, until Release().
  absl::Status Reserve(const std::string& digest, uint64_t bytes,
                       uint64_t there) ABSL_LOCKS_EXCLUDED(mutex_);
  void Release(const std::string& digest) ABSL_LOCKS_EXCLUDED(mutex_);
  void HandOut(const std::string& digest) ABSL_LOCKS_EXCLUDED(mutex_);
  // All but parts of `reserved`; what was used longest ago comes first.
  std::vector<CachedFile> Files(
      const std::map<std::string, uint64_t>& reserved) const;
  // Whether `used` is within the limit, and the disk holds `to_write` more.
  bool Fits(uint64_t used, uint64_t to_write) const;
  bool MayGo(const std::string& name) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const DigestCacheOptions options_;
  const std::string folder_;
  const base::Clock& clock_;
  absl::Mutex mutex_;
  std::map<std::string, uint64_t> reserved_ ABSL_GUARDED_BY(mutex_);
  // By file name, as the next.
  std::map<std::string, base::MonotonicTime> handed_out_
      ABSL_GUARDED_BY(mutex_);
  std::map<std::string, std::weak_ptr<const void>> kept_
      ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_DIGEST_CACHE_H_
