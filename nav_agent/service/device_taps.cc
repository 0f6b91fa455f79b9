#include "nav_agent/service/device_taps.h"

#include <chrono>
#include <iterator>
#include <utility>

#include "common/base/status_macros.h"
#include "common/image/decode.h"

namespace treeline {
namespace {

constexpr int kJpegQuality = 80;

}  // namespace

void PictureKeeper::Keep(const RgbdFrame& frame) {
  if (frame.frame.color.rgb.empty()) return;
  {
    const absl::MutexLock lock(&mutex_);
    // Stamps may go back where a device was started anew.
    if (stamp_.has_value() && frame.stamp >= *stamp_ &&
        frame.stamp - *stamp_ < interval_) {
      return;
    }
  }
  auto image = std::make_shared<const ColorImage>(frame.frame.color);
  const absl::MutexLock lock(&mutex_);
  image_ = std::move(image);
  stamp_ = frame.stamp;
  jpeg_ = nullptr;
}

absl::StatusOr<std::shared_ptr<const std::string>> PictureKeeper::Jpeg() const {
  std::shared_ptr<const ColorImage> image;
  {
    const absl::MutexLock lock(&mutex_);
    if (image_ == nullptr) {
      return absl::NotFoundError("there is no picture yet");
    }
    if (jpeg_ != nullptr) return jpeg_;
    image = image_;
  }
  TL_ASSIGN_OR_RETURN(std::string bytes, EncodeJpeg(*image, kJpegQuality));
  auto jpeg = std::make_shared<const std::string>(std::move(bytes));
  const absl::MutexLock lock(&mutex_);
  if (image == image_) jpeg_ = jpeg;
  return jpeg;
}

BackgroundCamera::BackgroundCamera(
    RgbdCamera& camera, std::function<void(const RgbdFrame&)> on_frame)
    : camera_(camera),
      on_frame_(std::move(on_frame)),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

void BackgroundCamera::Run(const std::stop_token& stop) {
  constexpr auto kLookUp = std::chrono::milliseconds(10);
  while (!stop.stop_requested()) {
    std::vector<RgbdFrame> taken = camera_.TakeFrames();
    for (RgbdFrame& frame : taken) {
      on_frame_(frame);
      const absl::MutexLock lock(&mutex_);
      frames_.push_back(std::move(frame));
      if (frames_.size() > kKept) frames_.pop_front();
    }
    if (taken.empty()) std::this_thread::sleep_for(kLookUp);
  }
}

std::vector<RgbdFrame> BackgroundCamera::TakeFrames() {
  const absl::MutexLock lock(&mutex_);
  std::vector<RgbdFrame> taken(std::make_move_iterator(frames_.begin()),
                               std::make_move_iterator(frames_.end()));
  frames_.clear();
  return taken;
}

void WatchedServer::Ask(const RgbdFrame& frame, double timeout_s) {
  keeper_.Keep(frame);
  port_.Ask(frame, timeout_s);
}

std::optional<absl::StatusOr<RelocalizationAnswer>>
WatchedServer::TakeAnswer() {
  auto answer = port_.TakeAnswer();
  if (answer.has_value()) {
    const absl::MutexLock lock(&mutex_);
    last_error_ = answer->status();
  }
  return answer;
}

absl::Status WatchedServer::last_error() const {
  const absl::MutexLock lock(&mutex_);
  return last_error_;
}

}  // namespace treeline
