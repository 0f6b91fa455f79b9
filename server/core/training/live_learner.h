// A scene that is learnt while its frames arrive, one after the other.
#ifndef SERVER_CORE_TRAINING_LIVE_LEARNER_H_
#define SERVER_CORE_TRAINING_LIVE_LEARNER_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/random.h"
#include "common/camera/rgbd_calibration.h"
#include "common/image/frame.h"
#include "server/core/features/rgbd_samples.h"
#include "server/core/forest/model_file.h"
#include "server/core/recognition/appearance_words.h"
#include "server/core/recognition/scene_descriptor.h"
#include "server/core/training/confidence_fitter.h"
#include "server/core/training/keyframe_builder.h"
#include "server/core/training/leaf_filler.h"
#include "server/core/training/sample_memory.h"
#include "server/core/training/training_options.h"

namespace treeline::training {

struct LiveOptions {
  uint64_t seed = 0;
  // 0: one a processor.
  int threads = 0;
  // What the model records about where it came from; see ModelInfo.
  std::string software_version{};
  std::string created_utc{};
  std::string dataset{};
  std::vector<std::pair<std::string, std::string>> recorded_options{};
  // Where the samples of frames are kept (SampleMemory), so that poses can be
  // corrected; empty: they cannot.
  std::string memory_folder{};
};

// What is known at one moment, ready to be written. A value that shares no
// state with the learner but what does not change.
struct LiveModel {
  forest::ModelInfo info;
  forest::Forest forest;
  std::vector<PlacedKeyframe> keyframes;
  recognition::SceneDescriptor appearance;
  // Views that were held back, whole, with depth and without: asked about,
  // answered rightly and wrongly with the threshold of today.
  int asked = 0;
  int right = 0;
  int wrong = 0;

  // As a model of method universal. Errors of WriteScene.
  absl::Status Write(const std::string& path) const;
};

// Frames that were held back, and a model that has not learnt them.
struct LiveTrials {
  struct HeldBack {
    uint64_t number = 0;
    image::Frame frame;
    geometry::Rigid3 world_from_sensor;  // of the model's pose sensor
  };
  LiveModel model;
  std::vector<HeldBack> frames;
  // What covers them: a view from elsewhere.
  image::Frame cover;

  // Writes the model beside `path`, asks it about the frames, removes it, and
  // returns what came of each frame; after `stop`, of fewer of them. Errors of
  // WriteScene and OpenLocalizer.
  absl::StatusOr<std::vector<std::vector<ConfidenceTrial>>> Run(
      const std::string& path, uint64_t seed,
      const std::stop_token& stop) const;
};

// Learns a scene of method universal from frames one by one: the splits of a
// base stay, and its leaves are filled (see LeafFiller); keyframes are kept
// where a view is new; and what the words of the pictures are. Memory does not
// grow with the number of frames, nor does the time that one takes.
//
// The confidence is learnt on the way: as SplitForConfidence parts a recording,
// blocks of frames are held back with gaps around them. Once the model has
// learnt what comes after a block, it is asked about it, and then learns it.
//
// Poses may be corrected: of a frame is kept what it sends down the trees, in
// the frame of its sensor, and the leaves are filled again. That gives the same
// leaves as if the poses had been right from the beginning. It takes disk, not
// memory: 0.4 MB a frame.
//
// What is learnt is a function of base, calibration, options, frames and
// trials, in their order, and of corrections. Not thread-safe.
class LiveLearner {
 public:
  // `base_model` has the forest of method rgbd or universal, of any scene, as
  // `treeline train --splits-only` writes it. Errors of ModelFile::Open;
  // INVALID_ARGUMENT for another model. calibration.pose_sensor: whose poses
  // Add is given.
  static absl::StatusOr<std::unique_ptr<LiveLearner>> Create(
      const std::string& base_model, const camera::RgbdCalibration& calibration,
      const LiveOptions& options);

  // Takes in the next frame, which must have depth; `name` is for errors.
  // Returns what is now to be asked, if anything; meanwhile frames may go on.
  // INVALID_ARGUMENT for frames of other sizes than the calibration's.
  absl::StatusOr<std::optional<LiveTrials>> Add(
      const std::string& name, const image::Frame& frame,
      const geometry::Rigid3& world_from_sensor);

  // The pose of frame number `frame`, in the order of Add, is now this.
  // FAILED_PRECONDITION where poses cannot be corrected, also because there was
  // no room for samples; OUT_OF_RANGE: there was no such frame.
  absl::Status Correct(int frame, const geometry::Rigid3& world_from_sensor);

  // The outcome for one frame of the trials that Add gave. Of many frames, some
  // are remembered, each with the same chance.
  void AddTrials(std::vector<ConfidenceTrial> trials);

  int frames() const { return info_.training_frames; }
  int keyframes() const { return static_cast<int>(keyframes_.size()); }

  // The model so far, without the few frames that are held back now. After
  // corrections leaves are filled again, 2 ms a frame. FAILED_PRECONDITION: no
  // frame had usable depth. DATA_LOSS: the samples that were kept are gone.
  absl::StatusOr<LiveModel> Model();
  // With them; no more frames may come, but poses may be corrected, which
  // Model then has.
  absl::StatusOr<LiveModel> Finish();

 private:
  // What is left of a frame once it is taken in; its world is its own sensor.
  struct Prepared {
    int number = 0;
    geometry::Rigid3 world_from_sensor;
    std::vector<RoutedSamples> routed;              // by tree
    std::shared_ptr<const KeyframeParts> keyframe;  // null: its view is known
  };
  struct KeptKeyframe {
    int frame = 0;
    PlacedKeyframe placed;
  };

  LiveLearner(std::unique_ptr<const forest::ModelFile> base,
              const camera::RgbdCalibration& calibration,
              const LiveOptions& options);

  absl::StatusOr<Prepared> Prepare(const image::Frame& frame,
                                   const geometry::Rigid3& world_from_sensor);
  bool IsNewView(const geometry::Rigid3& world_from_color) const;
  // Of the model's pose sensor.
  geometry::Rigid3 ModelPose(const geometry::Rigid3& world_from_sensor) const;
  void Learn(Prepared prepared);
  void Keep(const Prepared& prepared);
  absl::Status Settle();
  void KeepFewerKeyframes();
  void LearnWords(const image::Frame& frame);
  bool TrialsAreDue() const;
  absl::StatusOr<LiveTrials> BeginTrials();
  void LearnWaiting();
  void SetConfidence(LiveModel& model) const;

  const std::unique_ptr<const forest::ModelFile> base_;
  const LiveOptions options_;
  TrainingOptions sampling_;
  KeyframeOptions keyframe_options_;
  const features::DepthGeometry geometry_;
  const image::DepthRegistrar registration_;
  LeafFiller leaves_;
  forest::ModelInfo info_;
  std::vector<KeptKeyframe> keyframes_;
  // Of each frame, and of what is kept of those that were learnt; only where
  // poses can be corrected.
  std::vector<geometry::Rigid3> world_from_sensor_;
  std::vector<int> kept_frames_;
  std::unique_ptr<SampleMemory> memory_;
  absl::Status memory_status_;
  bool is_moved_ = false;  // since the leaves were filled
  // Words of every n-th frame; fewer of them when there are too many.
  recognition::AppearanceWords appearance_;
  std::vector<std::vector<uint32_t>> words_;
  int words_every_ = 1;
  // Held back, with the gaps around them; of some the pictures, too.
  std::vector<Prepared> waiting_;
  std::vector<LiveTrials::HeldBack> held_back_;
  image::Frame cover_;
  // By frame.
  std::vector<std::vector<ConfidenceTrial>> trials_;
  uint32_t tried_frames_ = 0;
  base::Random random_;
};

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_LIVE_LEARNER_H_
