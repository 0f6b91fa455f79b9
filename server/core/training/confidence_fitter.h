// Teaches a model how sure it may be of its answers.
#ifndef SERVER_CORE_TRAINING_CONFIDENCE_FITTER_H_
#define SERVER_CORE_TRAINING_CONFIDENCE_FITTER_H_

#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/dataset/dataset.h"
#include "common/geometry/rigid3.h"
#include "server/core/forest/confidence_model.h"
#include "server/core/localizer/localizer.h"
#include "server/core/localizer/query_options.h"

namespace treeline::training {

// What spoke for one pose, and whether it was right.
struct ConfidenceTrial {
  forest::PoseEvidence evidence;
  bool is_right = false;
  // Its error is more than twice the bounds, or nothing was there to be found.
  bool is_gross = false;
  const char* view = "";  // what was asked about: "whole", "covered", ...
  geometry::PoseError error{};
  // See PoseEstimate; the focal length was right.
  double focal_error_sigmas = 0;
};

struct ConfidenceFit {
  // The prior's constant and its other weights count as if known with these
  // standard deviations. What evidence means is the same in all scenes, and a
  // scene's trials are mostly near its training views: they must not unlearn
  // what far views need.
  double constant_sigma = 0.5;
  double weight_sigma = 0.3;
  // The trials, which are of a few places alone, count as no more than so many.
  double independent_trials = 200;
  // A lower threshold would give answers that are rather wrong than right; a
  // higher one would refuse too much of what is right, even where places are
  // alike.
  double min_threshold = 0.7;
  double max_threshold = 0.9;
  // Of fewer right poses nothing is said of how well focal lengths are known.
  size_t min_focal_trials = 20;
};

// Logistic regression on the trials, drawn towards `prior` as if by a few
// trials of its own; weights of evidence are not negative, so that more of it
// never counts against a pose. The threshold is the least one at which all but
// one, and one in two hundred, of the trials' answers are not grossly wrong
// (one trial decides nothing): what is wrong by a little is told by its
// probability. Standard deviations of focal lengths are widened until 95 of 100
// right poses, all of a right focal length, are within 1.96 of them.
forest::ConfidenceModel FitConfidence(std::span<const ConfidenceTrial> trials,
                                      const forest::ConfidenceModel& prior,
                                      const ConfidenceFit& fit = {});

struct ConfidenceOptions {
  uint64_t seed = 0;
  // Frames used, evenly spread.
  int frames = 60;
  // 0: one a processor.
  int threads = 0;
  // A pose is right within these bounds (m, rad).
  double translation_m = 0.05;
  double rotation_rad = 5 * 0.017453292519943295;
  // What the fit is drawn towards.
  forest::ConfidenceModel prior = forest::ConfidenceModel::Typical();
  // Called with the trials that a confidence is fitted to; may be empty.
  std::function<void(std::span<const ConfidenceTrial>)> on_trials = {};
};

// How a model is opened for its trials: they are upright and of known cameras,
// and what they find so counts.
localizer::QueryOptions TrialOptions();

// Lets `localizer` answer one frame of which the localizer's pose sensor is at
// `world_from_sensor`, as RunConfidenceTrials does; `other` covers it. A random
// draw depends on options.seed and `number`. Errors of Localize.
absl::StatusOr<std::vector<ConfidenceTrial>> RunTrialsOfFrame(
    const localizer::Localizer& localizer, const image::Frame& frame,
    const image::Frame& other, const geometry::Rigid3& world_from_sensor,
    const ConfidenceOptions& options, uint64_t number);

// Lets `localizer` answer frames that it was not trained on, whole and spoilt:
// covered but for a window with what another frame shows in a mirror, blurred,
// in another light, without depth where that is answered, too; or mirrored as a
// whole, which no camera in the scene can see. Frames without
// a pose are left out. The result does not depend on threads. CANCELLED after
// `stop`, and whatever reading a frame gives.
absl::StatusOr<std::vector<ConfidenceTrial>> RunConfidenceTrials(
    const localizer::Localizer& localizer, const dataset::Dataset& held_out,
    const ConfidenceOptions& options, bool quiet, const std::stop_token& stop);

// Writes a model beside `path`, runs the trials on it, removes it again, and
// fits a confidence to their outcomes. Errors of write_model and
// RunConfidenceTrials.
absl::StatusOr<forest::ConfidenceModel> LearnConfidence(
    const std::function<absl::Status(const std::string&)>& write_model,
    const std::string& path, const dataset::Dataset& held_out,
    const ConfidenceOptions& options, bool quiet, const std::stop_token& stop);

// Parts a recording in blocks to learn from and blocks to test the result on,
// with gaps between them, so that those tested have no twin among those learnt
// and some look where training did not. Of short recordings none is held out.
struct HeldOutSplit {
  std::vector<int> train;
  std::vector<int> held_out;
};
HeldOutSplit SplitForConfidence(std::span<const int> frames);
// The same of photographs, of which there are few, and which look from where
// they look: of 20 to 59 every fourth is held out, of more see above.
HeldOutSplit SplitPhotographsForConfidence(std::span<const int> frames);

// What becomes of the i-th frame of a recording that is parted so.
enum class FrameRole { kLearnt, kGap, kHeldOut };
FrameRole RoleOf(size_t i);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_CONFIDENCE_FITTER_H_
