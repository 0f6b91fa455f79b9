#include "nav_agent/bridge/place_finder/camera_input.h"

#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/ros2/conversions/camera_values.h"
#include "common/ros2/conversions/geometry_values.h"
#include "nav_agent/core/corrected_devices.h"

namespace treeline::place_finder {
namespace {

// Colour and depth of one moment come one after the other.
constexpr size_t kKept = 4;
// Half of the time between two pictures at 30 Hz.
constexpr auto kSameMoment = std::chrono::milliseconds(17);

const messages::Header& HeaderOf(const Picture& picture) {
  return std::visit(
      [](const auto& message) -> const messages::Header& {
        return message.header;
      },
      picture);
}

base::MonotonicTime StampOf(const Picture& picture) {
  return conversions::TimeOf(HeaderOf(picture).stamp);
}

void Keep(Picture picture, std::deque<Picture>& pictures) {
  // A clock that begins anew: what was before is of no use.
  if (!pictures.empty() && StampOf(picture) < StampOf(pictures.back())) {
    pictures.clear();
  }
  pictures.push_back(std::move(picture));
  if (pictures.size() > kKept) pictures.pop_front();
}

}  // namespace

absl::Status CameraInput::AddInfo(const messages::CameraInfo& info) {
  TL_ASSIGN_OR_RETURN(camera_,
                      conversions::CameraOf(info, options_.is_rectified));
  return absl::OkStatus();
}

void CameraInput::AddColor(Picture picture) {
  frame_id_ = HeaderOf(picture).frame_id;
  ++pictures_;
  Keep(std::move(picture), colors_);
}

void CameraInput::AddDepth(Picture picture) {
  Keep(std::move(picture), depths_);
}

CameraInput::Pair CameraInput::NewestPair() const {
  int64_t sequence = pictures_ - 1;
  for (auto color = colors_.rbegin(); color != colors_.rend();
       ++color, --sequence) {
    if (!options_.has_depth) {
      return {.color = &*color, .depth = nullptr, .sequence = sequence};
    }
    for (auto depth = depths_.rbegin(); depth != depths_.rend(); ++depth) {
      const auto apart = StampOf(*color) - StampOf(*depth);
      if (apart <= kSameMoment && -apart <= kSameMoment) {
        return {.color = &*color, .depth = &*depth, .sequence = sequence};
      }
    }
  }
  return {};
}

base::MonotonicTime CameraInput::MomentOf(const Picture& picture) const {
  return StampOf(picture) - core::DelayOf(options_.delay_s);
}

std::optional<base::MonotonicTime> CameraInput::NewestStamp() const {
  const Pair pair = NewestPair();
  if (!camera_.has_value() || pair.color == nullptr) return std::nullopt;
  return MomentOf(*pair.color);
}

absl::StatusOr<core::RgbdFrame> CameraInput::Newest() const {
  if (!camera_.has_value()) {
    return absl::FailedPreconditionError("no camera_info has come");
  }
  const Pair pair = NewestPair();
  if (pair.color == nullptr) {
    return absl::FailedPreconditionError(
        colors_.empty() ? "no picture has come"
                        : "no depth picture of a colour picture's moment has "
                          "come: give both the same stamps");
  }
  core::RgbdFrame frame;
  frame.stamp = MomentOf(*pair.color);
  frame.sequence = pair.sequence;
  frame.frame.calibration = {
      .color = *camera_, .depth = *camera_, .color_from_depth = {}};
  TL_ASSIGN_OR_RETURN(
      frame.frame.color,
      std::visit(
          [](const auto& message) { return conversions::ColorOf(message); },
          *pair.color));
  if (frame.frame.color.width != camera_->width() ||
      frame.frame.color.height != camera_->height()) {
    return absl::InvalidArgumentError(
        absl::StrCat("the picture is of ", frame.frame.color.width, " x ",
                     frame.frame.color.height, " pixels, and camera_info of ",
                     camera_->width(), " x ", camera_->height(),
                     ": take the camera_info beside the picture's topic"));
  }
  if (pair.depth == nullptr) return frame;
  TL_ASSIGN_OR_RETURN(
      frame.frame.depth,
      std::visit(
          [](const auto& message) { return conversions::DepthOf(message); },
          *pair.depth));
  if (frame.frame.depth->width != frame.frame.color.width ||
      frame.frame.depth->height != frame.frame.color.height) {
    return absl::InvalidArgumentError(
        absl::StrCat("the depth picture is of ", frame.frame.depth->width,
                     " x ", frame.frame.depth->height, " pixels, colour of ",
                     frame.frame.color.width, " x ", frame.frame.color.height,
                     ": give the depth that is registered to colour "
                     "(aligned_depth_to_color, depth_registered)"));
  }
  return frame;
}

}  // namespace treeline::place_finder
