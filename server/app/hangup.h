// SIGHUP: read the configuration again.
#ifndef SERVER_APP_HANGUP_H_
#define SERVER_APP_HANGUP_H_

#include <functional>
#include <thread>

namespace treeline::server_app {

// Keeps SIGHUP from ending the process, and holds it back until a listener
// takes it. Call from main() before any other thread is there.
void BlockHangup();

// Calls back for each SIGHUP, on a thread of its own; several that come while
// it is at work count as one.
class HangupListener {
 public:
  explicit HangupListener(std::function<void()> on_hangup);
  // Returns when no call back runs any more.
  ~HangupListener();

 private:
  std::jthread thread_;
};

}  // namespace treeline::server_app

#endif  // SERVER_APP_HANGUP_H_
