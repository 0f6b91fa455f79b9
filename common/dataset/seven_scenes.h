// Recordings in the layout of 7-Scenes.
#ifndef COMMON_DATASET_SEVEN_SCENES_H_
#define COMMON_DATASET_SEVEN_SCENES_H_

#include "absl/status/statusor.h"
#include "common/dataset/dataset_index.h"

namespace treeline::dataset {

// 7-Scenes: DIR/seq-XX/frame-NNNNNN.{color.png|color.jpg,depth.png,pose.txt}.
// A frame without .depth.png has no depth, one without .pose.txt no pose.
// DIR/cameras.json (camera/calibration_json.h), where it is there, has the
// cameras and says whose the poses are; else they are those of 7-Scenes.
absl::StatusOr<DatasetIndex> IndexSevenScenes(const IndexRequest& request);

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_SEVEN_SCENES_H_
