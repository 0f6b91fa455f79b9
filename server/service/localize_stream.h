// RelocalizationService.LocalizeStream: a sequence of frames on one call.
#ifndef SERVER_SERVICE_LOCALIZE_STREAM_H_
#define SERVER_SERVICE_LOCALIZE_STREAM_H_

#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>

#include <memory>
#include <stop_token>
#include <unordered_map>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "common/grpc_server/raw_service.h"
#include "server/service/dispatcher.h"
#include "server/service/frame_queue.h"
#include "server/service/grpc_call.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline::service {

class LocalizeStreamCall;

// The streams that are open now, so that a server that stops can end them.
// Thread-safe.
class LocalizeStreams {
 public:
  // Begins a stream; gRPC owns it. A stream that is drained answers what it
  // has read, and ends with UNAVAILABLE, reason DRAINING.
  // One whose client is not let in ends before anything is read.
  grpc_server::RawReactor* Begin(grpc::CallbackServerContext& context,
                                 Dispatcher& dispatcher,
                                 const CallSource& source);

  // Drains those that are open and those that will begin.
  void Drain();

 private:
  friend class LocalizeStreamCall;
  void Remove(LocalizeStreamCall* stream);

  absl::Mutex mutex_;
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  std::unordered_map<LocalizeStreamCall*, std::weak_ptr<LocalizeStreamCall>>
      open_ ABSL_GUARDED_BY(mutex_);
};

// One stream. Each of its frames goes to the dispatcher like a call of its own.
class LocalizeStreamCall final
    : public grpc_server::RawReactor,
      public std::enable_shared_from_this<LocalizeStreamCall> {
 public:
  LocalizeStreamCall(grpc::CallbackServerContext& context,
                     Dispatcher& dispatcher, const CallSource& source,
                     LocalizeStreams& streams)
      : context_(context),
        dispatcher_(dispatcher),
        source_(source),
        streams_(streams) {}

  // To be called once, on one that a shared_ptr owns.
  void Start();
  void Drain();

 private:
  // What to do next; chosen under the lock, done without it.
  enum class Step { kNothing, kDispatch, kWrite, kRead, kFinish };

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  // Does all that can be done now.
  void Proceed();
  Step NextStep(FrameQueue::FramePtr& frame)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Dispatch(const FrameQueue::FramePtr& frame);

  grpc::CallbackServerContext& context_;
  Dispatcher& dispatcher_;
  const CallSource& source_;
  LocalizeStreams& streams_;
  // Until gRPC is done with it. Answers that come later find it still there.
  std::shared_ptr<LocalizeStreamCall> self_;
  std::stop_source stop_;
  // Owned by the read and the write that are under way.
  grpc::ByteBuffer incoming_;
  grpc::ByteBuffer outgoing_;

  absl::Mutex mutex_;
  FrameQueue queue_ ABSL_GUARDED_BY(mutex_);
  bool reading_ ABSL_GUARDED_BY(mutex_) = false;
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  // No more frames will be accepted; the stream ends with final_.
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status final_ ABSL_GUARDED_BY(mutex_);
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace treeline::service

#endif  // SERVER_SERVICE_LOCALIZE_STREAM_H_
