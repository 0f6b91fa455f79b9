#include "common/base/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

namespace treeline::base {
namespace {

constexpr auto kTerminalInterval = std::chrono::milliseconds(100);
constexpr auto kLogInterval = std::chrono::seconds(10);
constexpr int kBarWidth = 30;

}  // namespace

Progress::Progress(std::string label, int64_t total, bool quiet)
    : label_(std::move(label)),
      total_(std::max<int64_t>(total, 1)),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) == 1),
      start_(std::chrono::steady_clock::now()),
      next_draw_(terminal_ ? start_ : start_ + kLogInterval) {}

Progress::~Progress() {
  absl::MutexLock lock(&mutex_);
  Draw(std::chrono::steady_clock::now(), /*last=*/true);
}

void Progress::Add(int64_t units) {
  absl::MutexLock lock(&mutex_);
  done_ += units;
  const MonotonicTime now = std::chrono::steady_clock::now();
  if (now >= next_draw_) Draw(now, /*last=*/false);
}

void Progress::Draw(MonotonicTime now, bool last) {
  if (quiet_) return;
  next_draw_ = now + (terminal_ ? MonotonicTime::duration(kTerminalInterval)
                                : MonotonicTime::duration(kLogInterval));
  const double fraction =
      std::min(1.0, static_cast<double>(done_) / static_cast<double>(total_));
  const double elapsed_s = MillisecondsBetween(start_, now) / 1e3;
  std::string bar(static_cast<size_t>(kBarWidth), '.');
  std::fill_n(bar.begin(), static_cast<int>(fraction * kBarWidth), '#');
  char time[64];
  if (last || fraction <= 0) {
    std::snprintf(time, sizeof(time), "%.1f s", elapsed_s);
  } else {
    std::snprintf(time, sizeof(time), "%.0f s left",
                  elapsed_s * (1 - fraction) / fraction);
  }
  std::fprintf(stderr, "%s%-20s [%s] %3.0f %%  %s%s",
               terminal_ ? "\r\033[K" : "", label_.c_str(), bar.c_str(),
               100 * fraction, time, terminal_ && !last ? "" : "\n");
  std::fflush(stderr);
}

}  // namespace treeline::base
