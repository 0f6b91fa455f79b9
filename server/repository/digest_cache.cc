#include "server/repository/digest_cache.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <filesystem>
#include <iterator>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/descriptor.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "server/repository/retry.h"

namespace treeline::repository {
namespace {

namespace fs = std::filesystem;

constexpr char kFileSuffix[] = ".treeline";
constexpr char kPartSuffix[] = ".part";
// Between two looks at a part that another one writes.
constexpr std::chrono::milliseconds kLockPoll{20};
constexpr int64_t kNanosecondsPerSecond = 1000000000;

absl::Status CacheError(absl::string_view action, const std::string& path,
                        int error) {
  return base::WithReason(
      absl::ErrnoToStatus(error, absl::StrCat(action, " ", path)),
      "CACHE_FAILED");
}

absl::Status CacheFull(absl::string_view why) {
  return base::WithReason(
      absl::ResourceExhaustedError(absl::StrCat("cache of models: ", why)),
      "CACHE_FULL");
}

int64_t Nanoseconds(const timespec& time) {
  return time.tv_sec * kNanosecondsPerSecond + time.tv_nsec;
}

// Whether `path` is still the file that `fd` has open.
bool IsSameFile(int fd, const std::string& path) {
  struct stat open_one {};
  struct stat named {};
  return fstat(fd, &open_one) == 0 && stat(path.c_str(), &named) == 0 &&
         open_one.st_ino == named.st_ino && open_one.st_dev == named.st_dev;
}

bool HasSize(const std::string& path, uint64_t bytes) {
  struct stat info {};
  return stat(path.c_str(), &info) == 0 && S_ISREG(info.st_mode) &&
         static_cast<uint64_t>(info.st_size) == bytes;
}

absl::Status SyncFolder(const std::string& folder) {
  const base::Descriptor fd(
      open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (fd.get() < 0) return CacheError("opening", folder, errno);
  // Some file systems cannot.
  if (fsync(fd.get()) != 0 && errno != EINVAL && errno != EROFS) {
    return CacheError("syncing", folder, errno);
  }
  return absl::OkStatus();
}

// Deletes a part unless somebody writes it; whether it is gone.
bool RemoveUnlessWritten(const std::string& part) {
  const base::Descriptor fd(open(part.c_str(), O_RDWR | O_CLOEXEC));
  return fd.get() >= 0 && flock(fd.get(), LOCK_EX | LOCK_NB) == 0 &&
         IsSameFile(fd.get(), part) && unlink(part.c_str()) == 0;
}

}  // namespace

CacheDownload::CacheDownload(DigestCache& cache, std::string digest,
                             uint64_t bytes, int fd)
    : cache_(cache), digest_(std::move(digest)), promised_(bytes), fd_(fd) {}

CacheDownload::~CacheDownload() {
  if (size_ == 0) Discard();
  close(fd_);
  cache_.Release(digest_);
}

// By name, but only while the lock is held, so that nobody else has the name.
void CacheDownload::Discard() {
  if (!gone_) unlink(cache_.PartPathOf(digest_).c_str());
  gone_ = true;
}

absl::Status CacheDownload::TakeWhatIsThere(const std::stop_token& stop) {
  std::vector<char> step(1u << 20);
  while (true) {
    if (stop.stop_requested()) return absl::CancelledError("cancelled");
    const ssize_t got = read(fd_, step.data(), step.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    hash_.Update(absl::string_view(step.data(), static_cast<size_t>(got)));
    size_ += static_cast<uint64_t>(got);
  }
  resumed_ = size_ > 0;
  // A complete part may be one whose owner died before it could be verified.
  return size_ > promised_ ? Restart() : absl::OkStatus();
}

absl::Status CacheDownload::Restart() {
  if (ftruncate(fd_, 0) != 0 || lseek(fd_, 0, SEEK_SET) != 0) {
    return CacheError("emptying", cache_.PartPathOf(digest_), errno);
  }
  size_ = 0;
  resumed_ = false;
  hash_ = Sha256();
  return absl::OkStatus();
}

absl::Status CacheDownload::WriteError(int error) {
  const std::string path = cache_.PartPathOf(digest_);
  Discard();
  if (error == ENOSPC || error == EDQUOT || error == EFBIG) {
    return CacheFull(absl::StrCat("no space for ", promised_, " bytes"));
  }
  return CacheError("writing", path, error);
}

absl::Status CacheDownload::Append(absl::string_view bytes) {
  if (bytes.size() > promised_ - size_) {
    return base::WithReason(
        absl::DataLossError(absl::StrCat("longer than the ", promised_,
                                         " bytes that the index promises")),
        "MODEL_CORRUPT");
  }
  hash_.Update(bytes);
  while (!bytes.empty()) {
    const ssize_t written = write(fd_, bytes.data(), bytes.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return WriteError(errno);
    }
    size_ += static_cast<uint64_t>(written);
    bytes.remove_prefix(static_cast<size_t>(written));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> CacheDownload::Commit() {
  const std::string part = cache_.PartPathOf(digest_);
  const std::string path = cache_.PathOf(digest_);
  if (size_ != promised_ || hash_.Finish() != digest_) {
    Discard();
    return base::WithReason(
        absl::DataLossError(
            size_ == promised_
                ? "its SHA-256 is not that of the index"
                : absl::StrCat("it has ", size_,
                               " bytes, and the index promises ", promised_)),
        "MODEL_CORRUPT");
  }
  if (fsync(fd_) != 0 && errno != EINVAL && errno != EROFS) {
    return WriteError(errno);
  }
  cache_.HandOut(digest_);
  if (rename(part.c_str(), path.c_str()) != 0) {
    const int error = errno;
    Discard();
    return CacheError("renaming to", path, error);
  }
  gone_ = true;
  TL_RETURN_IF_ERROR(SyncFolder(cache_.folder_));
  return path;
}

DigestCache::DigestCache(DigestCacheOptions options, const base::Clock& clock)
    : options_(std::move(options)),
      folder_(options_.folder + "/sha256"),
      clock_(clock) {}

absl::StatusOr<std::unique_ptr<DigestCache>> DigestCache::Open(
    DigestCacheOptions options, const base::Clock& clock) {
  std::unique_ptr<DigestCache> cache(
      new DigestCache(std::move(options), clock));
  std::error_code error;
  fs::create_directories(cache->folder_, error);
  if (error) return CacheError("making", cache->folder_, error.value());
  if (access(cache->folder_.c_str(), R_OK | W_OK | X_OK) != 0) {
    return CacheError("writing into", cache->folder_, errno);
  }
  cache->RemoveStaleParts();
  return cache;
}

std::string DigestCache::PathOf(const std::string& digest) const {
  return absl::StrCat(folder_, "/", digest, kFileSuffix);
}

std::string DigestCache::PartPathOf(const std::string& digest) const {
  return absl::StrCat(folder_, "/", digest, kPartSuffix);
}

void DigestCache::RemoveStaleParts() const {
  const int64_t now_s = std::time(nullptr);
  std::error_code error;
  for (fs::directory_iterator entry(folder_, error);
       !error && entry != fs::directory_iterator(); entry.increment(error)) {
    const std::string path = entry->path().string();
    struct stat info {};
    if (!absl::EndsWith(path, kPartSuffix) || stat(path.c_str(), &info) != 0 ||
        now_s - info.st_mtim.tv_sec < options_.stale_after.count()) {
      continue;
    }
    RemoveUnlessWritten(path);
  }
}

absl::StatusOr<std::string> DigestCache::Find(const std::string& digest,
                                              uint64_t bytes,
                                              const std::stop_token& stop) {
  const std::string path = PathOf(digest);
  // Before it is looked at, so that nobody of this process deletes it then.
  HandOut(digest);
  if (!HasSize(path, bytes)) {
    return absl::NotFoundError(absl::StrCat("no ", path));
  }
  if (options_.verify) TL_RETURN_IF_ERROR(Verify(path, digest, stop));
  // What was used longest ago is known by the time of its last change.
  utimensat(AT_FDCWD, path.c_str(), nullptr, 0);
  return path;
}

absl::Status DigestCache::Verify(const std::string& path,
                                 const std::string& digest,
                                 const std::stop_token& stop) const {
  const base::Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  const absl::StatusOr<FileDigest> read = DigestOfFile(path, stop);
  if (absl::IsCancelled(read.status())) return read.status();
  if (read.ok() && read->sha256 == digest) return absl::OkStatus();
  // Unless another one has put a sound one there meanwhile.
  if (IsSameFile(file.get(), path)) unlink(path.c_str());
  return absl::NotFoundError(absl::StrCat(path, " was not sound"));
}

void DigestCache::HandOut(const std::string& digest) {
  const base::MonotonicTime now = clock_.Now();
  absl::MutexLock lock(&mutex_);
  for (auto entry = handed_out_.begin(); entry != handed_out_.end();) {
    const bool over = now - entry->second >= options_.handed_out;
    entry = over ? handed_out_.erase(entry) : std::next(entry);
  }
  handed_out_[digest + kFileSuffix] = now;
}

absl::StatusOr<std::unique_ptr<CacheDownload>> DigestCache::Begin(
    const std::string& digest, uint64_t bytes, const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const int fd, LockPart(digest, bytes, stop));
  if (fd < 0) return nullptr;
  // Releases the lock wherever this returns.
  std::unique_ptr<CacheDownload> download(
      new CacheDownload(*this, digest, bytes, fd));
  TL_RETURN_IF_ERROR(download->TakeWhatIsThere(stop));
  if (absl::Status room = Reserve(digest, bytes, download->size());
      !room.ok()) {
    download->Discard();
    return room;
  }
  return download;
}

// -1: the file is in place.
absl::StatusOr<int> DigestCache::LockPart(const std::string& digest,
                                          uint64_t bytes,
                                          const std::stop_token& stop) const {
  const std::string part = PartPathOf(digest);
  base::MonotonicTime last_progress = clock_.Now();
  int64_t last_size = -1;
  while (!stop.stop_requested()) {
    if (HasSize(PathOf(digest), bytes)) return -1;
    const int fd = open(part.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (fd < 0 && (errno == ENOSPC || errno == EDQUOT)) {
      return CacheFull("no space for another file");
    }
    if (fd < 0) return CacheError("creating", part, errno);
    if (flock(fd, LOCK_EX | LOCK_NB) == 0) {
      // Who had the lock may have renamed or deleted the file.
      if (IsSameFile(fd, part)) return fd;
      close(fd);
      continue;
    }
    struct stat info {};
    fstat(fd, &info);
    close(fd);
    const base::MonotonicTime now = clock_.Now();
    if (info.st_size != last_size) last_progress = now;
    last_size = info.st_size;
    if (now - last_progress > options_.patience) {
      return base::WithReason(
          absl::UnavailableError(absl::StrCat("another process fetches ",
                                              digest, " without progress")),
          "CACHE_BUSY");
    }
    SleepUnlessStopped(kLockPoll, stop);
  }
  return absl::CancelledError("cancelled");
}

std::vector<DigestCache::CachedFile> DigestCache::Files(
    const std::map<std::string, uint64_t>& reserved) const {
  std::vector<CachedFile> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder_, error);
       !error && entry != fs::directory_iterator(); entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    struct stat info {};
    if (stat(entry->path().c_str(), &info) != 0 || !S_ISREG(info.st_mode) ||
        reserved.count(std::string(absl::StripSuffix(name, kPartSuffix))) > 0) {
      continue;
    }
    files.push_back(
        {name, static_cast<uint64_t>(info.st_size), Nanoseconds(info.st_mtim)});
  }
  std::sort(files.begin(), files.end(),
            [](const CachedFile& a, const CachedFile& b) {
              return a.used_ns < b.used_ns;
            });
  return files;
}

bool DigestCache::Fits(uint64_t used, uint64_t to_write) const {
  if (options_.limit_bytes > 0 && used > options_.limit_bytes) return false;
  struct statvfs disk {};
  if (statvfs(folder_.c_str(), &disk) != 0) return true;
  return uint64_t{disk.f_bavail} * disk.f_frsize >= to_write;
}

std::shared_ptr<const void> DigestCache::Keep(const std::string& digest) {
  absl::MutexLock lock(&mutex_);
  std::erase_if(kept_, [](const auto& item) { return item.second.expired(); });
  std::weak_ptr<const void>& kept = kept_[digest + kFileSuffix];
  std::shared_ptr<const void> hold = kept.lock();
  if (hold == nullptr) {
    hold = std::make_shared<const char>();
    kept = hold;
  }
  return hold;
}

bool DigestCache::MayGo(const std::string& name) const {
  const auto kept = kept_.find(name);
  if (kept != kept_.end() && !kept->second.expired()) return false;
  const auto handed_out = handed_out_.find(name);
  return handed_out == handed_out_.end() ||
         clock_.Now() - handed_out->second >= options_.handed_out;
}

absl::Status DigestCache::Reserve(const std::string& digest, uint64_t bytes,
                                  uint64_t there) {
  absl::MutexLock lock(&mutex_);
  std::map<std::string, uint64_t> reserved = reserved_;
  reserved[digest] = bytes;
  const std::vector<CachedFile> files = Files(reserved);
  uint64_t used = 0;
  for (const CachedFile& file : files) used += file.bytes;
  for (const auto& [name, promised] : reserved) used += promised;
  const uint64_t to_write = bytes - there;
  for (const CachedFile& file : files) {
    if (Fits(used, to_write)) break;
    const std::string path = absl::StrCat(folder_, "/", file.name);
    const bool gone = absl::EndsWith(file.name, kPartSuffix)
                          ? RemoveUnlessWritten(path)
                          : MayGo(file.name) && unlink(path.c_str()) == 0;
    if (gone) used -= file.bytes;
  }
  if (!Fits(used, to_write)) {
    return CacheFull(
        absl::StrCat(bytes, " bytes do not fit beside ", used - bytes,
                     " that are in use or being fetched",
                     options_.limit_bytes > 0
                         ? absl::StrCat("; the limit is ", options_.limit_bytes)
                         : ""));
  }
  reserved_[digest] = bytes;
  return absl::OkStatus();
}

void DigestCache::Release(const std::string& digest) {
  absl::MutexLock lock(&mutex_);
  reserved_.erase(digest);
}

}  // namespace treeline::repository
