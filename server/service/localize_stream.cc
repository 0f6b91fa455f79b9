#include "server/service/localize_stream.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "common/base/error_info.h"
#include "common/wire/geometry.h"
#include "common/wire/status.h"
#include "server/service/grpc_call.h"
#include "server/service/grpc_message.h"

namespace treeline::service {
namespace {

constexpr int kDefaultPending = 4;
constexpr int kMaxPending = 64;
// Of a stream that drops frames: one computed while the next is decoded.
constexpr int kSideBySide = 2;
// Answers that the client has not taken; beyond them nothing is read.
constexpr size_t kMaxUnsent = 256;

absl::Status Draining() {
  return base::WithReason(
      absl::UnavailableError("the server is stopping; open the stream again"),
      "DRAINING");
}

}  // namespace

RawReactor* LocalizeStreams::Begin(grpc::CallbackServerContext& context,
                                   Dispatcher& dispatcher,
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
    final_ = Draining();
  }
  Proceed();
}

void LocalizeStreamCall::OnReadDone(bool ok) {
  auto item = std::make_shared<Item>();
  item->lease = base::ByteLease(source_.budget);
  absl::Status taken;
  if (ok) taken = TakeMessage(incoming_, item->lease, item->request);
  std::shared_ptr<Item> dropped;
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
      Accept(std::move(item));
      dropped = DropOldest();
    }
  }
  if (dropped != nullptr) {
    const absl::Status status = base::WithReason(
        absl::AbortedError("dropped: newer frames were waiting"),
        "FRAME_DROPPED");
    dispatcher_.Reject(dropped->call, dropped->request.localize(), status);
    absl::MutexLock lock(&mutex_);
    Answer(*dropped, status);
  }
  Proceed();
}

void LocalizeStreamCall::Accept(std::shared_ptr<Item> item) {
  if (std::exchange(first_, false)) {
    settings_ = item->request.settings();
    if (settings_.max_pending() == 0)
      settings_.set_max_pending(kDefaultPending);
    if (settings_.max_pending() < 1 || settings_.max_pending() > kMaxPending) {
      closed_ = true;
      final_ = base::WithReason(
          wire::FieldError("settings.max_pending", "it must be 0..64"),
          "INVALID_REQUEST");
      return;
    }
  }
  item->call =
      CallInfoFrom(context_, "LocalizeStream", source_, stop_.get_token());
  item->answer.set_id(item->request.id());
  items_.push_back(std::move(item));
}

std::shared_ptr<LocalizeStreamCall::Item> LocalizeStreamCall::DropOldest() {
  if (!settings_.drop_oldest()) return nullptr;
  const auto held = [](const std::shared_ptr<Item>& item) {
    return item->stage == Stage::kHeld;
  };
  if (with_dispatcher_ < kSideBySide ||
      std::count_if(items_.begin(), items_.end(), held) <=
          settings_.max_pending()) {
    return nullptr;
  }
  const auto oldest = std::find_if(items_.begin(), items_.end(), held);
  (*oldest)->stage = Stage::kDropped;
  return *oldest;
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

bool LocalizeStreamCall::MayRead() const {
  if (reading_ || closed_) return false;
  if (items_.size() >= kMaxUnsent) return false;
  return first_ || settings_.drop_oldest() ||
         items_.size() < static_cast<size_t>(settings_.max_pending());
}

LocalizeStreamCall::Step LocalizeStreamCall::NextStep(
    std::shared_ptr<Item>& item) {
  if (finished_) return Step::kNothing;
  const int side_by_side =
      settings_.drop_oldest() ? kSideBySide : settings_.max_pending();
  if (with_dispatcher_ < side_by_side) {
    const auto held = std::find_if(
        items_.begin(), items_.end(),
        [](const auto& each) { return each->stage == Stage::kHeld; });
    if (held != items_.end()) {
      item = *held;
      item->stage = Stage::kWithDispatcher;
      ++with_dispatcher_;
      return Step::kDispatch;
    }
  }
  if (!writing_ && !items_.empty() &&
      items_.front()->stage == Stage::kAnswered) {
    item = std::move(items_.front());
    items_.pop_front();
    writing_ = true;
    return Step::kWrite;
  }
  if (MayRead()) {
    reading_ = true;
    return Step::kRead;
  }
  if (closed_ && items_.empty() && !writing_) {
    finished_ = true;
    return Step::kFinish;
  }
  return Step::kNothing;
}

void LocalizeStreamCall::Proceed() {
  while (true) {
    std::shared_ptr<Item> item;
    Step step = Step::kNothing;
    absl::Status final_status;
    {
      absl::MutexLock lock(&mutex_);
      step = NextStep(item);
      if (step == Step::kFinish) final_status = final_;
    }
    switch (step) {
      case Step::kNothing:
        return;
      case Step::kDispatch:
        Dispatch(item);
        break;
      case Step::kWrite:
        outgoing_ = BytesOf(item->answer);
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

void LocalizeStreamCall::Dispatch(const std::shared_ptr<Item>& item) {
  dispatcher_.Localize(
      item->call, item->request.localize(),
      [this, self = shared_from_this(),
       item](absl::StatusOr<v1::LocalizeResponse> response) {
        {
          absl::MutexLock lock(&mutex_);
          --with_dispatcher_;
          // No frame of this stream will fare better.
          if (absl::IsUnauthenticated(response.status()) && !closed_) {
            closed_ = true;
            final_ = response.status();
          }
          Answer(*item, std::move(response));
        }
        Proceed();
      });
}

void LocalizeStreamCall::Answer(Item& item,
                                absl::StatusOr<v1::LocalizeResponse> response) {
  item.stage = Stage::kAnswered;
  // Its images are not needed any more.
  item.request = v1::LocalizeStreamRequest();
  item.lease.Release();
  if (response.ok()) {
    *item.answer.mutable_response() = *std::move(response);
  } else {
    *item.answer.mutable_error() = wire::ToProto(response.status());
  }
}

}  // namespace treeline::service
