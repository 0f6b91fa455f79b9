#include "common/synthetic/recorder.h"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/synchronization/mutex.h"
#include "common/base/file.h"
#include "common/base/parallel_for.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "common/synthetic/walk.h"

namespace treeline {
namespace {

namespace fs = std::filesystem;

constexpr char kSequence[] = "seq-01";

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

  absl::Status Create() const {
    std::error_code error;
    fs::create_directories(path_, error);
    if (!error) return absl::OkStatus();
    return absl::ErrnoToStatus(error.value(),
                               absl::StrCat("creating folder ", path_));
  }
  absl::Status MoveTo(const std::string& target) {
    std::error_code error;
    fs::rename(path_, target, error);
    if (error) {
      return absl::ErrnoToStatus(error.value(),
                                 absl::StrCat("renaming to ", target));
    }
    path_.clear();
    return absl::OkStatus();
  }

 private:
  std::string path_;
};

// A file in a folder that is not visible yet: neither atomic nor synced.
absl::Status WriteNewFile(const std::string& path, absl::string_view bytes) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) {
    return absl::ErrnoToStatus(errno, absl::StrCat("creating ", path));
  }
  errno = 0;
  const bool written =
      std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  const int write_error = errno;
  const bool closed = std::fclose(file) == 0;
  if (written && closed) return absl::OkStatus();
  return absl::ErrnoToStatus(written ? errno : write_error,
                             absl::StrCat("writing ", path));
}

std::string FrameName(int frame) {
  return absl::StrFormat("frame-%06d", frame);
}

std::string PoseText(const Rigid3& world_from_camera) {
  const Mat3 r = world_from_camera.rotation.Matrix();
  const Vec3& t = world_from_camera.translation;
  std::string text;
  for (int row = 0; row < 3; ++row) {
    absl::StrAppendFormat(&text, "%.12f %.12f %.12f %.12f\n", r(row, 0),
                          r(row, 1), r(row, 2), t[row]);
  }
  return text + "0 0 0 1\n";
}

absl::Status WriteFrame(const std::string& folder, int index,
                        const Frame& frame, const Rigid3& world_from_camera,
                        int jpeg_quality) {
  const std::string base = absl::StrCat(folder, "/", FrameName(index));
  TL_ASSIGN_OR_RETURN(const std::string color,
                      EncodeJpeg(frame.color, jpeg_quality));
  TL_ASSIGN_OR_RETURN(const std::string depth, EncodeDepthPng(*frame.depth));
  TL_RETURN_IF_ERROR(WriteNewFile(base + ".color.jpg", color));
  TL_RETURN_IF_ERROR(WriteNewFile(base + ".depth.png", depth));
  return WriteNewFile(base + ".pose.txt", PoseText(world_from_camera));
}

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

std::string FrameList(const RecordOptions& options, FrameUse use) {
  std::string list;
  for (int i = 0; i < options.frames; ++i) {
    if (UseOfFrame(i, options.frames) == use) {
      absl::StrAppend(&list, kSequence, "/", FrameName(i), "\n");
    }
  }
  return list;
}

std::string Description(const RecordOptions& options,
                        const RgbdCalibration& calibration) {
  const Vec3& t = calibration.color_from_depth.translation;
  return absl::StrFormat(
      "world %s\nseed %d\nframes %d\nrate_hz %g\n"
      "color_camera %s\ndepth_camera %s\n"
      "# qw qx qy qz tx ty tz (m)\n"
      "color_from_depth 1 0 0 0 %g %g %g\n"
      "# .pose.txt: world_from_camera of this camera\n"
      "pose_sensor depth\n",
      options.world, options.seed, options.frames, options.rate_hz,
      calibration.color.ToString(), calibration.depth.ToString(), t.x, t.y,
      t.z);
}

absl::Status RecordFrames(const RecordOptions& options,
                          const SyntheticCamera& camera, const Walk& walk,
                          const std::string& folder,
                          const std::function<void()>& done,
                          const std::stop_token& stop) {
  FirstError error;
  ParallelFor(options.frames, options.threads, [&](int64_t i) {
    if (stop.stop_requested() || !error.Get().ok()) return;
    const int frame = static_cast<int>(i);
    const Rigid3 world_from_camera =
        walk.WorldFromCameraAt(static_cast<double>(frame) / options.rate_hz);
    const absl::Status status = WriteFrame(
        folder, frame,
        camera.Capture(world_from_camera, static_cast<uint64_t>(frame), 1),
        world_from_camera, options.jpeg_quality);
    if (!status.ok()) {
      error.Set(status);
    } else if (done) {
      done();
    }
  });
  if (stop.stop_requested()) return absl::CancelledError("recording stopped");
  return error.Get();
}

std::string SequencePath(const RecordOptions& options) {
  return absl::StrCat(options.folder, "/", kSequence);
}

absl::Status CheckNoRecording(const RecordOptions& options) {
  std::error_code error;
  if (!fs::exists(SequencePath(options), error)) return absl::OkStatus();
  return absl::AlreadyExistsError(absl::StrCat(
      SequencePath(options), " is there already; choose another folder"));
}

}  // namespace

absl::Status RecordOptions::Validate() const {
  if (folder.empty()) {
    return absl::InvalidArgumentError("no folder to record into");
  }
  if (frames < 5 || frames > 100000) {
    return absl::InvalidArgumentError(
        absl::StrCat(frames, " frames is outside 5..100000"));
  }
  if (!(rate_hz >= 0.1) || !(rate_hz <= 1000)) {
    return absl::InvalidArgumentError(
        absl::StrCat("frame rate of ", rate_hz, " Hz is outside 0.1..1000"));
  }
  if (jpeg_quality < 1 || jpeg_quality > 100) {
    return absl::InvalidArgumentError(
        absl::StrCat("JPEG quality ", jpeg_quality, " is outside 1..100"));
  }
  return absl::OkStatus();
}

absl::Status RecordSevenScenes(const RecordOptions& options,
                               const std::function<void()>& done,
                               const std::stop_token& stop) {
  // What would be found out later, found out before seconds of painting.
  TL_RETURN_IF_ERROR(options.Validate());
  TL_RETURN_IF_ERROR(CheckNoRecording(options));
  if (stop.stop_requested()) return absl::CancelledError("recording stopped");
  TL_ASSIGN_OR_RETURN(World world,
                      MakeWorld(options.world, {.threads = options.threads}));
  return RecordSevenScenesIn(std::move(world), options, done, stop);
}

absl::Status RecordSevenScenesIn(World world, const RecordOptions& options,
                                 const std::function<void()>& done,
                                 const std::stop_token& stop) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_RETURN_IF_ERROR(CheckNoRecording(options));
  const std::string sequence = SequencePath(options);
  TemporaryFolder folder(absl::StrCat(sequence, ".tmp-", getpid()));
  TL_RETURN_IF_ERROR(folder.Create());

  const Walk walk(world.walk_area, options.seed);
  TL_ASSIGN_OR_RETURN(std::shared_ptr<const Renderer> renderer,
                      Renderer::Create(std::move(world), options.threads));
  SyntheticCamera::Options camera_options;
  camera_options.seed = options.seed;
  TL_ASSIGN_OR_RETURN(
      const SyntheticCamera camera,
      SyntheticCamera::Create(std::move(renderer), camera_options));
  TL_RETURN_IF_ERROR(
      RecordFrames(options, camera, walk, folder.path(), done, stop));

  TL_RETURN_IF_ERROR(
      WriteFileAtomically(options.folder + "/recording.txt",
                          Description(options, camera.calibration())));
  TL_RETURN_IF_ERROR(WriteFileAtomically(options.folder + "/train.txt",
                                         FrameList(options, FrameUse::kTrain)));
  TL_RETURN_IF_ERROR(WriteFileAtomically(options.folder + "/test.txt",
                                         FrameList(options, FrameUse::kTest)));
  return folder.MoveTo(sequence);
}

}  // namespace treeline
