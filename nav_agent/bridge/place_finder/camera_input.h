// The newest picture of a camera's topics, with its calibration and its depth.
#ifndef NAV_AGENT_BRIDGE_PLACE_FINDER_CAMERA_INPUT_H_
#define NAV_AGENT_BRIDGE_PLACE_FINDER_CAMERA_INPUT_H_

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <variant>

#include "absl/status/statusor.h"
#include "common/camera/camera.h"
#include "common/ros2/messages/sensor_messages.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::place_finder {

using Picture = std::variant<messages::Image, messages::CompressedImage>;

// Pictures stay as they came until one is wanted: of fifteen a second, a robot
// that knows its place needs none. Not thread-safe.
class CameraInput {
 public:
  struct Options {
    // The pictures are rectified (image_rect): CameraInfo's p counts.
    bool is_rectified = false;
    // Depth is wanted: a picture waits for the one of its moment.
    bool has_depth = false;
    // Pictures are stamped so much later than odometry of the same moment (s).
    double delay_s = 0;
  };
  explicit CameraInput(const Options& options) : options_(options) {}

  // INVALID_ARGUMENT: of no calibrated camera (conversions::CameraOf).
  absl::Status AddInfo(const messages::CameraInfo& info);
  void AddColor(Picture picture);
  // Registered to the colour picture.
  void AddDepth(Picture picture);

  // Once CameraInfo has come.
  const std::optional<camera::Camera>& camera() const { return camera_; }
  // Of the newest picture; "": there is none.
  const std::string& frame_id() const { return frame_id_; }
  // On odometry's time, of the picture that Newest would give; nullopt: it
  // would give none.
  std::optional<base::MonotonicTime> NewestStamp() const;
  // Decoded, stamped as NewestStamp has it; its sequence counts pictures.
  // FAILED_PRECONDITION while something is missing, and says what;
  // INVALID_ARGUMENT for pictures that are broken, or of another size than
  // CameraInfo says.
  absl::StatusOr<core::RgbdFrame> Newest() const;

  int64_t pictures() const { return pictures_; }

 private:
  base::MonotonicTime MomentOf(const Picture& picture) const;
  struct Pair {
    const Picture* color = nullptr;
    const Picture* depth = nullptr;
    int64_t sequence = 0;
  };
  // The newest that is whole; color is null if there is none.
  Pair NewestPair() const;

  Options options_;
  std::optional<camera::Camera> camera_;
  std::string frame_id_;
  std::deque<Picture> colors_;
  std::deque<Picture> depths_;
  int64_t pictures_ = 0;
};

}  // namespace treeline::place_finder

#endif  // NAV_AGENT_BRIDGE_PLACE_FINDER_CAMERA_INPUT_H_
