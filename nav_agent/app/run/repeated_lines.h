// The same line of a log again and again is written once.
#ifndef NAV_AGENT_APP_RUN_REPEATED_LINES_H_
#define NAV_AGENT_APP_RUN_REPEATED_LINES_H_

#include <cstdint>
#include <string>
#include <vector>

namespace treeline::run_app {

struct RepeatedLine {
  std::string kind;
  std::string text;

  bool operator==(const RepeatedLine&) const = default;
};

// Not thread-safe.
class RepeatedLines {
 public:
  // What is to be written for this line: nothing if it is the last one again;
  // else the line, and before it the last one with how often it came in all, if
  // that was more than once.
  std::vector<RepeatedLine> Next(const std::string& kind,
                                 const std::string& text);
  // The same at the end.
  std::vector<RepeatedLine> Finish();

 private:
  RepeatedLine last_;
  int64_t times_ = 0;
};

}  // namespace treeline::run_app

#endif  // NAV_AGENT_APP_RUN_REPEATED_LINES_H_
