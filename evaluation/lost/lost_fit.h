// The lost detector's weights from a lost suite: logistic regression with
// weights of at least 0, by projected gradient descent.
#ifndef EVALUATION_LOST_LOST_FIT_H_
#define EVALUATION_LOST_LOST_FIT_H_

#include <string>

#include "absl/status/statusor.h"
#include "nav_agent/localization/lost_detector.h"

namespace treeline::lost {

// The model that tells the rows of feature tables best: logistic regression,
// both kinds of rows counting the same in total, weights at least 0.
// INVALID_ARGUMENT for other tables and for those with rows of one kind only.
absl::StatusOr<localization::LostModel> FitLostModel(const std::string& table);

// As C++ and with its mean log loss on `table`.
std::string LostModelText(const localization::LostModel& model);

}  // namespace treeline::lost

#endif  // EVALUATION_LOST_LOST_FIT_H_
