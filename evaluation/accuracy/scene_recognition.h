// How often the right scene is found among many.
#ifndef EVALUATION_ACCURACY_SCENE_RECOGNITION_H_
#define EVALUATION_ACCURACY_SCENE_RECOGNITION_H_

#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "evaluation/accuracy/foreign_images.h"
#include "server/core/localizer/localizer.h"
#include "server/core/recognition/localize_among.h"
#include "server/core/recognition/scene_index.h"

namespace treeline::accuracy {

// Frames of a recording, and the scene that they were taken in.
struct RecognitionQuery {
  std::string scene;  // empty: none of them, every answer is wrong
  NegativeSource source;
};

// "SCENE=URI" or "SCENE=URI,FRAMES" with a frame list. INVALID_ARGUMENT for
// anything else.
absl::StatusOr<RecognitionQuery> ParseRecognitionQuery(absl::string_view text);

struct RecognitionOptions {
  uint64_t seed = 0;
  recognition::AmongOptions among;
  // Ranks alone: no pose is looked for.
  bool rank_only = false;
  // Leaves the depth of frames away.
  bool no_depth = false;
  // Takes every n-th frame of each recording. Positive.
  int every = 1;
  // Frames asked about at a time. Times describe a single query only with 1.
  int threads = 1;
  bool quiet = false;
  std::stop_token stop;
};

// What became of one frame.
struct RecognizedFrame {
  std::string stem;
  // Not OK: it could not be read, or no scene could be tried.
  absl::Status status;
  // Of the true scene in the ranking, from 1; 0: it is not in it.
  int rank = 0;
  std::string first;   // in the ranking; empty: no scene is known
  std::string answer;  // the scene that answered; empty with rank_only
  bool localized = false;
  double confidence = 0;
  int tried = 0;
  double words_ms = 0;
  double rank_ms = 0;
  double pose_ms = 0;  // LocalizeAmong: of all scenes tried
};

// Of one query. Shares are of all frames: those that failed count as wrong.
struct RecognitionTally {
  std::string scene;
  std::string source;
  std::vector<RecognizedFrame> frames;

  int first_in_ranking() const;
  int among_first(int count) const;
  // The true scene answered; and also with a pose.
  int right_scene() const;
  int right_localized() const;
  // Another scene answered with a pose: false accepts.
  int wrong_localized() const;
  int errors() const;
};

// The newest model of every scene in a folder DIR/<scene>/<version>, opened
// when they are first needed. Thread-safe.
class SceneModels {
 public:
  // INVALID_ARGUMENT: a model has no descriptor. NOT_FOUND: no models.
  static absl::StatusOr<std::unique_ptr<SceneModels>> Open(
      const std::string& folder);

  const std::vector<std::string>& scenes() const { return scenes_; }
  const recognition::SceneIndex& index() const { return index_; }
  // Time to read all descriptors into the index (ms).
  double read_ms() const { return read_ms_; }
  absl::StatusOr<std::shared_ptr<const localizer::Localizer>> Acquire(
      const std::string& scene);

 private:
  SceneModels() = default;
  absl::Status Read(const std::string& folder);

  std::vector<std::string> scenes_;
  std::map<std::string, std::string> paths_;
  recognition::SceneIndex index_;
  double read_ms_ = 0;
  absl::Mutex mutex_;
  std::map<std::string, std::shared_ptr<const localizer::Localizer>> open_
      ABSL_GUARDED_BY(mutex_);
};

// Asks about every frame of every query. Errors are those of opening a
// recording; CANCELLED.
absl::StatusOr<std::vector<RecognitionTally>> Recognize(
    SceneModels& models, const std::vector<RecognitionQuery>& queries,
    const RecognitionOptions& options, const base::Clock& clock);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_SCENE_RECOGNITION_H_
