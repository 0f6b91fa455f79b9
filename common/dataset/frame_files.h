// A frame as files side by side, as 7-Scenes and 4-Scenes keep them:
// NAME.color.png or NAME.color.jpg, NAME.depth.png, NAME.pose.txt.
#ifndef COMMON_DATASET_FRAME_FILES_H_
#define COMMON_DATASET_FRAME_FILES_H_

#include <array>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/dataset/dataset_index.h"

namespace treeline::dataset {

struct FrameFileFormat {
  // Looked for in this order.
  std::array<const char*, 2> color_endings;
  // Whether a pose with infinite entries is none: the recorder was lost.
  bool infinite_pose_is_none = false;
};

// The names frame-* of colour pictures in `folder`, without their endings,
// sorted. A folder that cannot be read has none.
std::vector<std::string> FrameNamesIn(const std::string& folder,
                                      const FrameFileFormat& format);

// The frame FOLDER/STEM. Without .depth.png it has no depth, without .pose.txt
// no pose. StemNotFound if it has no colour; errors of ParsePoseMatrix.
absl::StatusOr<DatasetFrame> IndexFrameFiles(const IndexRequest& request,
                                             const std::string& folder,
                                             const FrameFileFormat& format,
                                             const ListedStem& listed);

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_FRAME_FILES_H_
