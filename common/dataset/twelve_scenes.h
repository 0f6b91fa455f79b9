// What a recording of Stanford's 4-Scenes says about its cameras.
#ifndef COMMON_DATASET_TWELVE_SCENES_H_
#define COMMON_DATASET_TWELVE_SCENES_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/camera/rgbd_calibration.h"
#include "common/dataset/dataset_index.h"

namespace treeline::dataset {

struct TwelveScenesInfo {
  // Poses are of the depth camera.
  camera::RgbdCalibration calibration;
  double depth_unit_m = 0.001;
};

// info.txt: lines "name = values" with m_{color,depth}{Width,Height},
// m_depthShift (depth units a metre), and as row-major 4 x 4 matrices
// m_calibration{Color,Depth}{Intrinsic,Extrinsic}, the latter from the sensor
// to a common frame. Pinholes, pixel centres at whole numbers. Other lines are
// ignored. INVALID_ARGUMENT, with `file`, for what is missing or no number.
absl::StatusOr<TwelveScenesInfo> ParseTwelveScenesInfo(absl::string_view text,
                                                       const std::string& file);

// Stanford 4-Scenes: DIR/info.txt and
// DIR/data/frame-NNNNNN.{color.jpg|color.png,depth.png,pose.txt}. Poses with
// infinite entries are none.
absl::StatusOr<DatasetIndex> IndexTwelveScenes(const IndexRequest& request);

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_TWELVE_SCENES_H_
