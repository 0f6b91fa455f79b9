#include "nav_agent/core/odometry_noise.h"

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace treeline::core {

absl::StatusOr<std::optional<MeasuredOdometryNoise>> NoiseOfFile(
    const MeasuredOdometryNoise& told) {
  std::vector<std::string> missing;
  for (const auto& [name, value] : kNoiseKeys) {
    const double share = told.*value;
    if (share == 0) {
      missing.emplace_back(name);
    } else if (!(share >= kLeastNoise && share <= kMostNoise)) {
      return absl::InvalidArgumentError(absl::StrCat(
          "odometry noise: ", name, " is ", share, "; it must be ", kLeastNoise,
          "..", kMostNoise,
          ", as `treeline-agent calibrate` measures it (0.01 is 1 cm in a "
          "metre)"));
    }
  }
  if (missing.size() == kNoiseKeys.size()) return std::nullopt;
  if (!missing.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "odometry noise is four numbers; ", absl::StrJoin(missing, ", "),
        missing.size() == 1 ? " is" : " are",
        " missing: `treeline-agent calibrate --write` sets them all"));
  }
  return told;
}

}  // namespace treeline::core
