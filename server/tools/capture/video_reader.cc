#include "server/tools/capture/video_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/input_file.h"
#include "common/base/status_macros.h"

namespace treeline::capture {
namespace {

// Other angles than quarters are none that a camera writes.
image::QuarterTurn QuarterTurnOf(double clockwise_deg) {
  for (const image::QuarterTurn turn : image::kQuarterTurns) {
    if (std::fmod(clockwise_deg, 360) == 90 * static_cast<int>(turn)) {
      return turn;
    }
  }
  return image::QuarterTurn::kNone;
}

class OpenCvVideo final : public VideoReader {
 public:
  explicit OpenCvVideo(std::string path) : path_(std::move(path)) {}

  absl::Status Open() {
    TL_RETURN_IF_ERROR(CheckContainer());
    try {
      if (!video_.open(path_, cv::CAP_FFMPEG)) return NoVideo("");
      video_.set(cv::CAP_PROP_ORIENTATION_AUTO, 0);
      size_ = {static_cast<int>(video_.get(cv::CAP_PROP_FRAME_WIDTH)),
               static_cast<int>(video_.get(cv::CAP_PROP_FRAME_HEIGHT))};
      frame_count_ = static_cast<int>(
          std::clamp(video_.get(cv::CAP_PROP_FRAME_COUNT), 0.0, 1e9));
      // OpenCV 4.6 says it counterclockwise, and makes the wrong turn of it
      // itself.
      turn_ = QuarterTurnOf(360 - video_.get(cv::CAP_PROP_ORIENTATION_META));
    } catch (const cv::Exception& error) {
      return NoVideo(error.what());
    }
    const image::DecodeLimits limits;
    if (size_.width < 1 || size_.height < 1 || size_.width > limits.max_width ||
        size_.height > limits.max_height) {
      return NoVideo(absl::StrCat("its pictures are ", size_.width, " x ",
                                  size_.height, " pixels"));
    }
    return absl::OkStatus();
  }

  image::ImageSize size() const override { return size_; }
  image::QuarterTurn ShownTurn() const override { return turn_; }
  int FrameCount() const override { return frame_count_; }

  absl::StatusOr<image::ColorImage> Read(int frame) override {
    try {
      for (; next_ <= frame; ++next_) {
        if (!video_.grab()) return Ends(frame);
      }
      cv::Mat bgr;
      if (!video_.retrieve(bgr) || bgr.type() != CV_8UC3 || bgr.empty()) {
        return Ends(frame);
      }
      cv::Mat rgb;
      cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
      return image::ColorImage{
          rgb.cols, rgb.rows,
          std::vector<uint8_t>(rgb.data, rgb.data + rgb.total() * 3)};
    } catch (const cv::Exception& error) {
      return absl::DataLossError(
          absl::StrCat(path_, ": frame ", frame, ": ", error.what()));
    }
  }

 private:
  // FFmpeg goes by the contents of a file, and knows playlists that name other
  // files and addresses; an MP4 or QuickTime file names none that it follows.
  absl::Status CheckContainer() const {
    TL_ASSIGN_OR_RETURN(const base::InputFile file,
                        base::InputFile::Open(path_));
    std::array<uint8_t, 8> head{};
    if (file.size() < head.size()) return NoVideo("it is empty, or cut off");
    TL_RETURN_IF_ERROR(file.ReadAt(0, head));
    const absl::string_view type(reinterpret_cast<const char*>(head.data()) + 4,
                                 4);
    for (const char* known : {"ftyp", "moov", "mdat", "wide", "free"}) {
      if (type == known) return absl::OkStatus();
    }
    return NoVideo("it is neither MP4 nor QuickTime");
  }

  absl::Status NoVideo(const std::string& why) const {
    return absl::InvalidArgumentError(absl::StrCat(
        path_, ": is no video that can be decoded", why.empty() ? "" : ": ",
        why, "; convert it, for instance with `ffmpeg -i ", path_,
        " -start_number 0 rgb/%06d.jpg`, and remove it"));
  }
  absl::Status Ends(int frame) const {
    return absl::DataLossError(absl::StrCat(
        path_, ": the video ends, or is damaged, before frame ", frame));
  }

  const std::string path_;
  cv::VideoCapture video_;
  image::ImageSize size_;
  image::QuarterTurn turn_ = image::QuarterTurn::kNone;
  int frame_count_ = 0;
  int next_ = 0;
};

}  // namespace

absl::StatusOr<std::unique_ptr<VideoReader>> VideoReader::Open(
    const std::string& path) {
  auto video = std::make_unique<OpenCvVideo>(path);
  TL_RETURN_IF_ERROR(video->Open());
  return video;
}

}  // namespace treeline::capture
