// Recordings of synthetic worlds, in the layout of public data sets.
#ifndef SIMULATION_RECORDER_RECORDER_H_
#define SIMULATION_RECORDER_RECORDER_H_

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/dataset/text_formats.h"
#include "simulation/sensors/synthetic_camera.h"

namespace treeline::recorder {

enum class RecordFormat { kSevenScenes, kTum };

struct RecordOptions {
  // See MakeWorld.
  std::string world = "room";
  // Made if it is not there. Must not hold a recording yet.
  std::string folder{};
  RecordFormat format = RecordFormat::kSevenScenes;
  // In [5, 100000]; with a trajectory: at least 1.
  int frames = 1000;
  // Frames in a second of the walk; they are 1 / rate_hz apart.
  double rate_hz = 30;
  // Poses to record from in place of the walk, of the format's pose sensor;
  // empty: none. One frame each, unless is_resampled: then frames at rate_hz
  // from the first one's time on, between poses.
  std::vector<dataset::TimedPose> trajectory{};
  bool is_resampled = false;
  // Of the walk and of the sensors' noise; the world has its own.
  uint64_t seed = 0;
  worlds::WorldOptions world_options{};
  bool is_exposure_automatic = false;
  // How long the colour camera's shutter is open (s), in [0, 0.5]; 0: no blur.
  double shutter_s = 0;
  // From the first to the last row's exposure (s), in [0, 0.2], of colour and
  // depth alike; the pose is that of the middle. 0: all rows at once. Not with
  // shutter_s.
  double readout_s = 0;
  // In [1, 100]. Each frame has a quality between the two, by chance.
  int jpeg_quality = 92;
  int lowest_jpeg_quality = 92;
  // Whether FOLDER/truth is written.
  bool has_truth = false;
  // < 1: one for each processor.
  int threads = 0;

  absl::Status Validate() const;
};

// Records a walk. In the layout of 7-Scenes:
//   FOLDER/seq-01/frame-NNNNNN.color.jpg  JPEG, 640 x 480, f 525
//   FOLDER/seq-01/frame-NNNNNN.depth.png  16 bit, mm, 0 not measured, f 585
//   FOLDER/seq-01/frame-NNNNNN.pose.txt   4x4 world_from_camera of the depth
//                                         camera (m)
// Depth is not registered: the colour camera is 2.5 cm to the right of the
// depth camera, as in a Kinect.
// In the layout of TUM:
//   FOLDER/rgb/TIME.jpg, rgb.txt          JPEG, 640 x 480, f 525 (319.5, 239.5)
//   FOLDER/depth/TIME.png, depth.txt      16 bit, 1/5000 m, registered to
//                                         colour
//   FOLDER/groundtruth.txt                TIME tx ty tz qx qy qz qw,
//                                         world_from_camera of the colour
//                                         camera
// In both:
//   FOLDER/train.txt, test.txt            stems of both parts (UseOfFrame)
//   FOLDER/recording.txt                  what was recorded, and the true
//                                         calibration
// and, if asked for, of what the pose sensor sees (RenderTruth):
//   FOLDER/truth/NNNNNN.normal.png        127.5 (n + 1), camera frame; 0: none
//   FOLDER/truth/NNNNNN.surface.png       16 bit, surface + 1; of a body 60000
//                                         + its place among the snapshot's
//   FOLDER/truth/NNNNNN.kind.png          16 bit, SurfaceKind + 1
// (0 where there is nothing).
//
// The same options and seed give the same bytes for any thread count. `done`
// is called once for each finished frame, from any thread; it may be empty.
// CANCELLED if `stop` is requested; then, as after any error, what was written
// is removed. ALREADY_EXISTS if there is a recording in FOLDER.
absl::Status RecordWorld(const RecordOptions& options,
                         const std::function<void()>& done,
                         const std::stop_token& stop);

// The same in a world that is there already; options.world is only what
// recording.txt calls it.
absl::Status RecordIn(worlds::World world, const RecordOptions& options,
                      const std::function<void()>& done,
                      const std::stop_token& stop);

// How many frames these options make.
int FrameCount(const RecordOptions& options);

}  // namespace treeline::recorder

#endif  // SIMULATION_RECORDER_RECORDER_H_
