// Which scene is it, and where in it? Ranked scenes in, one answer out.
#ifndef SERVER_CORE_RECOGNITION_LOCALIZE_AMONG_H_
#define SERVER_CORE_RECOGNITION_LOCALIZE_AMONG_H_

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/camera/rgbd_calibration.h"
#include "common/image/frame.h"
#include "server/core/localizer/localizer.h"
#include "server/core/recognition/scene_index.h"

namespace treeline::recognition {

// A scene to look for a pose in.
struct SceneToTry {
  // Kept alive by whoever holds it.
  std::shared_ptr<const localizer::Localizer> localizer;
  // Becomes Frame::calibration: what the frame was taken with if it was taken
  // there. nullopt: the calibration that is stored with the scene.
  std::optional<camera::RgbdCalibration> calibration;
  // Becomes Frame::is_camera_assumed.
  bool is_camera_assumed = false;
};

// Gives a scene that was ranked; may load it, and may take its time. An error
// says why the frame cannot be tried in this scene: it is not loaded, its file
// is corrupt, or the frame does not fit its camera. CANCELLED and
// DEADLINE_EXCEEDED end everything.
using AcquireScene =
    std::function<absl::StatusOr<SceneToTry>(const std::string& scene)>;

struct AmongOptions {
  // Scenes in which a pose is looked for, at most; scenes that cannot be tried
  // do not count. Positive.
  int max_tried = 3;
  // A localized pose of at least this confidence ends the search, in [0, 1].
  double sure_confidence = 0.95;
};

// What was found out about one scene.
struct ConsideredScene {
  std::string scene;
  double similarity = 0;
  // Whether a pose was looked for and the question was answered.
  bool tried = false;
  // Not OK: it should have been tried and could not be.
  absl::Status status;
  // If it was tried:
  localizer::Outcome outcome = localizer::Outcome::kNotLocalized;
  double confidence = 0;
  int inliers = 0;
};

struct AmongResult {
  // The scene that answered; empty if there was none to try.
  std::string scene;
  // Its localizer; null if there was none to try.
  std::shared_ptr<const localizer::Localizer> localizer;
  // Of that scene. Timings are sums over the scenes tried.
  localizer::PoseEstimate estimate;
  // All of the ranking, in its order.
  std::vector<ConsideredScene> considered;
};

// Looks for a pose in the scenes of `ranking`, the first first, until one is
// sure or enough were tried. The answer is that scene's; if none is sure, the
// localized pose of most confidence; if none is localized, what was not
// localized with most confidence, so that the answer says NOT_LOCALIZED and
// why. Among equals the earlier wins.
//
// `frame` holds the pixels; its calibration is set anew for every scene. With
// the same frame, ranking, scenes and options, the answer is the same.
//
// An empty ranking is NOT_LOCALIZED with no scene. Errors: INVALID_ARGUMENT
// for bad options; CANCELLED once `localize.stop` was requested; whatever
// `acquire` ends everything with; and if no scene could be tried although there
// were some, the error of the first.
absl::StatusOr<AmongResult> LocalizeAmong(
    image::Frame frame, std::span<const SceneScore> ranking,
    const AcquireScene& acquire, const localizer::LocalizeOptions& localize,
    const AmongOptions& options = {});

}  // namespace treeline::recognition

#endif  // SERVER_CORE_RECOGNITION_LOCALIZE_AMONG_H_
