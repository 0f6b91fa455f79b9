// The frames of one LocalizeStream between their arrival and their answers,
// whatever carries them.
#ifndef SERVER_SERVICE_FRAME_QUEUE_H_
#define SERVER_SERVICE_FRAME_QUEUE_H_

#include <deque>
#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/byte_budget.h"
#include "server/service/call.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline::service {

// Frames are held in the order of their arrival until they are answered. Its
// owner sees to threads, to the calls of the dispatcher and to what is read and
// written. Not thread-safe.
class FrameQueue {
 public:
  enum class Stage { kHeld, kWithDispatcher, kDropped, kAnswered };
  struct Frame {
    Stage stage = Stage::kHeld;
    CallInfo call = {};
    // Holds the request.
    base::ByteLease lease = {};
    v1::LocalizeStreamRequest request = {};
    v1::LocalizeStreamResponse answer = {};
  };
  using FramePtr = std::shared_ptr<Frame>;

  // Takes a frame with its call, whose request is parsed. INVALID_ARGUMENT: the
  // settings of the first frame are absurd; the stream ends.
  absl::Status Accept(FramePtr frame);

  // The oldest frame that is held, where the stream's settings say that there
  // are too many: it is to be answered with DroppedStatus(). Null: there is no
  // need.
  FramePtr DropOldest();
  static absl::Status DroppedStatus();

  // The next one for the dispatcher, which then has it; null: it has enough, or
  // there is none.
  FramePtr NextToDispatch();
  // The dispatcher has no more to do with one of them.
  void LeaveDispatcher() { --with_dispatcher_; }

  // Sets what will be sent of a frame, and lets its pictures go.
  static void Answer(Frame& frame,
                     absl::StatusOr<v1::LocalizeResponse> response);

  // The next answer, in the order of arrival, taken out; null: it is not there
  // yet.
  FramePtr NextAnswered();

  // Whether another frame may be read.
  bool MayRead() const;
  bool empty() const { return frames_.empty(); }

 private:
  int SideBySide() const;

  v1::StreamSettings settings_;
  bool is_first_ = true;
  // In the order of their arrival, the oldest in front.
  std::deque<FramePtr> frames_;
  int with_dispatcher_ = 0;
};

// A stream that ends since the server stops: UNAVAILABLE, reason DRAINING.
absl::Status StreamIsDraining();

}  // namespace treeline::service

#endif  // SERVER_SERVICE_FRAME_QUEUE_H_
