// Recordings of synthetic worlds, in the layout of public data sets.
#ifndef COMMON_SYNTHETIC_RECORDER_H_
#define COMMON_SYNTHETIC_RECORDER_H_

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>

#include "absl/status/status.h"
#include "common/synthetic/synthetic_camera.h"

namespace treeline {

struct RecordOptions {
  // "room" or "room:N"; see MakeWorld.
  std::string world = "room";
  // Made if it is not there. Must not hold a recording yet.
  std::string folder{};
  // In [5, 100000].
  int frames = 1000;
  // Frames in a second of the walk; they are 1 / rate_hz apart.
  double rate_hz = 30;
  // Of the walk and of the sensors' noise; the world has its own.
  uint64_t seed = 0;
  int jpeg_quality = 92;
  // < 1: one for each processor.
  int threads = 0;

  absl::Status Validate() const;
};

// Records a walk in the layout of 7-Scenes:
//   FOLDER/seq-01/frame-NNNNNN.color.jpg  JPEG, 640 x 480, f 525
//   FOLDER/seq-01/frame-NNNNNN.depth.png  16 bit, mm, 0 not measured, f 585
//   FOLDER/seq-01/frame-NNNNNN.pose.txt   4x4 world_from_camera of the depth
//                                         camera (m)
//   FOLDER/train.txt, test.txt            stems of both parts (UseOfFrame)
//   FOLDER/recording.txt                  what was recorded, and the true
//                                         calibration
// Depth is not registered: the colour camera is 2.5 cm to the right of the
// depth camera, as in a Kinect.
//
// The same options and seed give the same bytes for any thread count. `done`
// is called once for each finished frame, from any thread; it may be empty.
// CANCELLED if `stop` is requested; then, as after any error, what was written
// is removed. ALREADY_EXISTS if FOLDER/seq-01 is there.
absl::Status RecordSevenScenes(const RecordOptions& options,
                               const std::function<void()>& done,
                               const std::stop_token& stop);

// The same in a world that is there already; options.world is only what
// recording.txt calls it.
absl::Status RecordSevenScenesIn(World world, const RecordOptions& options,
                                 const std::function<void()>& done,
                                 const std::stop_token& stop);

}  // namespace treeline

#endif  // COMMON_SYNTHETIC_RECORDER_H_
