// What somebody recorded with a phone or another program, as one kind of value
// whatever its format was. Readers make it (open_capture.h), and
// recording_writer.h makes a recording of it.
#ifndef SERVER_TOOLS_CAPTURE_CAPTURE_H_
#define SERVER_TOOLS_CAPTURE_CAPTURE_H_

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"
#include "common/image/image.h"

namespace treeline::capture {

struct CaptureFrame {
  // What the capture calls it: a file, or a file and an entry.
  std::string name;
  // In our convention: the centre of the top left pixel is (0, 0).
  camera::Camera color;
  // Of the colour camera (x right, y down, z forward), in a world with z up.
  geometry::Rigid3 world_from_camera;
};

// What belongs to one frame.
struct Pictures {
  image::ColorImage color;
  // The JPEG or PNG file that color was decoded from; empty: there is none.
  std::string encoded_color;
  // Along the optical axis, in mm, without what the capture calls uncertain.
  // It has the field of view of the colour camera and its pose, unless
  // Capture::depth and Capture::color_from_depth say otherwise.
  std::optional<image::DepthImage> depth;
};

// Where the pictures of a capture come from, one frame at a time.
class PictureSource {
 public:
  virtual ~PictureSource() = default;
  // `frame` is an index into Capture::frames, and never less than in the call
  // before. An error, which names the file, is that frame's alone.
  virtual absl::StatusOr<Pictures> Load(size_t frame) = 0;
};

// Frames that are not imported, by reason.
class LeftOut {
 public:
  // `reason` is the same for all frames of a kind; `example` names one.
  void Add(const std::string& reason, const std::string& example);
  int count() const;
  // "3 frames: the pose is not rigid (the first: frame_7.json)", one a reason.
  std::vector<std::string> Lines() const;

 private:
  struct Reason {
    std::string text;
    std::string example;
    int count = 0;
  };
  std::vector<Reason> reasons_;
};

struct Capture {
  std::string format;  // what --format calls it
  std::vector<CaptureFrame> frames;
  std::unique_ptr<PictureSource> pictures;
  // The depth camera, where the capture has one; else it is the colour camera
  // at the size of the depth map.
  std::optional<camera::Camera> depth;
  // Where that one is; at the same place unless the capture says otherwise.
  geometry::Rigid3 color_from_depth;
  LeftOut left_out;
  // What was taken for granted and what was converted, for people to read.
  std::vector<std::string> notes;
};

// Which topics of a recording of ROS are taken; empty: a guess.
struct RosOptions {
  std::string color_topic{};
  std::string depth_topic{};  // "none": no depth
  std::string camera_info{};
  std::string depth_camera_info{};
  // "tf", or a topic of Odometry, PoseStamped or PoseWithCovarianceStamped.
  std::string pose_topic{};
  // Which frame that topic tells of: what it says itself, or the camera's.
  std::string pose_frame{};
  // For /tf: the frame that poses are in.
  std::string world_frame{};
};

// How a capture is read.
struct OpenOptions {
  // Metres per unit of its depth files; 0: what the format says.
  double depth_unit_m = 0;
  // Depth of less confidence is left out: 0 keeps all, 1 drops what is low, 2
  // what is low or medium.
  int min_confidence = 1;
  // The axis of the capture's world that points up: "x", "-y" and so on. Empty:
  // what the format says.
  std::string up;
  RosOptions ros{};

  absl::Status Validate() const;
};

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_CAPTURE_H_
