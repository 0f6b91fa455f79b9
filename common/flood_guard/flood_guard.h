// Who may ask how much of an HTTP/2 server, by address, and what was cut off.
#ifndef COMMON_FLOOD_GUARD_FLOOD_GUARD_H_
#define COMMON_FLOOD_GUARD_FLOOD_GUARD_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/container/flat_hash_map.h"
#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "common/flood_guard/frame_counter.h"

namespace treeline::flood_guard {

// Of each address. IPv6 addresses count by their first 64 bits.
struct FloodLimits {
  // Calls that begin in a second, 1..1e9; a second's worth may come at once,
  // but not more than may be open. Each connection counts like
  // kCallsOfAConnection of them; new ones leave a quarter to the calls of
  // those that are there.
  double calls_per_s = 500;
  // Calls that are open at a time, 10..1e9.
  int64_t open_calls = 2048;
  // Connections at a time, 1..1e6.
  int connections = 1024;

  absl::Status Validate() const;
};

// What making a connection costs, handshake included, in calls.
inline constexpr int kCallsOfAConnection = 5;
// So much of DATA pays for a call: queries carry pictures, and who sends as
// many bytes is no cheap attacker.
inline constexpr double kPayloadOfACall = 16 * 1024;
// A call is HEADERS, a message, its end, perhaps a reset, and some changes of
// windows: frames other than a call's first, and without payload, for each
// call.
inline constexpr int kFramesOfACall = 10;

// When all addresses together have more calls open than so many of them may,
// each may have no more than its share of these, but kFewCalls at least.
inline constexpr int kAddressesOfAllCalls = 2;
inline constexpr int64_t kFewCalls = 16;

// Why a connection was cut off, or not let in.
enum class CutReason {
  kCalls,
  kFrames,
  kOpenCalls,
  kHeaderBlock,
  kHandshake,
  kConnections,
  // Its address was cut off a moment ago.
  kCameBack,
};
inline constexpr size_t kCutReasons = 7;
// For metrics: "calls", "frames", ...
absl::string_view NameOf(CutReason reason);

// base::AddressKey of gRPC's "ipv4:192.0.2.1:4711" or
// "ipv6:%5B2001:db8::1%5D:4711".
std::string AddressKeyOfPeer(absl::string_view peer);

// Thread-safe. An address of which a connection was cut off may make no other
// for a second; those that it has go on.
class FloodGuard {
 public:
  // Is called for cut connections, at most once a second, from any thread:
  // "cut off 192.0.2.1:4711: ...".
  using Report = std::function<void(const std::string& message)>;

  // The clock must outlive it.
  FloodGuard(const FloodLimits& limits, const base::Clock& clock,
             Report report = nullptr);

  // Whether a connection may be made. If so, its end must be told. `peer`: for
  // the report.
  bool Open(const std::string& address, absl::string_view peer);
  void Close(const std::string& address);

  // Whether a connection may go on after these frames.
  bool Draw(const std::string& address, absl::string_view peer,
            const FrameCounts& counts);
  // For what is wrong with one connection, whatever others do.
  void Cut(const std::string& address, absl::string_view peer,
           CutReason reason);

  // A call of the address has reached the service; has ended.
  void BeginCall(const std::string& address);
  void EndCall(const std::string& address);

  uint64_t cuts(CutReason reason) const;
  // Addresses that it remembers now.
  size_t addresses() const;
  // From now on nothing is reported. Returns when nothing is being reported.
  void StopReporting();

 private:
  struct Address {
    // What is left of allowances that come back with time.
    double calls = 0;
    double frames = 0;
    base::MonotonicTime seen;
    base::MonotonicTime refused_until = base::MonotonicTime::min();
    int connections = 0;
    int64_t open_calls = 0;
  };

  // With buckets as they are now.
  Address& Find(const std::string& key) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Forget() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // How many calls an address may have open, when so many more begin somewhere.
  int64_t OpenCallsOfOne(int64_t more) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Note(absl::string_view peer, CutReason reason)
      ABSL_LOCKS_EXCLUDED(mutex_);
  std::string Explain(CutReason reason) const;

  const FloodLimits limits_;
  // How many calls may begin at once.
  const double burst_;
  const base::Clock& clock_;
  mutable absl::Mutex mutex_;
  absl::flat_hash_map<std::string, Address> addresses_ ABSL_GUARDED_BY(mutex_);
  // When there are so many, those that are as good as new are forgotten.
  size_t forget_at_ ABSL_GUARDED_BY(mutex_) = 1024;
  // Of all addresses; and those that began within about a second, of which the
  // service may not have heard yet.
  int64_t open_calls_ ABSL_GUARDED_BY(mutex_) = 0;
  double begun_ ABSL_GUARDED_BY(mutex_) = 0;
  base::MonotonicTime begun_at_ ABSL_GUARDED_BY(mutex_);
  std::array<uint64_t, kCutReasons> cuts_ ABSL_GUARDED_BY(mutex_) = {};
  // Held while it reports.
  absl::Mutex report_mutex_;
  Report report_ ABSL_GUARDED_BY(report_mutex_);
  std::optional<base::MonotonicTime> reported_ ABSL_GUARDED_BY(report_mutex_);
  uint64_t not_reported_ ABSL_GUARDED_BY(report_mutex_) = 0;
};

}  // namespace treeline::flood_guard

#endif  // COMMON_FLOOD_GUARD_FLOOD_GUARD_H_
