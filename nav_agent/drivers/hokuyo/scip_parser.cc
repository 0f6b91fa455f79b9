#include "nav_agent/drivers/hokuyo/scip_parser.h"

#include <algorithm>
#include <cstring>

#include "nav_agent/drivers/hokuyo/scip_codec.h"

namespace treeline::hokuyo {

ScipParser::ScipParser() {
  text_.reserve(kMaxReplyBytes);
  line_ends_.reserve(kMaxLines);
  lines_.reserve(kMaxLines);
}

void ScipParser::Parse(std::span<const uint8_t> bytes,
                       absl::FunctionRef<void(const ScipReply&)> on_reply) {
  absl::string_view rest(reinterpret_cast<const char*>(bytes.data()),
                         bytes.size());
  while (!rest.empty()) {
    const size_t end = rest.find('\n');
    AddText(rest.substr(0, end));
    if (end == absl::string_view::npos) return;
    rest.remove_prefix(end + 1);
    EndLine(on_reply);
  }
}

void ScipParser::AddText(absl::string_view text) {
  if (overflow_ || text.size() > kMaxReplyBytes - text_.size()) {
    overflow_ = true;
    // What lies before the next empty line no longer matters; only whether
    // the current line is empty does.
    if (!text.empty()) text_.assign(1, 'x');
    line_ends_.clear();
    return;
  }
  text_.append(text.data(), text.size());
}

void ScipParser::EndLine(absl::FunctionRef<void(const ScipReply&)> on_reply) {
  if (overflow_) {
    const bool empty_line = text_.empty();
    text_.clear();
    if (!empty_line) return;
    ++corrupt_;
    overflow_ = false;
    return;
  }
  const size_t start = line_ends_.empty() ? 0 : line_ends_.back();
  if (text_.size() > start) {
    if (line_ends_.size() < kMaxLines) {
      line_ends_.push_back(text_.size());
    } else {
      overflow_ = true;
      text_.clear();
      line_ends_.clear();
    }
    return;
  }
  EndReply(on_reply);
  text_.clear();
  line_ends_.clear();
}

void ScipParser::EndReply(absl::FunctionRef<void(const ScipReply&)> on_reply) {
  // Empty lines on their own mean nothing.
  if (line_ends_.empty()) return;
  lines_.clear();
  size_t start = 0;
  for (const size_t end : line_ends_) {
    lines_.emplace_back(text_.data() + start, end - start);
    start = end;
  }
  if (lines_.size() < 2 || lines_[1].size() != 3 ||
      !CheckedScipLine(lines_[1])) {
    ++corrupt_;
    return;
  }
  on_reply({.echo = lines_[0],
            .status = lines_[1].substr(0, 2),
            .lines = std::span<const absl::string_view>(lines_).subspan(2)});
}

}  // namespace treeline::hokuyo
