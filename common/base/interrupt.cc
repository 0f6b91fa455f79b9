#include "common/base/interrupt.h"

#include <pthread.h>

#include <csignal>
#include <thread>

namespace treeline::base {

std::stop_token StopOnInterrupt() {
  // A thread waits for the signals, so that the stop callbacks run outside
  // signal context. Every thread started later inherits the blocked mask.
  static std::stop_source source;
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread([signals] {
    int signal = 0;
    sigwait(&signals, &signal);
    source.request_stop();
    sigwait(&signals, &signal);
    std::signal(signal, SIG_DFL);
    pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
    raise(signal);
  }).detach();
  return source.get_token();
}

}  // namespace treeline::base
