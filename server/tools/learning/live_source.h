// Frames with poses, one by one: of a recording, or named line by line by
// another program.
#ifndef SERVER_TOOLS_LEARNING_LIVE_SOURCE_H_
#define SERVER_TOOLS_LEARNING_LIVE_SOURCE_H_

#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/dataset/dataset.h"
#include "common/geometry/rigid3.h"

namespace treeline::learning {

// A frame that is there; its pictures are still files.
struct LiveFrame {
  std::string color_path;
  std::string depth_path;
  geometry::Rigid3 world_from_sensor;
};

// "COLOR DEPTH tx ty tz qx qy qz qw": two files without blanks in their names,
// and the pose, world from camera, in the order of TUM's trajectories (m).
// nullopt for empty lines and comments (#). INVALID_ARGUMENT for others.
absl::StatusOr<std::optional<LiveFrame>> ParseLiveFrame(absl::string_view line);

class LiveSource {
 public:
  virtual ~LiveSource() = default;
  // Waits for the next frame; nullopt: it was the last one, or `stop`.
  // INVALID_ARGUMENT: what came is no frame, and others may follow.
  virtual absl::StatusOr<std::optional<LiveFrame>> Next(
      const std::stop_token& stop) = 0;
};

// The frames of `dataset`, which must outlive it, that have a pose and depth.
std::unique_ptr<LiveSource> FramesOfRecording(const dataset::Dataset& dataset);

// A line a frame from a file descriptor, until it ends. The descriptor must
// stay open.
std::unique_ptr<LiveSource> FramesByLine(int descriptor);

}  // namespace treeline::learning

#endif  // SERVER_TOOLS_LEARNING_LIVE_SOURCE_H_
