#include "server/service/frame_queue.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "common/base/error_info.h"
#include "common/wire/geometry.h"
#include "common/wire/status.h"

namespace treeline::service {
namespace {

constexpr int kDefaultPending = 4;
constexpr int kMaxPending = 64;
// Of a stream that drops frames: one computed while the next is decoded.
constexpr int kSideBySide = 2;
// Answers that the client has not taken; beyond them nothing is read.
constexpr size_t kMaxUnsent = 256;

bool IsHeld(const FrameQueue::FramePtr& frame) {
  return frame->stage == FrameQueue::Stage::kHeld;
}

}  // namespace

absl::Status FrameQueue::Accept(FramePtr frame) {
  if (std::exchange(is_first_, false)) {
    settings_ = frame->request.settings();
    if (settings_.max_pending() == 0) {
      settings_.set_max_pending(kDefaultPending);
    }
    if (settings_.max_pending() < 1 || settings_.max_pending() > kMaxPending) {
      return base::WithReason(
          wire::FieldError("settings.max_pending", "it must be 0..64"),
          "INVALID_REQUEST");
    }
  }
  frame->answer.set_id(frame->request.id());
  frames_.push_back(std::move(frame));
  return absl::OkStatus();
}

FrameQueue::FramePtr FrameQueue::DropOldest() {
  if (!settings_.drop_oldest() || with_dispatcher_ < kSideBySide ||
      std::count_if(frames_.begin(), frames_.end(), IsHeld) <=
          settings_.max_pending()) {
    return nullptr;
  }
  const auto oldest = std::find_if(frames_.begin(), frames_.end(), IsHeld);
  (*oldest)->stage = Stage::kDropped;
  return *oldest;
}

absl::Status FrameQueue::DroppedStatus() {
  return base::WithReason(
      absl::AbortedError("dropped: newer frames were waiting"),
      "FRAME_DROPPED");
}

int FrameQueue::SideBySide() const {
  return settings_.drop_oldest() ? kSideBySide : settings_.max_pending();
}

FrameQueue::FramePtr FrameQueue::NextToDispatch() {
  if (with_dispatcher_ >= SideBySide()) return nullptr;
  const auto held = std::find_if(frames_.begin(), frames_.end(), IsHeld);
  if (held == frames_.end()) return nullptr;
  (*held)->stage = Stage::kWithDispatcher;
  ++with_dispatcher_;
  return *held;
}

void FrameQueue::Answer(Frame& frame,
                        absl::StatusOr<v1::LocalizeResponse> response) {
  frame.stage = Stage::kAnswered;
  frame.request = v1::LocalizeStreamRequest();
  frame.lease.Release();
  if (response.ok()) {
    *frame.answer.mutable_response() = *std::move(response);
  } else {
    *frame.answer.mutable_error() = wire::ToProto(response.status());
  }
}

FrameQueue::FramePtr FrameQueue::NextAnswered() {
  if (frames_.empty() || frames_.front()->stage != Stage::kAnswered) {
    return nullptr;
  }
  FramePtr frame = std::move(frames_.front());
  frames_.pop_front();
  return frame;
}

bool FrameQueue::MayRead() const {
  if (frames_.size() >= kMaxUnsent) return false;
  return is_first_ || settings_.drop_oldest() ||
         frames_.size() < static_cast<size_t>(settings_.max_pending());
}

absl::Status StreamIsDraining() {
  return base::WithReason(
      absl::UnavailableError("the server is stopping; open the stream again"),
      "DRAINING");
}

}  // namespace treeline::service
