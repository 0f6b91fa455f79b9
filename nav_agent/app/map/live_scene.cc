#include "nav_agent/app/map/live_scene.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <system_error>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/camera/calibration_json.h"
#include "common/dataset/tum.h"
#include "common/image/decode.h"

namespace treeline::map_app {
namespace {

constexpr const char* kLearner = "treeline";
// Below what drives and maps. As in nice(1).
constexpr const char* kNiceness = "10";
// Between two scans; a longer silence of the laser leaves a hole.
constexpr dataset::Time_ns kMaxGap_ns = 500'000'000;
// Frames that wait for their place at most; 5 s at 10 Hz.
constexpr size_t kMaxWaiting = 50;
// Pictures are kept until so many others have come. The learner reads them when
// it reads their line, so that a few would do.
constexpr size_t kKeptPictures = 200;
// At the end every frame is put where the map has it that is further off than
// depth is wrong.
constexpr double kEnd_m = 0.005;
constexpr double kEnd_rad = 0.002;
constexpr auto kPoll = std::chrono::milliseconds(20);
// For a learner that does not read: none while driving, then so long.
constexpr std::chrono::milliseconds kEndPatience(1000);
// Filling leaves again takes a fiftieth of that for each frame.
constexpr std::chrono::milliseconds kPatiencePerFrame(100);
// What has not been read by then never will be.
constexpr size_t kMaxUnsentBytes = size_t{16} << 20;

std::string FindLearner(const std::string& named) {
  if (!named.empty()) return base::FindProgram(named);
  const absl::StatusOr<std::string> beside = base::SiblingProgram(kLearner);
  return beside.ok() ? *beside : base::FindProgram(kLearner);
}

dataset::Time_ns TimeOf(base::MonotonicTime stamp) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             stamp.time_since_epoch())
      .count();
}

std::string Text(const geometry::Rigid3& pose) {
  const geometry::Vec3& t = pose.translation;
  const geometry::Rotation3& q = pose.rotation;
  return absl::StrFormat("%.6f %.6f %.6f %.9f %.9f %.9f %.9f\n", t.x, t.y, t.z,
                         q.x, q.y, q.z, q.w);
}

}  // namespace

absl::Status LiveSceneOptions::Validate() const {
  if (folder.find_first_of(" \t\n") != std::string::npos) {
    return absl::InvalidArgumentError(
        absl::StrCat("'", folder,
                     "': the scene can be learnt where the map's folder has no "
                     "blanks in its name"));
  }
  if (FindLearner(learner).empty()) {
    return absl::NotFoundError(
        learner.empty()
            ? "there is no program `treeline` beside this one or in PATH; name "
              "it with --learner"
            : absl::StrCat("there is no program ", learner));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<LiveScene>> LiveScene::Create(
    const LiveSceneOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  return std::unique_ptr<LiveScene>(new LiveScene(options));
}

LiveScene::LiveScene(const LiveSceneOptions& options)
    : options_(options), gate_(options.keyframe_m, options.keyframe_rad) {}

// Without Finish, the learner may finish what it has read.
LiveScene::~LiveScene() {
  if (learner_ != nullptr && unsent_.empty()) {
    learner_->CloseInput();
    AwaitLearner(options_.patience, {});
  }
  std::error_code ignored;
  std::filesystem::remove_all(options_.folder, ignored);
}

absl::Status LiveScene::Start(const recording::LogFrame& frame) {
  std::error_code error;
  std::filesystem::remove_all(options_.folder, error);
  std::filesystem::create_directories(options_.folder, error);
  if (error) {
    return absl::UnavailableError(
        absl::StrCat("making ", options_.folder, ": ", error.message()));
  }
  const std::string calibration = options_.folder + "/calibration.json";
  TL_RETURN_IF_ERROR(base::WriteFileAtomically(
      calibration, camera::CalibrationToJson(*calibration_)));
  std::vector<std::string> argv;
  if (const std::string nice = base::FindProgram("nice"); !nice.empty()) {
    argv = {nice, "-n", kNiceness};
  }
  for (const std::string& argument :
       {FindLearner(options_.learner), std::string("learn"),
        std::string("--live"), std::string("-"), std::string("--corrections"),
        std::string("--quiet"), std::string("--repository"),
        options_.repository, std::string("--scene"), options_.scene,
        std::string("--calibration"), calibration, std::string("--depth-unit"),
        absl::StrCat(frame.depth_unit_m), std::string("--publish-every"),
        absl::StrCat(options_.publish_every_s)}) {
    argv.push_back(argument);
  }
  TL_ASSIGN_OR_RETURN(learner_,
                      base::ChildProcess::StartWithInput(argv, options_.log));
  return absl::OkStatus();
}

// Mapping goes on without.
void LiveScene::GiveUp(const absl::Status& why) {
  if (has_given_up_) return;
  has_given_up_ = true;
  waiting_.clear();
  unsent_.clear();
  if (learner_ != nullptr) learner_->CloseInput();
  options_.say(
      absl::StrCat("The scene is learnt no further; the map is not concerned: ",
                   std::string(why.message())));
}

void LiveScene::Add(recording::LogFrame frame,
                    const camera::RgbdCalibration& calibration) {
  if (has_given_up_ || frame.depth.empty()) return;
  if (!calibration_.has_value()) {
    calibration_ = calibration;
    if (const absl::Status started = Start(frame); !started.ok()) {
      return GiveUp(started);
    }
  } else if (*calibration_ != calibration) {
    return GiveUp(
        absl::FailedPreconditionError("the camera's calibration has changed"));
  }
  waiting_.push_back(std::move(frame));
  if (waiting_.size() > kMaxWaiting) {
    waiting_.pop_front();
    ++status_.without_place;
  }
}

void LiveScene::Place(std::span<const dataset::TimedPose> map_from_base,
                      const geometry::Rigid3& base_from_camera) {
  while (!has_given_up_ && !waiting_.empty() && !map_from_base.empty()) {
    const dataset::Time_ns time = TimeOf(waiting_.front().stamp);
    if (time > map_from_base.back().time) return;
    const recording::LogFrame frame = std::move(waiting_.front());
    waiting_.pop_front();
    const std::optional<geometry::Rigid3> map_from_here =
        dataset::InterpolatePose(map_from_base, time, kMaxGap_ns);
    if (!map_from_here.has_value()) {
      ++status_.without_place;
      continue;
    }
    const geometry::Rigid3 map_from_camera = *map_from_here * base_from_camera;
    if (gate_.Passes(map_from_camera)) HandOver(frame, map_from_camera);
  }
}

void LiveScene::HandOver(const recording::LogFrame& frame,
                         const geometry::Rigid3& map_from_camera) {
  const std::string stem =
      absl::StrFormat("%s/frame-%06d", options_.folder, frames_.size());
  const bool is_jpeg =
      image::SniffFormat(frame.color) == image::ImageFormat::kJpeg;
  HandedOver handed_over{
      .time = TimeOf(frame.stamp),
      .color_path = stem + (is_jpeg ? ".color.jpg" : ".color.png"),
      .depth_path = stem + ".depth.png",
      .map_from_camera = map_from_camera};
  absl::Status written =
      base::WriteNewFile(handed_over.color_path, frame.color);
  written.Update(base::WriteNewFile(handed_over.depth_path, frame.depth));
  if (!written.ok()) {
    if (status_.not_handed_over++ == 0) {
      options_.say(absl::StrCat("Not learnt: ", written.message()));
    }
    std::error_code ignored;
    std::filesystem::remove(handed_over.color_path, ignored);
    std::filesystem::remove(handed_over.depth_path, ignored);
    return;
  }
  absl::StrAppend(&unsent_, handed_over.color_path, " ", handed_over.depth_path,
                  " ", Text(map_from_camera));
  frames_.push_back(std::move(handed_over));
  ++status_.frames;
  if (frames_.size() > kKeptPictures) {
    const HandedOver& old = frames_[frames_.size() - 1 - kKeptPictures];
    std::error_code ignored;
    std::filesystem::remove(old.color_path, ignored);
    std::filesystem::remove(old.depth_path, ignored);
  }
}

void LiveScene::CorrectBeyond(double distance_m, double turn_rad,
                              std::span<const dataset::TimedPose> map_from_base,
                              const geometry::Rigid3& base_from_camera) {
  double furthest_m = 0;
  bool is_far = false;
  std::vector<std::pair<size_t, geometry::Rigid3>> moved;
  for (size_t i = 0; i < frames_.size(); ++i) {
    const std::optional<geometry::Rigid3> map_from_here =
        dataset::InterpolatePose(map_from_base, frames_[i].time, kMaxGap_ns);
    if (!map_from_here.has_value()) continue;
    const geometry::Rigid3 now = *map_from_here * base_from_camera;
    const geometry::PoseError change =
        geometry::ErrorBetween(now, frames_[i].map_from_camera);
    if (change.translation_m < kEnd_m && change.rotation_rad < kEnd_rad) {
      continue;
    }
    furthest_m = std::max(furthest_m, change.translation_m);
    is_far |=
        change.translation_m >= distance_m || change.rotation_rad >= turn_rad;
    moved.emplace_back(i, now);
  }
  if (!is_far) return;
  for (const auto& [i, now] : moved) {
    frames_[i].map_from_camera = now;
    absl::StrAppend(&unsent_, "pose ", frames_[i].color_path, " ", Text(now));
  }
  ++status_.corrections;
  status_.moved_m = furthest_m;
}

void LiveScene::Send() {
  if (has_given_up_ || learner_ == nullptr) return;
  const absl::StatusOr<size_t> sent = learner_->Send(unsent_);
  if (sent.ok()) unsent_.erase(0, *sent);
  // One that reads no more has ended, or will soon have.
  if (const std::optional<int> code = learner_->ExitCode(); code.has_value()) {
    GiveUp(absl::UnavailableError(absl::StrCat("the learner has ended with ",
                                               *code, "; ", options_.log,
                                               " says\n", learner_->Log())));
  } else if (unsent_.size() > kMaxUnsentBytes) {
    GiveUp(absl::UnavailableError("the learner reads nothing any more"));
  }
}

void LiveScene::Follow(std::span<const dataset::TimedPose> map_from_base,
                       const geometry::Rigid3& base_from_camera) {
  if (has_given_up_) return;
  Place(map_from_base, base_from_camera);
  CorrectBeyond(options_.moved_m, options_.moved_rad, map_from_base,
                base_from_camera);
  Send();
}

void LiveScene::End(std::span<const dataset::TimedPose> map_from_base,
                    const geometry::Rigid3& base_from_camera) {
  if (has_given_up_) return;
  Place(map_from_base, base_from_camera);
  status_.without_place += static_cast<int64_t>(waiting_.size());
  waiting_.clear();
  CorrectBeyond(options_.moved_m, options_.moved_rad, map_from_base,
                base_from_camera);
  absl::StrAppend(&unsent_, "end\n");
  SendAll(kEndPatience);
}

void LiveScene::SendAll(std::chrono::milliseconds patience) {
  for (auto waited = patience * 0; waited < patience; waited += kPoll) {
    Send();
    if (unsent_.empty()) return;
    std::this_thread::sleep_for(kPoll);
  }
}

void LiveScene::Finish(std::span<const dataset::TimedPose> map_from_base,
                       const geometry::Rigid3& base_from_camera,
                       const std::stop_token& stop) {
  if (learner_ == nullptr || has_given_up_) return;
  CorrectBeyond(kEnd_m, kEnd_rad, map_from_base, base_from_camera);
  SendAll(options_.patience);
  if (has_given_up_) return;
  learner_->CloseInput();
  if (!AwaitLearner(options_.patience + kPatiencePerFrame * frames_.size(),
                    stop)) {
    learner_.reset();
    return GiveUp(absl::DeadlineExceededError(
        "the learner has not written the model with the map's poses"));
  }
  if (const absl::Status ended = learner_->Wait(stop); !ended.ok()) {
    return GiveUp(ended);
  }
  options_.say(learner_->Log());
}

bool LiveScene::AwaitLearner(std::chrono::milliseconds patience,
                             const std::stop_token& stop) {
  for (auto waited = patience * 0; waited < patience; waited += kPoll) {
    if (learner_->ExitCode().has_value()) return true;
    if (stop.stop_requested()) return false;
    std::this_thread::sleep_for(kPoll);
  }
  return learner_->ExitCode().has_value();
}

}  // namespace treeline::map_app
