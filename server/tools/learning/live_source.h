// Frames with poses, one by one: of a recording, or named line by line by
// another program, which may correct poses later.
#ifndef SERVER_TOOLS_LEARNING_LIVE_SOURCE_H_
#define SERVER_TOOLS_LEARNING_LIVE_SOURCE_H_

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <variant>

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

// The pose of a frame that came before, corrected.
struct PoseCorrection {
  std::string color_path;
  geometry::Rigid3 world_from_sensor;
};

// No more frames will come. Corrections may.
struct EndOfFrames {};

using LiveItem = std::variant<LiveFrame, PoseCorrection, EndOfFrames>;

// "COLOR DEPTH tx ty tz qx qy qz qw": two files without blanks in their names,
// and the pose, world from camera, in the order of TUM's trajectories (m). Or
// "pose COLOR tx ty tz qx qy qz qw", or "end". nullopt for empty lines and
// comments (#). INVALID_ARGUMENT for others.
absl::StatusOr<std::optional<LiveItem>> ParseLiveLine(absl::string_view line);

class LiveSource {
 public:
  virtual ~LiveSource() = default;
  // Waits for what comes next; nullopt: nothing more, or `stop`.
  // INVALID_ARGUMENT: what came means nothing, and others may follow.
  virtual absl::StatusOr<std::optional<LiveItem>> Next(
      const std::stop_token& stop) = 0;
};

// The frames of `dataset`, which must outlive it, that have a pose and depth.
std::unique_ptr<LiveSource> FramesOfRecording(const dataset::Dataset& dataset);

// Line by line from a file descriptor, until it ends. The descriptor must
// stay open.
std::unique_ptr<LiveSource> FramesByLine(int descriptor);

}  // namespace treeline::learning

#endif  // SERVER_TOOLS_LEARNING_LIVE_SOURCE_H_
