// One client that asks with a stream of frames rather than call by call.
#ifndef CLIENT_BENCH_STREAM_CLIENT_H_
#define CLIENT_BENCH_STREAM_CLIENT_H_

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/client_callback.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "client/bench/call_context.h"
#include "client/bench/workload.h"
#include "client/relocalizer/channel.h"
#include "common/base/clock.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline::bench {

// Keeps `window` frames of a stream in flight until there are no more. Deletes
// itself when the stream has ended.
class StreamClient final
    : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  // A frame that has its answer, or never will.
  struct Frame {
    uint64_t id = 0;
    size_t item = 0;
    base::MonotonicTime sent = {};
  };
  // All are called on gRPC's threads. `end` is the last call, and is given the
  // client that is about to be deleted; the frames without answers went to
  // `answer` before. By then the client holds nothing of the connection.
  struct Host {
    // The next query; nullopt: no more.
    std::function<std::optional<size_t>()> next;
    std::function<void(const Frame& frame, const absl::Status& status,
                       const v1::LocalizeResponse* response)>
        answer;
    std::function<void(StreamClient* client, const absl::Status& status)> end;
  };

  // `items` and `stub` must outlive the client.
  StreamClient(const relocalizer::Connection& connection,
               grpc::GenericStub& stub, const std::vector<WorkItem>& items,
               int window, Host host);

  void Start();
  void Cancel() { context_.Cancel(); }

 private:
  void SendIfThereIsRoom();
  void OnWriteDone(bool ok) override;
  void OnReadDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;
  void Deliver(const v1::LocalizeStreamResponse& response);

  const std::vector<WorkItem>& items_;
  const size_t window_;
  const Host host_;
  CallContext context_;
  grpc::ByteBuffer in_;
  grpc::ByteBuffer out_;

  absl::Mutex mutex_;
  uint64_t next_id_ ABSL_GUARDED_BY(mutex_) = 0;
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool no_more_ ABSL_GUARDED_BY(mutex_) = false;
  // In the order of their answers.
  std::deque<Frame> in_flight_ ABSL_GUARDED_BY(mutex_);
};

// A LocalizeStreamRequest of a serialised LocalizeRequest, which is not copied.
grpc::ByteBuffer StreamMessage(uint64_t id, const grpc::ByteBuffer& localize);

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_STREAM_CLIENT_H_
