// A gRPC call's context that lets go of its channel before anybody is told of
// the call's end.
#ifndef CLIENT_BENCH_CALL_CONTEXT_H_
#define CLIENT_BENCH_CALL_CONTEXT_H_

#include <grpcpp/client_context.h>

#include <memory>

#include "absl/synchronization/mutex.h"

namespace treeline::bench {

// A context keeps its channel alive, and gRPC 1.51 destroys its callback
// threads with the last channel: if that channel goes on one of these threads,
// the thread's queue is freed while the thread reads it. Whoever is told of the
// end of a call may close the connection at once, so the callback must have
// released the context by then.
class CallContext {
 public:
  // For whoever sets up the call, and for its callback before Release.
  grpc::ClientContext* get() const { return context_.get(); }
  grpc::ClientContext& operator*() const { return *context_; }
  grpc::ClientContext* operator->() const { return context_.get(); }

  // Thread-safe with Release: nothing happens after it.
  void Cancel() {
    const absl::MutexLock lock(&mutex_);
    if (context_ != nullptr) context_->TryCancel();
  }
  // By the call's callback, when nothing of the context is needed any more.
  void Release() {
    const absl::MutexLock lock(&mutex_);
    context_.reset();
  }

 private:
  absl::Mutex mutex_;
  std::unique_ptr<grpc::ClientContext> context_ =
      std::make_unique<grpc::ClientContext>();
};

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_CALL_CONTEXT_H_
