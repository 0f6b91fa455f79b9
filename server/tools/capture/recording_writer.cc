#include "server/tools/capture/recording_writer.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/strip.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/camera/calibration_json.h"
#include "common/dataset/frame_use.h"
#include "common/dataset/text_formats.h"
#include "common/image/decode.h"
#include "common/image/quarter_turn.h"
#include "server/tools/capture/common_camera.h"
#include "server/tools/capture/conventions.h"

namespace treeline::capture {
namespace {

namespace fs = std::filesystem;
using image::QuarterTurn;

constexpr int kJpegQuality = 95;
// Cameras that differ by less are one.
constexpr double kSameCamera_px = 0.25;
// A depth map whose shape is another than the picture's by more has not its
// field of view.
constexpr double kMaxShapeDifference = 0.02;

// A folder that is removed with all that is in it, unless it gets its name.
class UnfinishedFolder {
 public:
  static absl::StatusOr<UnfinishedFolder> Create(const std::string& folder) {
    UnfinishedFolder result(absl::StrCat(folder, ".importing-", getpid()));
    std::error_code error;
    fs::create_directories(result.path_ + "/seq-01", error);
    if (!error) return result;
    return absl::ErrnoToStatus(error.value(),
                               absl::StrCat("creating folder ", result.path_));
  }
  explicit UnfinishedFolder(std::string path) : path_(std::move(path)) {}
  UnfinishedFolder(UnfinishedFolder&& other) noexcept
      : path_(std::exchange(other.path_, "")) {}
  ~UnfinishedFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }

  const std::string& path() const { return path_; }
  absl::Status Finish(const std::string& folder) {
    std::error_code error;
    fs::rename(path_, folder, error);
    if (error) {
      return absl::ErrnoToStatus(error.value(),
                                 absl::StrCat("renaming to ", folder));
    }
    path_.clear();
    return absl::OkStatus();
  }

 private:
  std::string path_;
};

// The quarter turn that makes most frames upright that say which it is.
QuarterTurn UprightTurnOf(const std::vector<CaptureFrame>& frames) {
  std::array<int, 4> votes{};
  for (const CaptureFrame& frame : frames) {
    const auto orientation = image::OrientationFromGravity(
        frame.world_from_camera.rotation.Inverse() * geometry::Vec3{0, 0, -1});
    if (orientation && orientation->is_certain) {
      ++votes[static_cast<size_t>(orientation->upright_turn)];
    }
  }
  return static_cast<QuarterTurn>(std::ranges::max_element(votes) -
                                  votes.begin());
}

class Writer {
 public:
  static absl::StatusOr<Writer> Create(Capture& capture,
                                       const WriteOptions& options,
                                       std::string folder) {
    Writer writer(capture, options, std::move(folder));
    writer.common_ = MedianCamera(capture.frames);
    TL_ASSIGN_OR_RETURN(writer.written_camera_, writer.SmallEnough());
    if (options.upright) writer.turn_ = UprightTurnOf(capture.frames);
    writer.result_.left_out = capture.left_out;
    return writer;
  }

  // A frame that cannot be read is left out; an error is one of writing.
  absl::Status Add(size_t index) {
    const CaptureFrame& frame = capture_->frames[index];
    absl::StatusOr<Pictures> pictures = capture_->pictures->Load(index);
    if (!pictures.ok()) {
      LeaveOut("its files cannot be read", pictures.status().message());
      return absl::OkStatus();
    }
    if (!Matches(frame, pictures->color)) return absl::OkStatus();
    const absl::StatusOr<std::string> jpeg = ColorFile(frame, *pictures);
    if (!jpeg.ok()) return base::Annotate(jpeg.status(), frame.name);
    const std::string base =
        absl::StrFormat("%s/seq-01/frame-%06d", folder_, result_.frames);
    TL_RETURN_IF_ERROR(base::WriteNewFile(base + ".color.jpg", *jpeg));
    if (pictures->depth) {
      TL_RETURN_IF_ERROR(AddDepth(frame, *pictures->depth, base));
    }
    const geometry::Rigid3 turned_from_camera{image::TurnedFromCamera(turn_),
                                              {}};
    TL_RETURN_IF_ERROR(base::WriteNewFile(
        base + ".pose.txt",
        dataset::FormatPoseMatrix(frame.world_from_camera *
                                  turned_from_camera.Inverse())));
    ++result_.frames;
    return absl::OkStatus();
  }

  absl::StatusOr<WrittenRecording> Finish() {
    if (result_.frames == 0) return NothingLeft();
    camera::RgbdCalibration& calibration = result_.calibration;
    calibration.color = image::Turned(written_camera_, turn_);
    calibration.depth =
        image::Turned(depth_camera_.value_or(written_camera_), turn_);
    const geometry::Rigid3 turned_from_camera{image::TurnedFromCamera(turn_),
                                              {}};
    calibration.color_from_depth = turned_from_camera *
                                   capture_->color_from_depth *
                                   turned_from_camera.Inverse();
    calibration.pose_sensor = camera::RgbdSensor::kColor;
    result_.notes = Notes();
    std::string train;
    std::string test;
    for (int i = 0; i < result_.frames; ++i) {
      const dataset::FrameUse use = dataset::UseOfFrame(i, result_.frames);
      const std::string line = absl::StrFormat("seq-01/frame-%06d\n", i);
      if (use == dataset::FrameUse::kTrain) {
        ++result_.train;
        train += line;
      } else if (use == dataset::FrameUse::kTest) {
        ++result_.test;
        test += line;
      }
    }
    const std::pair<const char*, std::string> files[] = {
        {"cameras.json", camera::CalibrationToJson(calibration)},
        {"train.txt", std::move(train)},
        {"test.txt", std::move(test)},
        {"recording.txt", Description()}};
    for (const auto& [name, text] : files) {
      TL_RETURN_IF_ERROR(
          base::WriteNewFile(absl::StrCat(folder_, "/", name), text));
    }
    return result_;
  }

 private:
  Writer(Capture& capture, const WriteOptions& options, std::string folder)
      : capture_(&capture), options_(options), folder_(std::move(folder)) {}

  absl::StatusOr<camera::Camera> SmallEnough() const {
    const int longer = std::max(common_.width(), common_.height());
    if (options_.max_side_px == 0 || longer <= options_.max_side_px) {
      return common_;
    }
    const double factor = static_cast<double>(options_.max_side_px) / longer;
    const auto side = [factor](int length) {
      return std::max(1, static_cast<int>(std::lround(factor * length)));
    };
    return ScaledTo(common_, {side(common_.width()), side(common_.height())});
  }

  void LeaveOut(const std::string& reason, absl::string_view example) {
    result_.left_out.Add(reason, std::string(example));
  }

  bool Matches(const CaptureFrame& frame, const image::ColorImage& color) {
    if (color.width != frame.color.width() ||
        color.height != frame.color.height()) {
      LeaveOut("the picture has not the size that its camera has",
               absl::StrCat(frame.name, ": ", color.width, " x ", color.height,
                            " pixels, not ", frame.color.width(), " x ",
                            frame.color.height()));
      return false;
    }
    if (color.width != common_.width() || color.height != common_.height()) {
      LeaveOut(
          "the picture has another size than most",
          absl::StrCat(frame.name, ": ", color.width, " x ", color.height));
      return false;
    }
    return true;
  }

  absl::StatusOr<std::string> ColorFile(const CaptureFrame& frame,
                                        Pictures& pictures) {
    const bool same_size = written_camera_.width() == common_.width() &&
                           written_camera_.height() == common_.height();
    const bool same_camera =
        LargestDifference_px(frame.color, common_) <= kSameCamera_px;
    if (!same_camera) ++resampled_;
    if (same_camera && same_size && turn_ == QuarterTurn::kNone &&
        image::SniffFormat(pictures.encoded_color) ==
            image::ImageFormat::kJpeg) {
      return std::move(pictures.encoded_color);
    }
    if (!same_camera || !same_size) {
      TL_ASSIGN_OR_RETURN(
          pictures.color,
          Resampled(pictures.color, same_camera ? common_ : frame.color,
                    written_camera_));
    }
    return image::EncodeJpeg(image::Turned(pictures.color, turn_),
                             kJpegQuality);
  }

  // The camera of depth maps of this size: the capture's, or colour's.
  absl::StatusOr<camera::Camera> DepthCamera(const camera::Camera& color,
                                             image::ImageSize size) const {
    if (capture_->depth) return *capture_->depth;
    return ScaledTo(color, size);
  }

  absl::Status AddDepth(const CaptureFrame& frame,
                        const image::DepthImage& depth,
                        const std::string& base) {
    const image::ImageSize size{depth.width, depth.height};
    if (!depth_camera_) {
      TL_ASSIGN_OR_RETURN(depth_camera_, DepthCamera(common_, size));
      const double shape = static_cast<double>(size.width) * common_.height() /
                           (static_cast<double>(size.height) * common_.width());
      // The capture's own depth camera need not see what colour sees.
      depth_fits_ =
          capture_->depth || std::abs(shape - 1) <= kMaxShapeDifference;
    }
    if (size.width != depth_camera_->width() ||
        size.height != depth_camera_->height() || !depth_fits_) {
      ++depth_left_out_;
      return absl::OkStatus();
    }
    image::DepthImage written = depth;
    if (!capture_->depth) {
      TL_ASSIGN_OR_RETURN(const camera::Camera own,
                          ScaledTo(frame.color, size));
      if (LargestDifference_px(own, *depth_camera_) > kSameCamera_px) {
        written = Resampled(depth, own, *depth_camera_);
      }
    }
    TL_ASSIGN_OR_RETURN(const std::string png,
                        image::EncodeDepthPng(image::Turned(written, turn_)));
    ++result_.with_depth;
    return base::WriteNewFile(base + ".depth.png", png);
  }

  absl::Status NothingLeft() const {
    std::string message =
        absl::StrCat(options_.source, ": no frame is left of the ",
                     capture_->format, " capture");
    for (const std::string& line : result_.left_out.Lines()) {
      absl::StrAppend(&message, "\n  ", line);
    }
    return absl::FailedPreconditionError(message);
  }

  std::string Description() const {
    const camera::RgbdCalibration& calibration = result_.calibration;
    std::string text = absl::StrFormat(
        "imported from %s\nformat %s\nframes %d\nwith_depth %d\n"
        "color_camera %s\n",
        options_.source, capture_->format, result_.frames, result_.with_depth,
        calibration.color.ToString());
    if (result_.with_depth > 0) {
      absl::StrAppend(&text, "depth_camera ", calibration.depth.ToString(),
                      "\n");
    }
    absl::StrAppend(&text,
                    "# .pose.txt: world_from_camera of this camera; z is up\n"
                    "pose_sensor color\n");
    for (const std::string& note : result_.notes) {
      absl::StrAppend(&text, "# ", note, "\n");
    }
    for (const std::string& line : result_.left_out.Lines()) {
      absl::StrAppend(&text, "# left out: ", line, "\n");
    }
    return text;
  }

  std::vector<std::string> Notes() const {
    std::vector<std::string> notes = capture_->notes;
    if (turn_ != QuarterTurn::kNone) {
      notes.push_back(absl::StrCat("pictures turned clockwise by ",
                                   90 * static_cast<int>(turn_),
                                   " degrees, to be upright"));
    }
    if (!(written_camera_ == common_)) {
      notes.push_back(absl::StrCat("pictures made smaller, from ",
                                   common_.width(), " x ", common_.height()));
    }
    if (resampled_ > 0) {
      notes.push_back(absl::StrCat(
          resampled_, " pictures resampled to one camera: the lens focused"));
    }
    if (depth_left_out_ > 0) {
      notes.push_back(absl::StrCat(
          depth_left_out_,
          " depth maps left out: their size is not that of the others, or has "
          "not the shape of the pictures"));
    }
    return notes;
  }

  Capture* capture_;
  WriteOptions options_;
  std::string folder_;
  camera::Camera common_;
  camera::Camera written_camera_;  // common_, made smaller
  std::optional<camera::Camera> depth_camera_;
  bool depth_fits_ = true;
  QuarterTurn turn_ = QuarterTurn::kNone;
  int resampled_ = 0;
  int depth_left_out_ = 0;
  WrittenRecording result_;
};

absl::Status CheckTarget(const std::string& folder) {
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (status.type() == fs::file_type::not_found) return absl::OkStatus();
  if (fs::is_directory(status) && fs::is_empty(folder, error) && !error) {
    return absl::OkStatus();
  }
  return absl::AlreadyExistsError(absl::StrCat(
      folder, " is there already; choose another folder, or remove it"));
}

}  // namespace

absl::Status WriteOptions::Validate() const {
  if (folder.empty()) {
    return absl::InvalidArgumentError("no folder to write to");
  }
  if (every < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("every ", every, ". frame: must be 1 or more"));
  }
  if (max_side_px != 0 && (max_side_px < 64 || max_side_px > 16384)) {
    return absl::InvalidArgumentError(
        absl::StrCat("longest side of ", max_side_px,
                     " pixels is neither 0 nor in 64..16384"));
  }
  return absl::OkStatus();
}

int FramesToWrite(const Capture& capture, const WriteOptions& options) {
  const int frames = static_cast<int>(capture.frames.size());
  return (frames + options.every - 1) / options.every;
}

absl::StatusOr<WrittenRecording> WriteRecording(
    Capture capture, const WriteOptions& options,
    const std::function<void()>& done, const std::stop_token& stop) {
  TL_RETURN_IF_ERROR(options.Validate());
  std::string folder = options.folder;
  while (folder.size() > 1 && folder.back() == '/') folder.pop_back();
  TL_RETURN_IF_ERROR(CheckTarget(folder));
  if (capture.frames.empty()) {
    std::string message =
        absl::StrCat(options.source, ": no frame can be imported");
    for (const std::string& line : capture.left_out.Lines()) {
      absl::StrAppend(&message, "\n  ", line);
    }
    return absl::FailedPreconditionError(message);
  }
  TL_ASSIGN_OR_RETURN(UnfinishedFolder unfinished,
                      UnfinishedFolder::Create(folder));
  TL_ASSIGN_OR_RETURN(Writer writer,
                      Writer::Create(capture, options, unfinished.path()));
  const size_t every = static_cast<size_t>(options.every);
  for (size_t i = 0; i < capture.frames.size(); i += every) {
    if (stop.stop_requested()) return absl::CancelledError("import stopped");
    TL_RETURN_IF_ERROR(writer.Add(i));
    if (done) done();
  }
  TL_ASSIGN_OR_RETURN(WrittenRecording result, writer.Finish());
  TL_RETURN_IF_ERROR(unfinished.Finish(folder));
  return result;
}

}  // namespace treeline::capture
