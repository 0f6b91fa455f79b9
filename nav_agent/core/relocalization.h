// The port through which a lost robot asks where it is.
#ifndef NAV_AGENT_CORE_RELOCALIZATION_H_
#define NAV_AGENT_CORE_RELOCALIZATION_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/geometry/rigid2.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::core {

// What a relocalization server says of one frame. "Not localized" is an answer.
struct RelocalizationAnswer {
  // The exposure that it is of.
  base::MonotonicTime stamp;
  bool localized = false;
  // Why not, as the server has it: "LOW_CONFIDENCE", "TOO_FEW_INLIERS", ...
  std::string reason;
  // If localized: the pose of the calibration's pose sensor (camera frame: x
  // right, y down, z forward), its covariance (Rigid3's order), and the
  // probability that it is right, in [0, 1].
  geometry::Rigid3 map_from_camera;
  geometry::PoseCovariance covariance{};
  double confidence = 0;
  // The scene's: of answers that reach it, 99 of 100 were right in training.
  double confidence_threshold = 0;
  int inliers = 0;
  int samples = 0;
  // Pixels of the colour image that support the answer, for pictures; as the
  // server has them, unchecked.
  std::vector<geometry::Vec2> inlier_pixels = {};
  std::string scene;
  std::string model_version;
  // From the question to the answer, retries included (s).
  double round_trip_s = 0;
};

// Asks without waiting. Implementations are thread-safe.
class RelocalizationPort {
 public:
  virtual ~RelocalizationPort() = default;

  // Sends a question; what was asked before is cancelled and forgotten. The
  // answer, or DEADLINE_EXCEEDED, comes after timeout_s at most. No prior goes
  // with it: a lost robot has none.
  virtual void Ask(const RgbdFrame& frame, double timeout_s) = 0;
  // The answer, once; nullopt while there is none. Errors: UNAVAILABLE (no
  // server), NOT_FOUND (no such scene), DEADLINE_EXCEEDED, and what else the
  // server says.
  virtual std::optional<absl::StatusOr<RelocalizationAnswer>> TakeAnswer() = 0;
  virtual bool IsAsking() const = 0;
  virtual void Cancel() = 0;
};

}  // namespace treeline::core

#endif  // NAV_AGENT_CORE_RELOCALIZATION_H_
