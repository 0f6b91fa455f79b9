// The keyframes of a map: what the scene's forest is trained on.
#ifndef NAV_AGENT_MAP_BUNDLE_KEYFRAME_FILES_H_
#define NAV_AGENT_MAP_BUNDLE_KEYFRAME_FILES_H_

#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/camera/rgbd_calibration.h"
#include "common/geometry/rigid3.h"

namespace treeline::map_bundle {

// Writes a sequence in the layout of 7-Scenes, frame by frame:
//   FOLDER/calibration.json                 the cameras (treeline calibrate)
//   FOLDER/seq-01/frame-NNNNNN.color.jpg    or .png, as it was recorded
//   FOLDER/seq-01/frame-NNNNNN.depth.png    16 bit, mm, 0 not measured
//   FOLDER/seq-01/frame-NNNNNN.pose.txt     4x4 map_from_camera of the
//                                           depth camera (m)
// Not thread-safe.
class KeyframeWriter {
 public:
  // Makes the folder. ALREADY_EXISTS if there is a sequence in it.
  static absl::StatusOr<KeyframeWriter> Create(
      const std::string& folder, const camera::RgbdCalibration& calibration);

  // color: a JPEG or PNG file. depth: a 16-bit PNG file in depth_unit_m; what
  // is not in millimetres is converted, and 65.5 m or more are not measured.
  // map_from_camera: of the calibration's pose sensor. INVALID_ARGUMENT for
  // other files and for a pose that is not finite.
  absl::Status Write(absl::string_view color, absl::string_view depth,
                     double depth_unit_m,
                     const geometry::Rigid3& map_from_camera);

  int count() const { return count_; }

 private:
  KeyframeWriter(std::string sequence,
                 const camera::RgbdCalibration& calibration)
      : sequence_(std::move(sequence)), calibration_(calibration) {}

  std::string sequence_;
  camera::RgbdCalibration calibration_;
  int count_ = 0;
};

}  // namespace treeline::map_bundle

#endif  // NAV_AGENT_MAP_BUNDLE_KEYFRAME_FILES_H_
