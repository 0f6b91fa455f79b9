// Ctrl-C that stops cleanly: long work polls a stop token.
#ifndef COMMON_BASE_INTERRUPT_H_
#define COMMON_BASE_INTERRUPT_H_

#include <stop_token>

namespace treeline::base {

// Installs handlers for SIGINT and SIGTERM and returns a token that they
// request to stop. A second signal ends the process at once with the signal's
// default action. Call once, from main(), before threads start.
std::stop_token StopOnInterrupt();

}  // namespace treeline::base

#endif  // COMMON_BASE_INTERRUPT_H_
