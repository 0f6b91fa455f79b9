// Cuts what a Hokuyo sensor sends into replies.
#ifndef NAV_AGENT_DRIVERS_HOKUYO_SCIP_PARSER_H_
#define NAV_AGENT_DRIVERS_HOKUYO_SCIP_PARSER_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/strings/string_view.h"

namespace treeline::hokuyo {

// One reply. Its lines stand without their ends, but with their check sums,
// of which only that of the status was looked at.
struct ScipReply {
  absl::string_view echo;    // the command that is answered
  absl::string_view status;  // two characters
  std::span<const absl::string_view> lines;
};

// Bytes in, replies out. A reply is lines, each ended by LF, and an empty line
// at its end. It needs at least an echo and a status ("00P", with its sum);
// whatever else lies between two empty lines is corrupt: it is counted and
// forgotten, and the next reply is again complete. Corruption thus costs the
// replies that it touches, and one more where it hits their border.
//
// Memory is allocated once: a reply of more than kMaxReplyBytes or kMaxLines
// is corrupt (a full scan with intensities has 6.7 KB in 106 lines).
class ScipParser {
 public:
  static constexpr size_t kMaxReplyBytes = 32 << 10;
  static constexpr size_t kMaxLines = 512;

  ScipParser();
  // Its lines are views into its memory.
  ScipParser(const ScipParser&) = delete;
  ScipParser& operator=(const ScipParser&) = delete;

  // Calls on_reply for every reply that `bytes` complete, in their order; what
  // it is given is valid until it returns.
  void Parse(std::span<const uint8_t> bytes,
             absl::FunctionRef<void(const ScipReply&)> on_reply);

  // Replies that were none.
  int64_t corrupt() const { return corrupt_; }

 private:
  void EndLine(absl::FunctionRef<void(const ScipReply&)> on_reply);
  void EndReply(absl::FunctionRef<void(const ScipReply&)> on_reply);
  void AddText(absl::string_view text);

  // The lines of the current reply one after the other, without their ends.
  std::string text_;
  std::vector<size_t> line_ends_;
  std::vector<absl::string_view> lines_;
  // The current reply has grown too large: its rest is skipped.
  bool overflow_ = false;
  int64_t corrupt_ = 0;
};

}  // namespace treeline::hokuyo

#endif  // NAV_AGENT_DRIVERS_HOKUYO_SCIP_PARSER_H_
