// What a format's reader finds on disk; Dataset::Open applies the options.
#ifndef SERVER_CORE_DATASET_DATASET_INDEX_H_
#define SERVER_CORE_DATASET_DATASET_INDEX_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/core/dataset/dataset.h"
#include "server/core/dataset/text_formats.h"

namespace treeline {

struct DatasetIndex {
  std::vector<DatasetFrame> frames;
  // The format's defaults, for the image size below.
  std::string color_camera;
  std::string depth_camera;  // empty: depth is registered to colour
  int default_width = 640;
  int default_height = 480;
  double depth_unit_m = 0.001;
  RgbdSensor pose_sensor = RgbdSensor::kColor;
};

// Which part of a sequence to index.
struct IndexRequest {
  std::string folder;
  // Empty: all frames.
  std::vector<ListedStem> stems;
  // The list's file name, for errors.
  std::string frame_list;
  // False: leave DatasetFrame::world_from_camera empty, and do not look for
  // the format's own poses.
  bool read_poses = true;
  double max_time_difference_s = 0.02;
};

// 7-Scenes: DIR/seq-XX/frame-NNNNNN.{color.png|color.jpg,depth.png,pose.txt}.
// A frame without .depth.png has no depth, one without .pose.txt no pose.
absl::StatusOr<DatasetIndex> IndexSevenScenes(const IndexRequest& request);

// TUM RGB-D: DIR/{rgb,depth,groundtruth}.txt. Colour images without a depth
// image in time have no depth; without ground truth in time, no pose.
absl::StatusOr<DatasetIndex> IndexTum(const IndexRequest& request);

// "FILE:LINE: no frame 'STEM' in ..." for a stem of the list.
absl::Status StemNotFound(const IndexRequest& request, const ListedStem& stem,
                          const std::string& where);

}  // namespace treeline

#endif  // SERVER_CORE_DATASET_DATASET_INDEX_H_
