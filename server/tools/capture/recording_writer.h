// A capture, written as a recording that `treeline train` reads.
#ifndef SERVER_TOOLS_CAPTURE_RECORDING_WRITER_H_
#define SERVER_TOOLS_CAPTURE_RECORDING_WRITER_H_

#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/camera/rgbd_calibration.h"
#include "server/tools/capture/capture.h"

namespace treeline::capture {

struct WriteOptions {
  std::string folder{};
  // Where the capture was, for recording.txt.
  std::string source{};
  // Every so many-th frame, from the first.
  int every = 1;
  // Pictures with a longer side are made smaller (px); 0: none.
  int max_side_px = 0;
  // Turn all pictures by the quarter turns that make most of them upright.
  bool upright = true;

  absl::Status Validate() const;
};

struct WrittenRecording {
  int frames = 0;
  int with_depth = 0;
  int train = 0;
  int test = 0;
  camera::RgbdCalibration calibration;
  // Frames that were left out, here or when the capture was opened.
  LeftOut left_out;
  // What was taken for granted and what was converted.
  std::vector<std::string> notes;
};

// How many frames will be asked for.
int FramesToWrite(const Capture& capture, const WriteOptions& options);

// Writes the layout of 7-Scenes and the cameras beside it:
//   FOLDER/seq-01/frame-NNNNNN.color.jpg  as recorded where nothing was changed
//   FOLDER/seq-01/frame-NNNNNN.depth.png  mm; only of frames with depth
//   FOLDER/seq-01/frame-NNNNNN.pose.txt   world_from_camera, z up, m
//   FOLDER/cameras.json                   both cameras; the poses are colour's
//   FOLDER/train.txt, test.txt            blocks of frames, apart in time
//   FOLDER/recording.txt                  where it is from, what was converted
//
// A recording has one colour camera: that of the frame with the median focal
// length. Pictures of frames whose camera differs by more than a quarter of a
// pixel (phones focus while they film) are resampled to it, and so is depth.
//
// All of it is written into another folder beside FOLDER first, which takes its
// name at the end: after an error or `stop` (CANCELLED) there is nothing.
// ALREADY_EXISTS if FOLDER is there and not empty. FAILED_PRECONDITION: no
// frame is left. `done` is called once a frame.
absl::StatusOr<WrittenRecording> WriteRecording(
    Capture capture, const WriteOptions& options,
    const std::function<void()>& done, const std::stop_token& stop);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_RECORDING_WRITER_H_
