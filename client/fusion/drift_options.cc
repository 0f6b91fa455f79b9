#include "client/fusion/drift_options.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "client/fusion/drift_options_fields.h"

namespace treeline::drift {

absl::Status DriftOptions::Validate() const {
  absl::Status status;
  ForEachField(*this, [&status](const char* name, auto value) {
    if (status.ok() && !(value > 0 && std::isfinite(value))) {
      status = absl::InvalidArgumentError(
          absl::StrCat(name, ": ", value, " is not a positive number"));
    }
  });
  if (status.ok() && min_confidence > 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("min_confidence: ", min_confidence, " is more than 1"));
  }
  return status;
}

}  // namespace treeline::drift
