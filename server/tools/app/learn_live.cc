#include "server/tools/app/learn_live.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "common/base/file.h"
#include "common/base/installed_file.h"
#include "common/base/live_display.h"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "common/image/decode.h"
#include "server/core/training/live_learner.h"
#include "server/core/training/pose_watch.h"
#include "server/core/training/rgbd_calibrator.h"
#include "server/repository/names.h"
#include "server/tools/calibration_file.h"
#include "server/tools/learning/learn_source.h"
#include "server/tools/learning/live_feed.h"
#include "server/tools/learning/live_source.h"
#include "server/tools/output_folder.h"
#include "server/tools/run_info.h"
#include "server/tools/training_place.h"

namespace treeline::tools_app {
namespace {

using learning::ArrivedFrame;
using learning::LiveFeed;
using learning::LiveFeedCounts;

constexpr const char* kStandardInput = "-";
constexpr double kMillimetre_m = 0.001;
// The first model so far comes no later than this (s).
constexpr double kFirstModel_s = 1;
// So many times as long as putting a model together took, none is begun.
constexpr double kRestAfterModel = 4;

// Does one thing at a time, beside the frames.
class Background {
 public:
  Background() : thread_([this] { Run(); }) {}
  ~Background() {
    absl::MutexLock lock(&mutex_);
    ends_ = true;
  }

  bool IsIdle() const {
    absl::MutexLock lock(&mutex_);
    return job_ == nullptr;
  }
  void Wait() const {
    const auto is_idle = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
      return job_ == nullptr;
    };
    absl::MutexLock lock(&mutex_, absl::Condition(&is_idle));
  }
  // Waits for the one before.
  void Begin(std::function<void()> job) {
    Wait();
    absl::MutexLock lock(&mutex_);
    job_ = std::move(job);
  }

 private:
  void Run() {
    const auto has_work = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
      return job_ != nullptr || ends_;
    };
    while (true) {
      std::function<void()> job;
      {
        absl::MutexLock lock(&mutex_, absl::Condition(&has_work));
        if (job_ == nullptr) return;
        job = job_;
      }
      job();
      absl::MutexLock lock(&mutex_);
      job_ = nullptr;
    }
  }

  mutable absl::Mutex mutex_;
  std::function<void()> job_ ABSL_GUARDED_BY(mutex_);
  bool ends_ ABSL_GUARDED_BY(mutex_) = false;
  std::jthread thread_;
};

// Where frames come from, and by which cameras.
struct OpenedSource {
  std::unique_ptr<const dataset::Dataset> recording;  // null: standard input
  std::unique_ptr<learning::LiveSource> frames;
  std::string name;
  double depth_unit_m = kMillimetre_m;
  camera::RgbdCalibration calibration;
  // Of frames from outside: a recording's poses were checked before.
  std::optional<training::PoseWatch> pose_watch;
};

absl::Status CalibrateRecording(const LearnOptions& options,
                                const learning::LearnSource& source,
                                OpenedSource& opened,
                                const std::stop_token& stop) {
  const dataset::Dataset& recording = *opened.recording;
  if (options.calibration == "nominal" || source.has_cameras ||
      recording.states_its_cameras() || recording.depth_is_registered()) {
    opened.calibration = recording.calibration();
    return absl::OkStatus();
  }
  if (!options.quiet) {
    std::printf(
        "First, how depth and colour fit together, from the whole recording. A "
        "camera that\nis still recording needs it beforehand: treeline "
        "calibrate, and --calibration FILE\n");
    std::fflush(stdout);
  }
  training::CalibratorOptions calibrator;
  calibrator.threads = options.training.threads;
  TL_ASSIGN_OR_RETURN(
      const training::CalibrationReport report,
      training::CalibrateRgbd(recording, calibrator, options.quiet, stop));
  opened.calibration = report.calibration;
  return absl::OkStatus();
}

absl::StatusOr<OpenedSource> OpenRecording(const LearnOptions& options,
                                           const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const learning::LearnSource source,
                      learning::FindLearnSource(options.source));
  if (source.kind == learning::SourceKind::kCapture) {
    return absl::InvalidArgumentError(absl::StrCat(
        options.source,
        ": --live plays recordings. Make one of it first:\n  treeline import ",
        tools::ShellQuoted(options.source), " --output recording\n  ",
        "treeline learn --live recording"));
  }
  dataset::DatasetOptions dataset = options.dataset;
  dataset.uri = source.uri;
  std::string calibration_path = source.calibration_path;
  if (options.calibration != "auto" && options.calibration != "nominal") {
    calibration_path = options.calibration;
  }
  OpenedSource opened;
  if (!calibration_path.empty()) {
    TL_ASSIGN_OR_RETURN(opened.calibration,
                        tools::ReadCalibrationFile(calibration_path));
    dataset.color_camera = opened.calibration.color.ToString();
    if (dataset.uri.rfind("tum:", 0) != 0) {
      dataset.depth_camera = opened.calibration.depth.ToString();
    }
  }
  TL_ASSIGN_OR_RETURN(dataset::Dataset recording,
                      dataset::Dataset::Open(dataset));
  opened.recording =
      std::make_unique<const dataset::Dataset>(std::move(recording));
  TL_RETURN_IF_ERROR(
      learning::CheckLearnable(*opened.recording, "universal", options.source));
  if (calibration_path.empty()) {
    TL_RETURN_IF_ERROR(CalibrateRecording(options, source, opened, stop));
  }
  opened.calibration.pose_sensor = opened.recording->calibration().pose_sensor;
  opened.depth_unit_m = opened.recording->depth_unit_m();
  opened.name = opened.recording->uri();
  opened.frames = learning::FramesOfRecording(*opened.recording);
  return opened;
}

// Of standard input, the calibration's file says all.
absl::StatusOr<OpenedSource> OpenStandardInput(const LearnOptions& options) {
  if (options.scene.empty()) {
    return absl::InvalidArgumentError(
        "frames from standard input have no name of a scene: give --scene "
        "NAME");
  }
  if (options.calibration == "auto" || options.calibration == "nominal") {
    return absl::FailedPreconditionError(
        "frames from standard input do not say by which cameras they were "
        "taken: give --calibration FILE. `treeline calibrate` makes it, once a "
        "camera, from a recording with poses; it also says whether the poses "
        "are those of the colour or of the depth camera");
  }
  OpenedSource opened;
  TL_ASSIGN_OR_RETURN(opened.calibration,
                      tools::ReadCalibrationFile(options.calibration));
  if (options.dataset.depth_unit_m > 0) {
    opened.depth_unit_m = options.dataset.depth_unit_m;
  }
  opened.name = "standard input";
  opened.pose_watch.emplace(opened.name, opened.calibration,
                            options.training.threads);
  opened.frames = learning::FramesByLine(STDIN_FILENO);
  return opened;
}

// The options that shape the model, as RecordedOptions has those of others.
std::vector<std::pair<std::string, std::string>> RecordedLiveOptions(
    const LearnOptions& options) {
  return {{"live", "true"},
          {"rate", absl::StrCat(options.live.rate_hz)},
          {"base", options.live.base_model},
          {"frames", options.dataset.frame_list},
          {"poses", options.dataset.pose_file},
          {"calibration", options.calibration}};
}

class LiveRun {
 public:
  LiveRun(const LearnOptions& options, OpenedSource source,
          std::unique_ptr<training::LiveLearner> learner, std::string path)
      : options_(options),
        source_(std::move(source)),
        learner_(std::move(learner)),
        path_(std::move(path)) {}

  absl::Status Run(const std::stop_token& stop) {
    start_ = last_published_ = clock_.Now();
    const bool waits = options_.live.rate_hz == 0;
    LiveFeed feed(
        std::move(source_.frames),
        {.rate_hz = source_.recording != nullptr ? options_.live.rate_hz : 0,
         .waits = waits},
        stop);
    while (std::optional<learning::Arrival> arrival = feed.Next()) {
      if (std::holds_alternative<learning::EndOfFrames>(*arrival)) {
        if (!is_complete_) TL_RETURN_IF_ERROR(Complete(feed, stop));
        continue;
      }
      if (const auto* frame = std::get_if<ArrivedFrame>(&*arrival)) {
        const absl::Status learnt = Take(*frame);
        if (!learnt.ok()) feed.CountUnreadable(learnt);
        if (!poses_status_.ok()) return Refuse();
      } else {
        Correct(std::get<learning::PoseCorrection>(*arrival));
      }
      if (is_complete_) continue;
      CollectTrials();
      PublishIfDue();
      Show(feed.counts());
    }
    if (!is_complete_) {
      TL_RETURN_IF_ERROR(Complete(feed, stop));
    } else if (corrected_ > 0) {
      TL_RETURN_IF_ERROR(WriteCorrected());
    }
    Warn(feed.counts());
    return feed.status();
  }

 private:
  // No more frames will come.
  absl::Status Complete(const LiveFeed& feed, const std::stop_token& stop) {
    display_.Clear();
    const LiveFeedCounts counts = feed.counts();
    if (learner_->frames() == 0) {
      TL_RETURN_IF_ERROR(feed.status());
      return NothingLearnt(counts);
    }
    is_complete_ = true;
    // The answer shall not wait for more trials, unless nothing hurries.
    if (options_.live.rate_hz > 0 || stop.stop_requested()) {
      stop_trials_.request_stop();
    }
    background_.Wait();
    CollectTrials();
    TL_ASSIGN_OR_RETURN(training::LiveModel model, learner_->Finish());
    TL_RETURN_IF_ERROR(Write(model));
    Conclude(model, counts,
             base::SecondsBetween(feed.last_arrival(), clock_.Now()));
    corrected_ = 0;
    return absl::OkStatus();
  }

  // Poses that are meant otherwise: what was learnt with them answers nothing.
  absl::Status Refuse() {
    display_.Clear();
    stop_trials_.request_stop();
    background_.Wait();
    std::error_code none;  // a model may not have been written yet
    std::filesystem::remove(path_, none);
    return poses_status_;
  }

  // The complete model, after poses were corrected once more.
  absl::Status WriteCorrected() {
    const base::MonotonicTime begin = clock_.Now();
    TL_ASSIGN_OR_RETURN(training::LiveModel model, learner_->Model());
    TL_RETURN_IF_ERROR(Write(model));
    absl::PrintF("%s: poses of %d frames corrected, in %.2f s\n", path_,
                 corrected_, base::SecondsBetween(begin, clock_.Now()));
    std::fflush(stdout);
    return absl::OkStatus();
  }

  // Of a frame that was skipped, or could not be read, nothing is to be
  // corrected.
  void Correct(const learning::PoseCorrection& correction) {
    absl::Status status;
    if (options_.live.takes_corrections) {
      const auto number = numbers_.find(correction.color_path);
      if (number == numbers_.end()) return;
      status = learner_->Correct(number->second, correction.world_from_sensor);
    } else {
      status = absl::InvalidArgumentError("that takes --corrections");
    }
    ++(status.ok() ? corrected_ : not_corrected_);
    correction_status_.Update(status);
  }

  absl::Status Take(const ArrivedFrame& arrived) {
    if (is_complete_) {
      return absl::InvalidArgumentError(
          absl::StrCat(arrived.name, ": a frame after the end of frames"));
    }
    image::Frame frame;
    absl::StatusOr<image::ColorImage> color = image::DecodeColor(arrived.color);
    if (!color.ok()) return base::Annotate(color.status(), arrived.name);
    frame.color = *std::move(color);
    absl::StatusOr<image::DepthImage> depth =
        image::DecodeDepthPng(arrived.depth, source_.depth_unit_m);
    if (!depth.ok()) {
      return base::Annotate(depth.status(),
                            absl::StrCat("depth of ", arrived.name));
    }
    frame.depth = *std::move(depth);
    if (source_.pose_watch) {
      poses_status_ =
          source_.pose_watch->Add(*frame.depth, arrived.world_from_sensor);
      if (!poses_status_.ok()) return absl::OkStatus();
    }
    TL_ASSIGN_OR_RETURN(
        std::optional<training::LiveTrials> trials,
        learner_->Add(arrived.name, frame, arrived.world_from_sensor));
    if (options_.live.takes_corrections) {
      numbers_[arrived.name] = learner_->frames() - 1;
    }
    if (!trials) return absl::OkStatus();
    const auto asked =
        std::make_shared<const training::LiveTrials>(*std::move(trials));
    background_.Begin([this, asked] {
      absl::StatusOr<Outcomes> outcomes =
          asked->Run(path_, options_.training.seed, stop_trials_.get_token());
      absl::MutexLock lock(&mutex_);
      background_status_.Update(outcomes.status());
      if (outcomes.ok()) {
        outcomes_.insert(outcomes_.end(), outcomes->begin(), outcomes->end());
      }
    });
    return absl::OkStatus();
  }

  void CollectTrials() {
    Outcomes outcomes;
    {
      absl::MutexLock lock(&mutex_);
      outcomes = std::exchange(outcomes_, {});
    }
    for (std::vector<training::ConfidenceTrial>& of_frame : outcomes) {
      learner_->AddTrials(std::move(of_frame));
    }
  }

  // The model so far, in the place where the complete one will be.
  void PublishIfDue() {
    // Filling leaves again is work that grows with the number of frames.
    const double every_s =
        shown_.empty() ? std::min(options_.live.publish_every_s, kFirstModel_s)
                       : std::max(options_.live.publish_every_s,
                                  kRestAfterModel * model_took_s_);
    if (base::SecondsBetween(last_published_, clock_.Now()) < every_s ||
        !background_.IsIdle()) {
      return;
    }
    const base::MonotonicTime begin = clock_.Now();
    absl::StatusOr<training::LiveModel> model = learner_->Model();
    if (!model.ok()) return;  // nothing with depth was seen yet
    last_published_ = clock_.Now();
    model_took_s_ = base::SecondsBetween(begin, last_published_);
    shown_ = absl::StrFormat("; model of %d frames is there",
                             model->info.training_frames);
    if (model->asked > 0) {
      absl::StrAppendFormat(&shown_, ", %d of %d held-back views right",
                            model->right, model->asked);
    }
    const auto written =
        std::make_shared<training::LiveModel>(*std::move(model));
    background_.Begin([this, written] {
      const absl::Status status = Write(*written);
      absl::MutexLock lock(&mutex_);
      background_status_.Update(status);
    });
  }

  absl::Status Write(training::LiveModel& model) const {
    model.info.training_s = base::SecondsBetween(start_, clock_.Now());
    return model.Write(path_);
  }

  void Show(const LiveFeedCounts& counts) {
    if (options_.quiet) return;
    display_.Show(absl::StrFormat("%d frames, %d keyframes, %d skipped%s",
                                  learner_->frames(), learner_->keyframes(),
                                  counts.skipped, shown_));
  }

  absl::Status NothingLearnt(const LiveFeedCounts& counts) const {
    if (counts.arrived == 0) {
      return absl::FailedPreconditionError(
          absl::StrCat(source_.name, ": no frame came"));
    }
    return absl::FailedPreconditionError(
        absl::StrCat(source_.name, ": none of ", counts.arrived,
                     " frames could be learnt. The first: ",
                     std::string(counts.first_unreadable.message())));
  }

  void Warn(const LiveFeedCounts& counts) {
    {
      absl::MutexLock lock(&mutex_);
      if (!background_status_.ok()) {
        std::fprintf(stderr, "warning: on the way: %s\n",
                     std::string(background_status_.message()).c_str());
      }
    }
    if (counts.unreadable > 0) {
      std::fprintf(stderr, "warning: %d frames were left out. The first: %s\n",
                   static_cast<int>(counts.unreadable),
                   std::string(counts.first_unreadable.message()).c_str());
    }
    if (not_corrected_ > 0) {
      std::fprintf(stderr, "warning: %d poses were not corrected: %s\n",
                   not_corrected_,
                   std::string(correction_status_.message()).c_str());
    }
  }

  void Conclude(const training::LiveModel& model, const LiveFeedCounts& counts,
                double seconds_after) {
    // Without a pace there is no last moment to count from.
    const std::string after =
        options_.live.rate_hz > 0
            ? absl::StrFormat(" %.2f s after the last frame", seconds_after)
            : "";
    absl::PrintF(
        "%s: complete%s\n"
        "%d frames in %.1f s, %d skipped; %d keyframes; peak memory %.0f MiB\n",
        path_, after, learner_->frames(),
        base::SecondsBetween(start_, clock_.Now()), counts.skipped,
        learner_->keyframes(),
        static_cast<double>(tools::PeakMemoryBytes()) / (1 << 20));
    if (model.asked == 0) {
      absl::PrintF(
          "Too few frames to hold some back: how sure it may be of an answer "
          "is that of\nother scenes.\n");
    } else {
      absl::PrintF(
          "Of %d views that it was asked about before it learnt them, it "
          "answered %d rightly\nand %d wrongly.\n",
          model.asked, model.right, model.wrong);
    }
    if (model.wrong > model.right) {
      std::fprintf(stderr,
                   "warning: more answers were wrong than right: do the poses "
                   "belong to these pictures, and the\ncalibration to this "
                   "camera, also in which sensor's pose it says that they "
                   "are?\n");
    }
    std::fflush(stdout);
  }

  using Outcomes = std::vector<std::vector<training::ConfidenceTrial>>;

  const LearnOptions& options_;
  OpenedSource source_;
  const std::unique_ptr<training::LiveLearner> learner_;
  const std::string path_;
  const base::SteadyClock clock_;
  base::MonotonicTime start_;
  base::MonotonicTime last_published_;
  double model_took_s_ = 0;
  bool is_complete_ = false;
  absl::Status poses_status_;
  // Frames by the names of their colour pictures, where poses are corrected;
  // and how many were, since the complete model was written.
  std::unordered_map<std::string, int> numbers_;
  int corrected_ = 0;
  int not_corrected_ = 0;
  absl::Status correction_status_;
  base::LiveDisplay display_;
  std::string shown_;  // of the model that was published last
  std::stop_source stop_trials_;
  absl::Mutex mutex_;
  Outcomes outcomes_ ABSL_GUARDED_BY(mutex_);
  absl::Status background_status_ ABSL_GUARDED_BY(mutex_);
  Background background_;  // the last: it uses the others
};

absl::Status CheckFlags(const LearnOptions& options) {
  if (!(options.live.rate_hz >= 0 && options.live.rate_hz <= 1000)) {
    return absl::InvalidArgumentError("--rate must be between 0 and 1000");
  }
  if (!(options.live.publish_every_s >= 0)) {
    return absl::InvalidArgumentError("--publish-every must not be negative");
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status LearnLive(const LearnOptions& given, const std::stop_token& stop) {
  LearnOptions options = given;
  TL_RETURN_IF_ERROR(CheckFlags(options));
  if (options.live.base_model.empty()) {
    options.live.base_model = base::FindInstalledFile(
        "models/base-rgbd.treeline", TREELINE_BASE_MODEL);
  }
  if (options.live.base_model.empty()) {
    return absl::NotFoundError(
        "the model that learning begins with is not installed "
        "(share/treeline/models/base-rgbd.treeline): give --base MODEL");
  }
  TL_RETURN_IF_ERROR(tools::CheckFolderCanBeMade(options.repository));
  if (options.scene.empty() && options.source != kStandardInput) {
    options.scene = learning::SceneNameOf(options.source);
  }
  TL_ASSIGN_OR_RETURN(OpenedSource source, options.source == kStandardInput
                                               ? OpenStandardInput(options)
                                               : OpenRecording(options, stop));
  TL_RETURN_IF_ERROR(repository::CheckName("--scene", options.scene));
  TL_ASSIGN_OR_RETURN(const std::string path,
                      tools::NextModelPath(options.repository, options.scene));
  absl::StatusOr<std::unique_ptr<training::LiveLearner>> learner =
      training::LiveLearner::Create(
          options.live.base_model, source.calibration,
          {.seed = options.training.seed,
           .threads = options.training.threads,
           .software_version = base::Version(),
           .created_utc = tools::UtcNow(),
           .dataset = source.name,
           .recorded_options = RecordedLiveOptions(given),
           .memory_folder = options.live.takes_corrections
                                ? path.substr(0, path.rfind('/'))
                                : ""});
  absl::Status status = learner.status();
  if (status.ok()) {
    LiveRun run(options, std::move(source), *std::move(learner), path);
    status = run.Run(stop);
  }
  if (!status.ok()) tools::RemoveEmptyVersion(path);
  return status;
}

}  // namespace treeline::tools_app
