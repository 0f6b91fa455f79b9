#include "server/service/localize_stream.h"

#include <utility>
#include <vector>

#include "server/service/grpc_call.h"
#include "server/service/grpc_message.h"

namespace treeline::service {

grpc_server::RawReactor* LocalizeStreams::Begin(
    grpc::CallbackServerContext& context, Dispatcher& dispatcher,
    const CallSource& source) {
  const auto stream =
      std::make_shared<LocalizeStreamCall>(context, dispatcher, source, *this);
  bool draining = false;
  {
    absl::MutexLock lock(&mutex_);
    open_[stream.get()] = stream;
    draining = draining_;
  }
  stream->Start();
  if (draining) stream->Drain();
  return stream.get();
}

void LocalizeStreams::Drain() {
  std::vector<std::shared_ptr<LocalizeStreamCall>> open;
  {
    absl::MutexLock lock(&mutex_);
    draining_ = true;
    for (const auto& [address, stream] : open_) open.push_back(stream.lock());
  }
  for (const auto& stream : open) {
    if (stream != nullptr) stream->Drain();
  }
}

void LocalizeStreams::Remove(LocalizeStreamCall* stream) {
  absl::MutexLock lock(&mutex_);
  open_.erase(stream);
}

void LocalizeStreamCall::Start() {
  self_ = shared_from_this();
  const CallInfo call =
      CallInfoFrom(context_, "LocalizeStream", source_, stop_.get_token());
  const absl::StatusOr<Client> client =
      dispatcher_.Identify(call, Scope::kLocalize);
  if (!client.ok()) {
    absl::MutexLock lock(&mutex_);
    closed_ = true;
    final_ = client.status();
  }
  Proceed();
}

void LocalizeStreamCall::Drain() {
  {
    absl::MutexLock lock(&mutex_);
    if (closed_) return;
    closed_ = true;
    final_ = StreamIsDraining();
  }
  Proceed();
}

void LocalizeStreamCall::OnReadDone(bool ok) {
  auto frame = std::make_shared<FrameQueue::Frame>();
  frame->lease = base::ByteLease(source_.budget);
  absl::Status taken;
  if (ok) taken = TakeMessage(incoming_, frame->lease, frame->request);
  FrameQueue::FramePtr dropped;
  {
    absl::MutexLock lock(&mutex_);
    reading_ = false;
    if (!ok) {
      closed_ = true;
    } else if (!closed_ && !taken.ok()) {
      // Without its id it cannot be answered by itself.
      closed_ = true;
      final_ = taken;
    } else if (!closed_) {
      frame->call =
          CallInfoFrom(context_, "LocalizeStream", source_, stop_.get_token());
      const absl::Status accepted = queue_.Accept(std::move(frame));
      if (!accepted.ok()) {
        closed_ = true;
        final_ = accepted;
      }
      dropped = queue_.DropOldest();
    }
  }
  if (dropped != nullptr) {
    const absl::Status status = FrameQueue::DroppedStatus();
    dispatcher_.Reject(dropped->call, dropped->request.localize(), status);
    absl::MutexLock lock(&mutex_);
    FrameQueue::Answer(*dropped, status);
  }
  Proceed();
}

void LocalizeStreamCall::OnWriteDone(bool ok) {
  {
    absl::MutexLock lock(&mutex_);
    writing_ = false;
    // The client is gone; the read tells too.
    if (!ok) closed_ = true;
  }
  Proceed();
}

void LocalizeStreamCall::OnCancel() {
  stop_.request_stop();
  {
    absl::MutexLock lock(&mutex_);
    if (!closed_) final_ = absl::CancelledError("the stream was cancelled");
    closed_ = true;
  }
  Proceed();
}

void LocalizeStreamCall::OnDone() {
  streams_.Remove(this);
  // Gone with the last that holds it, at the end of this at the earliest.
  const std::shared_ptr<LocalizeStreamCall> self = std::move(self_);
}

LocalizeStreamCall::Step LocalizeStreamCall::NextStep(
    FrameQueue::FramePtr& frame) {
  if (finished_) return Step::kNothing;
  frame = queue_.NextToDispatch();
  if (frame != nullptr) return Step::kDispatch;
  if (!writing_) {
    frame = queue_.NextAnswered();
    if (frame != nullptr) {
      writing_ = true;
      return Step::kWrite;
    }
  }
  if (!reading_ && !closed_ && queue_.MayRead()) {
    reading_ = true;
    return Step::kRead;
  }
  if (closed_ && queue_.empty() && !writing_) {
    finished_ = true;
    return Step::kFinish;
  }
  return Step::kNothing;
}

void LocalizeStreamCall::Proceed() {
  while (true) {
    FrameQueue::FramePtr frame;
    Step step = Step::kNothing;
    absl::Status final_status;
    {
      absl::MutexLock lock(&mutex_);
      step = NextStep(frame);
      if (step == Step::kFinish) final_status = final_;
    }
    switch (step) {
      case Step::kNothing:
        return;
      case Step::kDispatch:
        Dispatch(frame);
        break;
      case Step::kWrite:
        outgoing_ = BytesOf(frame->answer);
        StartWrite(&outgoing_);
        break;
      case Step::kRead:
        StartRead(&incoming_);
        break;
      case Step::kFinish:
        Finish(FinishStatus(final_status, context_));
        return;
    }
  }
}

void LocalizeStreamCall::Dispatch(const FrameQueue::FramePtr& frame) {
  dispatcher_.Localize(
      frame->call, frame->request.localize(),
      [this, self = shared_from_this(),
       frame](absl::StatusOr<v1::LocalizeResponse> response) {
        {
          absl::MutexLock lock(&mutex_);
          queue_.LeaveDispatcher();
          // No frame of this stream will fare better.
          if (absl::IsUnauthenticated(response.status()) && !closed_) {
            closed_ = true;
            final_ = response.status();
          }
          FrameQueue::Answer(*frame, std::move(response));
        }
        Proceed();
      });
}

}  // namespace treeline::service
