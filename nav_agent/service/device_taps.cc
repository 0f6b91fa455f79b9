#include "nav_agent/service/device_taps.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <iterator>
#include <utility>

#include "common/base/status_macros.h"
#include "common/image/decode.h"

namespace treeline::agent_service {
namespace {

constexpr int kJpegQuality = 80;
constexpr std::array<uint8_t, 3> kDotColor = {60, 220, 90};
constexpr int kDotRadius_px = 1;

// A small square around a pixel; none if that is outside, or is no number.
void DrawDot(const geometry::Vec2& pixel, image::ColorImage& image) {
  if (!(pixel.x >= 0 && pixel.x < image.width && pixel.y >= 0 &&
        pixel.y < image.height)) {
    return;
  }
  const auto middle_x = static_cast<int>(pixel.x);
  const auto middle_y = static_cast<int>(pixel.y);
  const int last_x = std::min(middle_x + kDotRadius_px, image.width - 1);
  const int last_y = std::min(middle_y + kDotRadius_px, image.height - 1);
  for (int y = std::max(middle_y - kDotRadius_px, 0); y <= last_y; ++y) {
    for (int x = std::max(middle_x - kDotRadius_px, 0); x <= last_x; ++x) {
      const size_t index = (static_cast<size_t>(y) * image.width + x) * 3;
      std::ranges::copy(kDotColor, image.rgb.begin() + index);
    }
  }
}

}  // namespace

void PictureKeeper::Keep(const core::RgbdFrame& frame) {
  if (frame.frame.color.rgb.empty()) return;
  {
    const absl::MutexLock lock(&mutex_);
    // Stamps may go back where a device was started anew.
    if (stamp_.has_value() && frame.stamp >= *stamp_ &&
        frame.stamp - *stamp_ < interval_) {
      return;
    }
  }
  auto image = std::make_shared<const image::ColorImage>(frame.frame.color);
  const absl::MutexLock lock(&mutex_);
  image_ = std::move(image);
  stamp_ = frame.stamp;
  jpeg_ = nullptr;
}

void PictureKeeper::Mark(base::MonotonicTime stamp,
                         std::span<const geometry::Vec2> pixels) {
  std::shared_ptr<const image::ColorImage> plain;
  {
    const absl::MutexLock lock(&mutex_);
    if (image_ == nullptr || stamp_ != stamp) return;
    plain = image_;
  }
  auto marked = std::make_shared<image::ColorImage>(*plain);
  for (const geometry::Vec2& pixel : pixels) DrawDot(pixel, *marked);
  const absl::MutexLock lock(&mutex_);
  if (image_ != plain) return;
  image_ = std::move(marked);
  jpeg_ = nullptr;
}

absl::StatusOr<std::shared_ptr<const std::string>> PictureKeeper::Jpeg() const {
  std::shared_ptr<const image::ColorImage> image;
  {
    const absl::MutexLock lock(&mutex_);
    if (image_ == nullptr) {
      return absl::NotFoundError("there is no picture yet");
    }
    if (jpeg_ != nullptr) return jpeg_;
    image = image_;
  }
  TL_ASSIGN_OR_RETURN(std::string bytes,
                      image::EncodeJpeg(*image, kJpegQuality));
  auto jpeg = std::make_shared<const std::string>(std::move(bytes));
  const absl::MutexLock lock(&mutex_);
  if (image == image_) jpeg_ = jpeg;
  return jpeg;
}

BackgroundCamera::BackgroundCamera(
    core::RgbdCamera& camera,
    std::function<void(const core::RgbdFrame&)> on_frame)
    : camera_(camera),
      on_frame_(std::move(on_frame)),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

void BackgroundCamera::Run(const std::stop_token& stop) {
  constexpr auto kLookUp = std::chrono::milliseconds(10);
  while (!stop.stop_requested()) {
    std::vector<core::RgbdFrame> taken = camera_.TakeFrames();
    for (core::RgbdFrame& frame : taken) {
      on_frame_(frame);
      const absl::MutexLock lock(&mutex_);
      frames_.push_back(std::move(frame));
      if (frames_.size() > kKept) frames_.pop_front();
    }
    if (taken.empty()) std::this_thread::sleep_for(kLookUp);
  }
}

std::vector<core::RgbdFrame> BackgroundCamera::TakeFrames() {
  const absl::MutexLock lock(&mutex_);
  std::vector<core::RgbdFrame> taken(std::make_move_iterator(frames_.begin()),
                                     std::make_move_iterator(frames_.end()));
  frames_.clear();
  return taken;
}

void WatchedServer::Ask(const core::RgbdFrame& frame, double timeout_s) {
  keeper_.Keep(frame);
  port_.Ask(frame, timeout_s);
}

std::optional<absl::StatusOr<core::RelocalizationAnswer>>
WatchedServer::TakeAnswer() {
  auto answer = port_.TakeAnswer();
  if (!answer.has_value()) return answer;
  if (answer->ok()) {
    // Nobody behind this one draws.
    const std::vector<geometry::Vec2> pixels =
        std::exchange((*answer)->inlier_pixels, {});
    keeper_.Mark((*answer)->stamp, pixels);
  }
  const absl::MutexLock lock(&mutex_);
  last_error_ = answer->status();
  return answer;
}

absl::Status WatchedServer::last_error() const {
  const absl::MutexLock lock(&mutex_);
  return last_error_;
}

}  // namespace treeline::agent_service
