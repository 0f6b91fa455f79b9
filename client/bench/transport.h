// How the load generator's calls reach a server.
#ifndef CLIENT_BENCH_TRANSPORT_H_
#define CLIENT_BENCH_TRANSPORT_H_

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>

#include "absl/status/status.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline::bench {

// What came of a call.
struct Reply {
  absl::Status status = {};
  // Whether the server said when to try again.
  bool pushback = false;
  // With an OK status; lives as long as the call to whoever is told.
  const v1::LocalizeResponse* response = nullptr;
};

// Thread-safe.
class Transport {
 public:
  class PendingCall {
   public:
    virtual ~PendingCall() = default;
    // The call ends soon, with CANCELLED unless it is over. Tells nobody on
    // this thread.
    virtual void Cancel() = 0;
  };
  using Done = std::function<void(const Reply& reply)>;

  // No call may be out.
  virtual ~Transport() = default;

  // Sends query `item`, as call `number` of all. `done` is called once, on a
  // thread of the transport, perhaps before this returns; the call ends after
  // `timeout`, with DEADLINE_EXCEEDED.
  virtual std::shared_ptr<PendingCall> Ask(size_t number, size_t item,
                                           std::chrono::nanoseconds timeout,
                                           Done done) = 0;
};

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_TRANSPORT_H_
