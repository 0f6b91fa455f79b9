// One LocalizeStream over one WebSocket.
#ifndef SERVER_GATEWAY_LOCALIZE_STREAM_SESSION_H_
#define SERVER_GATEWAY_LOCALIZE_STREAM_SESSION_H_

#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "common/base/byte_budget.h"
#include "common/base/clock.h"
#include "common/http/http_message.h"
#include "common/http/web_socket.h"
#include "server/gateway/localize_socket.h"
#include "server/gateway/pending_call.h"
#include "server/service/call.h"
#include "server/service/dispatcher.h"
#include "server/service/frame_queue.h"

namespace treeline::gateway {

// Reads, dispatches and writes in the thread of its connection; answers come
// from the dispatcher's threads. While it writes to a client that does not
// read, it reads nothing either.
class LocalizeStreamSession {
 public:
  // `call`: what is known of the client; each frame's call is made from it.
  // Keeps references to all but it.
  LocalizeStreamSession(service::Dispatcher& dispatcher,
                        const base::Clock& clock,
                        const LocalizeSocketOptions& options,
                        service::CallInfo call, http::HttpDuplex& connection);
  // What is with the dispatcher is cancelled.
  ~LocalizeStreamSession();

  // Returns when the stream has ended.
  void Run();

 private:
  // Shared with the answers that may come when the session is gone.
  struct Shared {
    CallSignal signal;
    absl::Mutex mutex;
    service::FrameQueue queue ABSL_GUARDED_BY(mutex);
    // Of a frame whose client was not let in: no other will fare better.
    absl::Status refusal ABSL_GUARDED_BY(mutex);
  };
  // How the stream ends.
  struct End {
    http::WebSocketClose code = http::WebSocketClose::kNormal;
    std::string reason = {};
  };

  // Gives the dispatcher what it may have.
  void Dispatch();
  // Sends what is answered. False: the client has gone.
  bool Write();
  // Says whether it is idle, and ends it where the server or its time says so.
  void CheckWhetherItGoesOn();
  // Waits for bytes or answers, and reads what has arrived. False: the client
  // has gone.
  bool WaitAndRead();
  // Of what was read, what may be looked at now.
  void Parse();
  void OnMessage();
  void Accept(service::FrameQueue::FramePtr frame);
  void SetArriving(bool is_arriving);
  bool MayRead();
  // Whether there are some that are not answered.
  bool HasFrames();
  // Once for all: no more is read, and the stream ends when all is answered.
  void EndWith(http::WebSocketClose code, absl::string_view reason);
  void EndForOthers();

  service::Dispatcher& dispatcher_;
  const base::Clock& clock_;
  const LocalizeSocketOptions& options_;
  const service::CallInfo call_;
  http::HttpDuplex& connection_;
  const std::shared_ptr<Shared> shared_;
  std::stop_source stop_;
  base::ByteLease arriving_;
  http::WebSocketReader reader_;
  bool is_arriving_ = false;
  // Whether the client speaks JSON; nullopt: it has not spoken yet.
  std::optional<bool> is_text_;
  // What was read, and what of it has not been looked at.
  std::string ahead_;
  absl::string_view unread_;
  base::MonotonicTime last_event_;
  bool is_idle_ = false;
  bool has_client_closed_ = false;
  std::optional<End> end_;
};

}  // namespace treeline::gateway

#endif  // SERVER_GATEWAY_LOCALIZE_STREAM_SESSION_H_
