#include "common/base/live_display.h"

#include <unistd.h>

#include <cstdio>
#include <utility>

namespace treeline::base {
namespace {

constexpr std::chrono::seconds kLogEvery(10);

}  // namespace

LiveDisplay::LiveDisplay()
    : terminal_(isatty(STDERR_FILENO) == 1),
      next_(std::chrono::steady_clock::now() + kLogEvery) {}

void LiveDisplay::Show(const std::string& line) {
  if (terminal_) {
    std::fprintf(stderr, "\r\x1b[K%s", line.c_str());
    shown_ = true;
    return;
  }
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return;
  next_ = now + kLogEvery;
  std::fprintf(stderr, "%s\n", line.c_str());
}

void LiveDisplay::Clear() {
  if (std::exchange(shown_, false)) std::fputs("\r\x1b[K", stderr);
}

}  // namespace treeline::base
