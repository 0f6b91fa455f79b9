#include "server/gateway/localize_stream_session.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "common/connect_rpc/connect_message.h"

namespace treeline::gateway {
namespace {

using http::WebSocketClose;
using service::FrameQueue;

constexpr size_t kPiece = 65536;
// For how long to wait until others have given back memory.
constexpr std::chrono::milliseconds kPatienceForMemory{2000};
// How often a stream looks whether it is to go on.
constexpr std::chrono::milliseconds kLook{500};

// "REASON: message": a close frame has room for little more.
std::string TextOf(const absl::Status& status) {
  const std::string reason = base::ErrorInfoOf(status).reason;
  return reason.empty() ? std::string(status.message())
                        : absl::StrCat(reason, ": ", status.message());
}

absl::string_view TextOf(WebSocketClose failure) {
  switch (failure) {
    case WebSocketClose::kTooLarge:
      return "REQUEST_TOO_LARGE: the message is larger than the server accepts";
    case WebSocketClose::kTryAgainLater:
      return "OVERLOADED: other requests take all there is of memory";
    default:
      return "INVALID_REQUEST: not a frame of RFC 6455";
  }
}

}  // namespace

LocalizeStreamSession::LocalizeStreamSession(
    service::Dispatcher& dispatcher, const base::Clock& clock,
    const LocalizeSocketOptions& options, service::CallInfo call,
    http::HttpDuplex& connection)
    : dispatcher_(dispatcher),
      clock_(clock),
      options_(options),
      call_(std::move(call)),
      connection_(connection),
      shared_(std::make_shared<Shared>()),
      arriving_(options.budget),
      reader_(options.max_message_bytes,
              [this](size_t bytes) {
                return arriving_.Resize(bytes, kPatienceForMemory);
              }),
      ahead_(kPiece, '\0'),
      last_event_(clock.Now()) {}

LocalizeStreamSession::~LocalizeStreamSession() { stop_.request_stop(); }

void LocalizeStreamSession::Run() {
  if (!shared_->signal.is_valid()) {
    EndWith(WebSocketClose::kTryAgainLater, "OVERLOADED: too many streams");
  }
  for (;;) {
    Dispatch();
    if (!Write()) return;
    CheckWhetherItGoesOn();
    if (end_.has_value() && (has_client_closed_ || !HasFrames())) break;
    if (!WaitAndRead()) return;
    Parse();
  }
  connection_.Write(http::WebSocketCloseFrame(end_->code, end_->reason));
}

void LocalizeStreamSession::Dispatch() {
  for (;;) {
    FrameQueue::FramePtr frame;
    {
      const absl::MutexLock lock(&shared_->mutex);
      frame = shared_->queue.NextToDispatch();
    }
    if (frame == nullptr) return;
    dispatcher_.Localize(
        frame->call, frame->request.localize(),
        [shared = shared_, frame](absl::StatusOr<v1::LocalizeResponse> answer) {
          {
            const absl::MutexLock lock(&shared->mutex);
            shared->queue.LeaveDispatcher();
            if (absl::IsUnauthenticated(answer.status())) {
              shared->refusal = answer.status();
            }
            FrameQueue::Answer(*frame, std::move(answer));
          }
          shared->signal.Notify();
        });
  }
}

bool LocalizeStreamSession::Write() {
  for (;;) {
    FrameQueue::FramePtr frame;
    absl::Status refusal;
    {
      const absl::MutexLock lock(&shared_->mutex);
      frame = shared_->queue.NextAnswered();
      refusal = shared_->refusal;
    }
    if (frame == nullptr) {
      if (!refusal.ok()) EndWith(WebSocketClose::kRefused, TextOf(refusal));
      return true;
    }
    const absl::StatusOr<std::string> bytes =
        connect_rpc::WriteConnectMessage(*is_text_, frame->answer);
    if (!bytes.ok() ||
        !connection_.Write(http::WebSocketMessage(*is_text_, *bytes))) {
      return false;
    }
    last_event_ = clock_.Now();
  }
}

void LocalizeStreamSession::CheckWhetherItGoesOn() {
  if (end_.has_value()) return;
  const bool is_idle = !HasFrames() && !reader_.is_amid() && unread_.empty();
  if (options_.goes_on && !options_.goes_on()) {
    EndWith(WebSocketClose::kGoingAway, TextOf(service::StreamIsDraining()));
  } else if (is_idle != is_idle_) {
    is_idle_ = is_idle;
    if (!connection_.SetIdle(is_idle)) EndForOthers();
  } else if (is_idle && clock_.Now() >= last_event_ + options_.idle_timeout) {
    EndWith(WebSocketClose::kNormal, "IDLE: nothing came for a while");
  }
}

bool LocalizeStreamSession::WaitAndRead() {
  const bool may_read = MayRead();
  // What was read ahead comes first.
  if (may_read && !unread_.empty()) return true;
  const http::HttpDuplex::Readiness ready =
      connection_.Wait(may_read, shared_->signal.fd(), clock_.Now() + kLook);
  if (ready.other) shared_->signal.Clear();
  // The server itself wakes idle connections so; then the client is still there
  // to be told why.
  if (ready.has_gone && is_idle_ && !connection_.SetIdle(true)) {
    EndForOthers();
    return true;
  }
  if (!may_read) return !ready.has_gone;
  if (!ready.can_read) return true;
  const ssize_t got = connection_.ReadSome(ahead_.data(), ahead_.size());
  if (got < 0) {
    // In vain, unless it was only slow.
    connection_.Write(http::WebSocketCloseFrame(
        WebSocketClose::kRefused,
        "REQUEST_TIMEOUT: the message did not arrive in time"));
    return false;
  }
  unread_ = absl::string_view(ahead_.data(), static_cast<size_t>(got));
  if (got > 0) last_event_ = clock_.Now();
  return true;
}

void LocalizeStreamSession::Parse() {
  while (!unread_.empty() && MayRead()) {
    switch (reader_.Read(unread_)) {
      case http::WebSocketReader::Event::kNone:
        break;
      case http::WebSocketReader::Event::kMessage:
        OnMessage();
        break;
      case http::WebSocketReader::Event::kPing:
        connection_.Write(http::WebSocketPong(reader_.ping()));
        break;
      case http::WebSocketReader::Event::kClose:
        // It wants no more answers.
        has_client_closed_ = true;
        EndWith(WebSocketClose::kNormal, "");
        break;
      case http::WebSocketReader::Event::kFailed:
        EndWith(reader_.failure(), TextOf(reader_.failure()));
        break;
    }
  }
  if (end_.has_value()) {
    unread_ = {};
    arriving_.Release();
  }
  SetArriving(!end_.has_value() && reader_.is_amid());
}

void LocalizeStreamSession::SetArriving(bool is_arriving) {
  if (is_arriving == is_arriving_) return;
  is_arriving_ = is_arriving;
  if (is_arriving) {
    connection_.BeginArrival();
  } else {
    connection_.EndArrival();
  }
}

void LocalizeStreamSession::OnMessage() {
  SetArriving(false);
  const std::string bytes = reader_.TakeMessage();
  if (!is_text_.has_value()) is_text_ = reader_.is_text();
  const auto frame = std::make_shared<FrameQueue::Frame>();
  const absl::Status taken = [&] {
    if (reader_.is_text() != *is_text_) {
      return absl::InvalidArgumentError(
          "binary and text messages in one stream");
    }
    TL_ASSIGN_OR_RETURN(
        frame->lease,
        connect_rpc::LeaseForParsing(options_.budget, *is_text_, bytes.size()));
    TL_RETURN_IF_ERROR(
        connect_rpc::ParseConnectMessage(*is_text_, bytes, frame->request));
    // The message alone.
    frame->lease.Resize(bytes.size());
    return absl::OkStatus();
  }();
  arriving_.Release();
  if (!taken.ok()) {
    // Without its id it cannot be answered by itself.
    EndWith(absl::IsUnavailable(taken) ? WebSocketClose::kTryAgainLater
                                       : WebSocketClose::kBadMessage,
            TextOf(taken));
    return;
  }
  Accept(frame);
}

void LocalizeStreamSession::Accept(FrameQueue::FramePtr frame) {
  frame->call = call_;
  frame->call.arrival = clock_.Now();
  frame->call.stop = stop_.get_token();
  FrameQueue::FramePtr dropped;
  absl::Status accepted;
  {
    const absl::MutexLock lock(&shared_->mutex);
    accepted = shared_->queue.Accept(std::move(frame));
    dropped = shared_->queue.DropOldest();
  }
  if (!accepted.ok()) EndWith(WebSocketClose::kRefused, TextOf(accepted));
  if (dropped == nullptr) {
    // More than one may be read at once; none need wait for the rest.
    Dispatch();
    return;
  }
  const absl::Status status = FrameQueue::DroppedStatus();
  dispatcher_.Reject(dropped->call, dropped->request.localize(), status);
  const absl::MutexLock lock(&shared_->mutex);
  FrameQueue::Answer(*dropped, status);
}

bool LocalizeStreamSession::MayRead() {
  if (end_.has_value()) return false;
  // What has begun is read to its end: it holds memory.
  if (reader_.is_amid()) return true;
  const absl::MutexLock lock(&shared_->mutex);
  return shared_->queue.MayRead();
}

bool LocalizeStreamSession::HasFrames() {
  const absl::MutexLock lock(&shared_->mutex);
  return !shared_->queue.empty();
}

void LocalizeStreamSession::EndForOthers() {
  EndWith(WebSocketClose::kGoingAway,
          "DRAINING: the server stops, or others need the connection");
}

void LocalizeStreamSession::EndWith(WebSocketClose code,
                                    absl::string_view reason) {
  if (!end_.has_value()) end_ = End{code, std::string(reason)};
}

}  // namespace treeline::gateway
