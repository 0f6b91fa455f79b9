#include "simulation/recorder/recorder.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <system_error>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/synchronization/mutex.h"
#include "common/base/check_range.h"
#include "common/base/file.h"
#include "common/base/parallel_for.h"
#include "common/base/status_macros.h"
#include "common/dataset/frame_use.h"
#include "common/dataset/tum.h"
#include "common/image/rolling_shutter.h"
#include "simulation/recorder/record_files.h"
#include "simulation/recorder/tour_walk.h"
#include "simulation/recorder/walk.h"

namespace treeline::recorder {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxFrames = 100000;

// A folder that is removed with all that is in it, unless it is kept.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(std::string path) : path_(std::move(path)) {}
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::string& path() const { return path_; }

  // A folder in it.
  absl::Status Create(const std::string& name) const {
    const std::string path = absl::StrCat(path_, "/", name);
    std::error_code error;
    fs::create_directories(path, error);
    if (!error) return absl::OkStatus();
    return absl::ErrnoToStatus(error.value(),
                               absl::StrCat("creating folder ", path));
  }
  // Takes what it has there out of it.
  absl::Status Move(const std::string& name, const std::string& target) const {
    std::error_code error;
    fs::rename(absl::StrCat(path_, "/", name), target, error);
    if (!error) return absl::OkStatus();
    return absl::ErrnoToStatus(error.value(),
                               absl::StrCat("renaming to ", target));
  }

 private:
  std::string path_;
};

// The first error of many threads.
class FirstError {
 public:
  void Set(const absl::Status& status) {
    const absl::MutexLock lock(&mutex_);
    if (status_.ok()) status_ = status;
  }
  absl::Status Get() const {
    const absl::MutexLock lock(&mutex_);
    return status_;
  }

 private:
  mutable absl::Mutex mutex_;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
};

std::string FrameList(const RecordOptions& options,
                      const std::vector<dataset::TimedPose>& frames,
                      dataset::FrameUse use) {
  const int count = static_cast<int>(frames.size());
  std::string list;
  for (int i = 0; i < count; ++i) {
    if (dataset::UseOfFrame(i, count) == use) {
      absl::StrAppend(
          &list, StemOf(options, i, frames[static_cast<size_t>(i)].time), "\n");
    }
  }
  return list;
}

std::string Description(const RecordOptions& options,
                        const sensors::SyntheticCamera& camera, int frames) {
  const camera::RgbdCalibration& calibration = camera.calibration();
  const bool is_tum = options.format == RecordFormat::kTum;
  const camera::Camera& depth = is_tum ? calibration.color : calibration.depth;
  const geometry::Vec3 t =
      is_tum ? geometry::Vec3{} : calibration.color_from_depth.translation;
  std::string text = absl::StrFormat(
      "world %s\nlight %s\nrearranged %d:%g\nseed %d\nframes %d\n"
      "rate_hz %g\n"
      "color_camera %s\ndepth_camera %s\n"
      "# qw qx qy qz tx ty tz (m)\n"
      "color_from_depth 1 0 0 0 %g %g %g\n"
      "# %s: world_from_camera of this camera\n"
      "pose_sensor %s\n",
      options.world, building::LightingName(camera.renderer().world().lighting),
      options.world_options.rearranged.seed,
      options.world_options.rearranged.share, options.seed, frames,
      options.rate_hz, calibration.color.ToString(), depth.ToString(), t.x, t.y,
      t.z, is_tum ? "groundtruth.txt" : ".pose.txt",
      is_tum ? "color" : "depth");
  if (options.readout_s > 0) {
    absl::StrAppendFormat(&text, "readout_s %g\n", options.readout_s);
  }
  return text;
}

// Where the pose sensor is at any time (s).
absl::StatusOr<CameraPath> PathOf(const RecordOptions& options,
                                  const renderer::Renderer& renderer) {
  if (options.trajectory.empty()) {
    return MakeCameraPath(renderer.world(), renderer.caster(), options.seed);
  }
  return CameraPath([&poses = options.trajectory](double time_s) {
    const auto time =
        std::clamp(static_cast<dataset::Time_ns>(std::llround(time_s * 1e9)),
                   poses.front().time, poses.back().time);
    return *dataset::InterpolatePose(
        poses, time, std::numeric_limits<dataset::Time_ns>::max());
  });
}

double Seconds(dataset::Time_ns time) {
  return 1e-9 * static_cast<double>(time);
}

// When each frame is taken, and from where.
std::vector<dataset::TimedPose> FramesOf(const RecordOptions& options,
                                         const CameraPath& path) {
  if (!options.trajectory.empty() && !options.is_resampled) {
    return options.trajectory;
  }
  const double start_s =
      options.trajectory.empty() ? 0 : Seconds(options.trajectory.front().time);
  std::vector<dataset::TimedPose> frames;
  for (int i = 0; i < FrameCount(options); ++i) {
    const double time_s = start_s + static_cast<double>(i) / options.rate_hz;
    frames.push_back(
        {.time = static_cast<dataset::Time_ns>(std::llround(1e9 * time_s)),
         .world_from_camera = path(time_s)});
  }
  return frames;
}

// The camera's poses while the shutter is open about a frame's time.
std::vector<geometry::Rigid3> PosesOf(const RecordOptions& options,
                                      const CameraPath& path,
                                      const dataset::TimedPose& frame) {
  if (!(options.shutter_s > 0)) return {frame.world_from_camera};
  constexpr int kPoses = 5;
  std::vector<geometry::Rigid3> poses;
  for (int i = 0; i < kPoses; ++i) {
    const double part = (i + 0.5) / kPoses - 0.5;
    // The one in the middle is the frame's own, to the last bit.
    poses.push_back(2 * i + 1 == kPoses
                        ? frame.world_from_camera
                        : path(Seconds(frame.time) + part * options.shutter_s));
  }
  return poses;
}

image::Frame Taken(const RecordOptions& options,
                   const sensors::SyntheticCamera& camera,
                   const renderer::WorldSnapshot& snapshot,
                   const CameraPath& path, const dataset::TimedPose& frame,
                   uint64_t index) {
  if (!(options.readout_s > 0)) {
    return camera.CaptureMoving(snapshot, PosesOf(options, path, frame), index,
                                1);
  }
  return camera.CaptureRolling(
      snapshot,
      [&](double row_share) {
        return path(Seconds(frame.time) + row_share * options.readout_s);
      },
      index, 1);
}

absl::Status RecordFrame(const RecordOptions& options,
                         const sensors::SyntheticCamera& camera,
                         const renderer::PixelRays& rays,
                         const CameraPath& path,
                         const dataset::TimedPose& frame, int index,
                         const std::string& folder) {
  const renderer::Renderer& renderer = camera.renderer();
  const renderer::WorldSnapshot snapshot =
      renderer.caster().At(renderer.world().InstancesAt(Seconds(frame.time)));
  TL_RETURN_IF_ERROR(WriteFrameFiles(options, folder, index, frame.time,
                                     Taken(options, camera, snapshot, path,
                                           frame, static_cast<uint64_t>(index)),
                                     frame.world_from_camera));
  if (!options.has_truth) return absl::OkStatus();
  return WriteTruthFiles(
      folder, index, rays,
      renderer.RenderTruth(snapshot, rays, frame.world_from_camera, 1));
}

absl::Status RecordFrames(const RecordOptions& options,
                          const sensors::SyntheticCamera& camera,
                          const CameraPath& path,
                          const std::vector<dataset::TimedPose>& frames,
                          const std::string& folder,
                          const std::function<void()>& done,
                          const std::stop_token& stop) {
  const renderer::PixelRays rays(camera.calibration().pose_sensor ==
                                         camera::RgbdSensor::kDepth
                                     ? camera.calibration().depth
                                     : camera.calibration().color);
  FirstError error;
  base::ParallelFor(
      static_cast<int64_t>(frames.size()), options.threads, [&](int64_t i) {
        if (stop.stop_requested() || !error.Get().ok()) return;
        const absl::Status status = RecordFrame(options, camera, rays, path,
                                                frames[static_cast<size_t>(i)],
                                                static_cast<int>(i), folder);
        if (!status.ok()) {
          error.Set(status);
        } else if (done) {
          done();
        }
      });
  if (stop.stop_requested()) return absl::CancelledError("recording stopped");
  return error.Get();
}

absl::Status CheckNoRecording(const RecordOptions& options) {
  for (const std::string& name : FoldersOf(options)) {
    const std::string path = absl::StrCat(options.folder, "/", name);
    std::error_code error;
    if (fs::exists(path, error)) {
      return absl::AlreadyExistsError(
          absl::StrCat(path, " is there already; choose another folder"));
    }
  }
  return absl::OkStatus();
}

sensors::SyntheticCamera::Options CameraOptions(const RecordOptions& options,
                                                building::Lighting lighting) {
  sensors::SyntheticCamera::Options camera;
  camera.seed = options.seed;
  camera.color = sensors::ColorSensorFor(lighting);
  if (options.is_exposure_automatic) camera.color.is_automatic = true;
  if (options.format == RecordFormat::kTum) {
    // What readers of TUM take a sequence for that does not say.
    constexpr double kColor[] = {525, 525, 319.5, 239.5};
    camera.calibration.color = *camera::Camera::Create(
        camera::CameraModel::kPinhole, 640, 480, kColor, 4);
    camera.calibration.pose_sensor = camera::RgbdSensor::kColor;
    camera.is_depth_registered = true;
  }
  return camera;
}

absl::Status WriteLists(const RecordOptions& options,
                        const sensors::SyntheticCamera& camera,
                        const std::vector<dataset::TimedPose>& frames) {
  std::vector<NamedText> texts;
  if (options.format == RecordFormat::kTum) {
    texts = TumLists(frames, options.world);
  }
  texts.push_back(
      {"recording.txt",
       Description(options, camera, static_cast<int>(frames.size()))});
  texts.push_back(
      {"train.txt", FrameList(options, frames, dataset::FrameUse::kTrain)});
  texts.push_back(
      {"test.txt", FrameList(options, frames, dataset::FrameUse::kTest)});
  for (const NamedText& file : texts) {
    TL_RETURN_IF_ERROR(base::WriteFileAtomically(
        absl::StrCat(options.folder, "/", file.name), file.text));
  }
  return absl::OkStatus();
}

absl::Status CheckTrajectory(const RecordOptions& options) {
  if (options.frames < 1 || options.frames > kMaxFrames) {
    return absl::InvalidArgumentError(
        absl::StrCat(options.frames, " frames is outside 1..", kMaxFrames));
  }
  if (options.trajectory.size() > static_cast<size_t>(kMaxFrames)) {
    return absl::InvalidArgumentError(
        absl::StrCat("a trajectory of ", options.trajectory.size(),
                     " poses; at most ", kMaxFrames));
  }
  if (!options.is_resampled) return absl::OkStatus();
  const double length_s =
      Seconds(options.trajectory.back().time - options.trajectory.front().time);
  // Half a frame's grace, for rounding.
  const double wanted_s = (options.frames - 1.5) / options.rate_hz;
  if (wanted_s <= length_s) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "%d frames at %g Hz are longer than the trajectory of %g s",
      options.frames, options.rate_hz, length_s));
}

}  // namespace

int FrameCount(const RecordOptions& options) {
  return options.trajectory.empty() || options.is_resampled
             ? options.frames
             : static_cast<int>(options.trajectory.size());
}

absl::Status RecordOptions::Validate() const {
  if (folder.empty()) {
    return absl::InvalidArgumentError("no folder to record into");
  }
  if (!(rate_hz >= 0.1) || !(rate_hz <= 1000)) {
    return absl::InvalidArgumentError(
        absl::StrCat("frame rate of ", rate_hz, " Hz is outside 0.1..1000"));
  }
  if (!trajectory.empty()) {
    TL_RETURN_IF_ERROR(CheckTrajectory(*this));
  } else if (frames < 5 || frames > kMaxFrames) {
    return absl::InvalidArgumentError(
        absl::StrCat(frames, " frames is outside 5..", kMaxFrames));
  }
  TL_RETURN_IF_ERROR(base::CheckRange("shutter time (s)", shutter_s, 0, 0.5));
  TL_RETURN_IF_ERROR(
      base::CheckRange("readout time (s)", readout_s, 0, image::kMaxReadout_s));
  if (shutter_s > 0 && readout_s > 0) {
    return absl::InvalidArgumentError(
        "a shutter that stays open and one that rolls cannot be combined");
  }
  TL_RETURN_IF_ERROR(base::CheckRange("JPEG quality", jpeg_quality, 1, 100));
  return base::CheckRange("lowest JPEG quality", lowest_jpeg_quality, 1,
                          jpeg_quality);
}

absl::Status RecordWorld(const RecordOptions& options,
                         const std::function<void()>& done,
                         const std::stop_token& stop) {
  // What would be found out later, found out before seconds of painting.
  TL_RETURN_IF_ERROR(options.Validate());
  TL_RETURN_IF_ERROR(CheckNoRecording(options));
  if (stop.stop_requested()) return absl::CancelledError("recording stopped");
  worlds::WorldOptions world_options = options.world_options;
  world_options.threads = options.threads;
  TL_ASSIGN_OR_RETURN(worlds::World world,
                      worlds::MakeWorld(options.world, world_options));
  return RecordIn(std::move(world), options, done, stop);
}

absl::Status RecordIn(worlds::World world, const RecordOptions& options,
                      const std::function<void()>& done,
                      const std::stop_token& stop) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_RETURN_IF_ERROR(CheckNoRecording(options));
  const TemporaryFolder folder(
      absl::StrCat(options.folder, "/recording.tmp-", getpid()));
  for (const std::string& name : FoldersOf(options)) {
    TL_RETURN_IF_ERROR(folder.Create(name));
  }
  TL_ASSIGN_OR_RETURN(
      std::shared_ptr<const renderer::Renderer> renderer,
      renderer::Renderer::Create(std::move(world), options.threads));
  TL_ASSIGN_OR_RETURN(const CameraPath path, PathOf(options, *renderer));
  const std::vector<dataset::TimedPose> frames = FramesOf(options, path);
  const building::Lighting lighting = renderer->world().lighting;
  TL_ASSIGN_OR_RETURN(
      const sensors::SyntheticCamera camera,
      sensors::SyntheticCamera::Create(std::move(renderer),
                                       CameraOptions(options, lighting)));
  TL_RETURN_IF_ERROR(
      RecordFrames(options, camera, path, frames, folder.path(), done, stop));
  TL_RETURN_IF_ERROR(WriteLists(options, camera, frames));
  for (const std::string& name : FoldersOf(options)) {
    TL_RETURN_IF_ERROR(
        folder.Move(name, absl::StrCat(options.folder, "/", name)));
  }
  return absl::OkStatus();
}

}  // namespace treeline::recorder
