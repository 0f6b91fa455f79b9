// One connection of a client, as a FloodGuard judges it.
#ifndef COMMON_FLOOD_GUARD_WATCHED_CONNECTION_H_
#define COMMON_FLOOD_GUARD_WATCHED_CONNECTION_H_

#include <atomic>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "common/flood_guard/flood_guard.h"
#include "common/flood_guard/frame_counter.h"

namespace treeline::flood_guard {

// Thread-safe; the bytes of a connection must come in their order.
class WatchedConnection {
 public:
  // nullptr: the guard does not let it in.
  static std::shared_ptr<WatchedConnection> Open(
      std::shared_ptr<FloodGuard> guard, std::string address, std::string peer);
  ~WatchedConnection();
  WatchedConnection(const WatchedConnection&) = delete;
  WatchedConnection& operator=(const WatchedConnection&) = delete;

  enum class Verdict {
    kGoOn,
    // The same; and now client_random() is known.
    kTlsBegins,
    kCut,
  };
  // The next bytes from the socket. HTTP/2 is counted; of TLS only the
  // beginning is looked at (RFC 8446, section 4.1.2): 43 bytes, which every
  // client sends in one record.
  Verdict Receive(absl::string_view bytes);
  // The next bytes that were decrypted; false: it is cut.
  bool Decrypted(absl::string_view bytes);
  // For what only its owner can see.
  void Cut(CutReason reason);

  bool is_cut() const { return is_cut_.load(std::memory_order_relaxed); }
  // The 32 bytes by which a TLS connection can be told from all others.
  std::string client_random() const;
  const FloodGuard& guard() const { return *guard_; }

 private:
  enum class Kind { kUnknown, kHttp2, kTls };

  WatchedConnection(std::shared_ptr<FloodGuard> guard, std::string address,
                    std::string peer)
      : guard_(std::move(guard)),
        address_(std::move(address)),
        peer_(std::move(peer)) {}

  Verdict TakeHello(absl::string_view bytes)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool CountFrames(absl::string_view bytes)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::shared_ptr<FloodGuard> guard_;
  const std::string address_;
  const std::string peer_;
  std::atomic<bool> is_cut_ = false;
  mutable absl::Mutex mutex_;
  Kind kind_ ABSL_GUARDED_BY(mutex_) = Kind::kUnknown;
  // The first bytes of TLS.
  std::string hello_ ABSL_GUARDED_BY(mutex_);
  FrameCounter frames_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::flood_guard

#endif  // COMMON_FLOOD_GUARD_WATCHED_CONNECTION_H_
