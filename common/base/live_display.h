// A line that changes while something runs.
#ifndef COMMON_BASE_LIVE_DISPLAY_H_
#define COMMON_BASE_LIVE_DISPLAY_H_

#include <chrono>
#include <string>

namespace treeline::base {

// Shows the state of a run on standard error: in place on a terminal, a line
// every ten seconds elsewhere.
class LiveDisplay {
 public:
  LiveDisplay();
  ~LiveDisplay() { Clear(); }
  LiveDisplay(const LiveDisplay&) = delete;
  LiveDisplay& operator=(const LiveDisplay&) = delete;

  void Show(const std::string& line);
  void Clear();

 private:
  const bool terminal_;
  bool shown_ = false;
  std::chrono::steady_clock::time_point next_;
};

}  // namespace treeline::base

#endif  // COMMON_BASE_LIVE_DISPLAY_H_
