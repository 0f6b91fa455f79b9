#include "server/app/hangup.h"

#include <pthread.h>

#include <csignal>
#include <stop_token>
#include <utility>

namespace treeline::server_app {
namespace {

sigset_t Hangup() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGHUP);
  return signals;
}

}  // namespace

void BlockHangup() {
  const sigset_t signals = Hangup();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}

HangupListener::HangupListener(std::function<void()> on_hangup)
    : thread_([on_hangup = std::move(on_hangup)](const std::stop_token& stop) {
        const sigset_t signals = Hangup();
        while (true) {
          int signal = 0;
          sigwait(&signals, &signal);
          if (stop.stop_requested()) return;
          on_hangup();
        }
      }) {}

HangupListener::~HangupListener() {
  thread_.request_stop();
  // Wakes it, and it alone.
  pthread_kill(thread_.native_handle(), SIGHUP);
}

}  // namespace treeline::server_app
