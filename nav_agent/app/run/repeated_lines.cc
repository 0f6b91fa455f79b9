#include "nav_agent/app/run/repeated_lines.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace treeline::run_app {

std::vector<RepeatedLine> RepeatedLines::Next(const std::string& kind,
                                              const std::string& text) {
  RepeatedLine line = {.kind = kind, .text = text};
  if (times_ > 0 && line == last_) {
    ++times_;
    return {};
  }
  std::vector<RepeatedLine> lines = Finish();
  lines.push_back(line);
  last_ = std::move(line);
  times_ = 1;
  return lines;
}

std::vector<RepeatedLine> RepeatedLines::Finish() {
  std::vector<RepeatedLine> lines;
  if (times_ > 1) {
    lines.push_back(
        {.kind = last_.kind,
         .text = absl::StrCat(last_.text, " (", times_, " times in all)")});
  }
  times_ = 0;
  return lines;
}

}  // namespace treeline::run_app
