// The pictures of a video file, from the first to the last.
#ifndef SERVER_TOOLS_CAPTURE_VIDEO_READER_H_
#define SERVER_TOOLS_CAPTURE_VIDEO_READER_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "common/image/decode.h"
#include "common/image/image.h"
#include "common/image/orientation.h"

namespace treeline::capture {

// Not thread-safe.
class VideoReader {
 public:
  // Frames are as they are stored: the turn that the file asks for is not
  // made, because intrinsics and poses are of the stored picture.
  // INVALID_ARGUMENT, naming the file, for what FFmpeg does not decode and for
  // pictures that are too large.
  static absl::StatusOr<std::unique_ptr<VideoReader>> Open(
      const std::string& path);
  virtual ~VideoReader() = default;

  virtual image::ImageSize size() const = 0;
  // The turn with which players show it: of a phone that was held upright.
  virtual image::QuarterTurn ShownTurn() const = 0;
  // As the file has it, which may be wrong; 0: it does not say.
  virtual int FrameCount() const = 0;
  // Of that many from the beginning, and not less than the last time.
  // DATA_LOSS: the video ends before that, or is damaged there.
  virtual absl::StatusOr<image::ColorImage> Read(int frame) = 0;
};

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_VIDEO_READER_H_
