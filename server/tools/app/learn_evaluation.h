// How well held-out pictures are answered, as the page of `treeline learn` says
// it.
#ifndef SERVER_TOOLS_APP_LEARN_EVALUATION_H_
#define SERVER_TOOLS_APP_LEARN_EVALUATION_H_

#include <cstdint>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/dataset/dataset.h"
#include "server/tools/learning/learn_page.h"

namespace treeline::tools_app {

struct HeldOutEvaluation {
  std::string right_within;  // in words
  std::vector<learning::HeldOutTrial> trials;
  int foreign_pictures = 0;
  int foreign_answered = 0;
  // Of the kind of query with the most of them: pictures that were not answered
  // rightly, where their cameras were, and some of them to look at.
  int missed = 0;
  std::vector<geometry::Rigid3> missed_world_from_camera;
  std::vector<learning::MissedPicture> pictures;
};

// Asks the model about the pictures of `held_out` (at most 300, evenly spread)
// as they are, about the same without depth where its method can do without,
// and about pictures of nothing. `options`: how the recording was opened.
absl::StatusOr<HeldOutEvaluation> EvaluateHeldOut(
    const std::string& model_path, const dataset::Dataset& held_out,
    const dataset::DatasetOptions& options, uint64_t seed, bool quiet,
    const std::stop_token& stop);

}  // namespace treeline::tools_app

#endif  // SERVER_TOOLS_APP_LEARN_EVALUATION_H_
