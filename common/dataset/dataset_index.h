// What a format's reader finds on disk; Dataset::Open applies the options.
#ifndef COMMON_DATASET_DATASET_INDEX_H_
#define COMMON_DATASET_DATASET_INDEX_H_

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "common/dataset/dataset.h"
#include "common/dataset/text_formats.h"

namespace treeline::dataset {

// The usual cameras of a format whose recordings do not say what theirs are,
// as Camera::Parse reads them. They hold for pictures of this size only.
struct DefaultCameras {
  std::string color;
  std::string depth{};  // empty: depth is registered to colour
  int width = 640;
  int height = 480;
  camera::RgbdSensor pose_sensor = camera::RgbdSensor::kColor;
};

struct DatasetIndex {
  std::vector<DatasetFrame> frames;
  Dataset::MissingPictures missing_pictures{};
  // A calibration where the recording itself has one.
  std::variant<DefaultCameras, camera::RgbdCalibration> cameras;
  double depth_unit_m = 0.001;
  bool units_are_metres = true;
  std::shared_ptr<const SfmModel> structure;
};

// Which part of a sequence to index.
struct IndexRequest {
  // What the URI names: a folder; of nvm: the file.
  std::string path;
  // Of colmap: the folder of the pictures.
  std::string image_folder;
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

// The frames to read, as indices into `stems`: those of the request's list in
// its order, or all of them. StemNotFound for one that is not there.
absl::StatusOr<std::vector<int32_t>> SelectFrames(
    const IndexRequest& request, std::span<const std::string> stems,
    const std::string& where);

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_DATASET_INDEX_H_
