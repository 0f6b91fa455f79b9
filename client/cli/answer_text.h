// Answers for people and for programs.
#ifndef CLIENT_CLI_ANSWER_TEXT_H_
#define CLIENT_CLI_ANSWER_TEXT_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/relocalizer/frame_files.h"
#include "client/relocalizer/relocalizer.h"

namespace treeline::client_cli {

// One JSON object in one line, without the new line: docs/reference/client.md
// has its keys. A query that failed has the outcome ERROR, `code`, `reason`
// (the message) and, where the server gave them, `error_reason` and
// `error_metadata`. Numbers are written so that reading them back gives the
// same doubles.
std::string AnswerJson(
    const relocalizer::FrameFiles& files,
    const absl::StatusOr<relocalizer::LocalizeAnswer>& answer);

// A few lines about one answer.
std::string AnswerText(const relocalizer::LocalizeAnswer& answer);
// One line of a list.
std::string AnswerLine(
    const relocalizer::FrameFiles& files,
    const absl::StatusOr<relocalizer::LocalizeAnswer>& answer);

// Accumulates what a list of queries came to.
class AnswerSummary {
 public:
  void Add(const absl::StatusOr<relocalizer::LocalizeAnswer>& answer);
  int localized() const { return localized_; }
  int failed() const { return failed_; }
  // "500 frames: 498 localized, 2 not, 0 failed; round trip p50 8.1 ms, ..."
  std::string Text() const;

 private:
  int queries_ = 0;
  int localized_ = 0;
  int failed_ = 0;
  std::vector<double> round_trip_ms_;
};

std::string ScenesJson(
    const std::vector<relocalizer::SceneDescription>& scenes);
// A table, and below it the reasons of scenes that failed.
std::string ScenesText(
    const std::vector<relocalizer::SceneDescription>& scenes);

}  // namespace treeline::client_cli

#endif  // CLIENT_CLI_ANSWER_TEXT_H_
