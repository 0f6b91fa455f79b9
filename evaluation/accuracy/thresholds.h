// When a frame counts as correct, as the command line says it.
#ifndef EVALUATION_ACCURACY_THRESHOLDS_H_
#define EVALUATION_ACCURACY_THRESHOLDS_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "evaluation/accuracy/evaluation.h"

namespace treeline::accuracy {

// A threshold before the scene's size is known.
struct ThresholdRequest {
  // Centimetres, or per cent of the scene's size.
  double translation = 5;
  bool relative = false;
  double rotation_deg = 5;

  bool operator==(const ThresholdRequest&) const = default;
};

// "5,5" is 5 cm and 5 degrees; "0.5%,2" is 0.5 % of the scene's size and 2
// degrees, for worlds whose unit is arbitrary. INVALID_ARGUMENT for anything
// else, and for numbers that are not positive.
absl::StatusOr<ThresholdRequest> ParseThreshold(absl::string_view text);

// 5 cm / 5 degrees, 2 / 2 and 10 / 10: what every evaluation states.
std::vector<ThresholdRequest> StandardThresholds();

// What evaluations of a structure from motion state beside them, as its unit of
// length may not be known.
inline constexpr ThresholdRequest kRelativeThreshold{1, true, 5};

// The diagonal of the box of the true camera positions (world units): a size
// that any recording with ground truth has. nullopt: fewer than two differ.
std::optional<double> SceneSize_m(const std::vector<FrameResult>& results);

// nullopt: relative, and the scene has no size.
std::optional<PoseThreshold> Resolve(const ThresholdRequest& request,
                                     const std::optional<double>& size_m);

// "5 cm / 5°", "0.5 % / 2°".
std::string ThresholdText(const ThresholdRequest& request);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_THRESHOLDS_H_
