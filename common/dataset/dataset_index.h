// What a format's reader finds on disk; Dataset::Open applies the options.
#ifndef COMMON_DATASET_DATASET_INDEX_H_
#define COMMON_DATASET_DATASET_INDEX_H_

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/dataset/dataset.h"
#include "common/dataset/text_formats.h"

namespace treeline::dataset {

struct DatasetIndex {
  std::vector<DatasetFrame> frames;
  // The format's defaults, for the image size below.
  std::string color_camera;
  std::string depth_camera;  // empty: depth is registered to colour
  int default_width = 640;
  int default_height = 480;
  double depth_unit_m = 0.001;
  camera::RgbdSensor pose_sensor = camera::RgbdSensor::kColor;
  // Where the format knows its cameras itself: in place of all of the above
  // but the depth unit.
  std::optional<camera::RgbdCalibration> calibration;
  bool units_are_metres = true;
  std::shared_ptr<const SfmModel> structure;
};

// Which part of a sequence to index.
struct IndexRequest {
  // What the URI names: a folder, of VisualSFM the file.
  std::string folder;
  // The second folder of colmap:.
  std::string images;
  // Empty: all frames.
  std::vector<ListedStem> stems;
  // The list's file name, for errors.
  std::string frame_list;
  // False: leave DatasetFrame::world_from_camera empty, and do not look for
  // the format's own poses.
  bool read_poses = true;
  double max_time_difference_s = 0.02;
  // Of structure from motion: in place of the model's cameras, unless empty.
  std::string color_camera;
};

// "FILE:LINE: no frame 'STEM' in ..." for a stem of the list.
absl::Status StemNotFound(const IndexRequest& request, const ListedStem& stem,
                          const std::string& where);

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_DATASET_INDEX_H_
