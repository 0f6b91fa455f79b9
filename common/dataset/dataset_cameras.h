// Which cameras a data set has: those of its options, of its recording, or the
// usual ones of its format.
#ifndef COMMON_DATASET_DATASET_CAMERAS_H_
#define COMMON_DATASET_DATASET_CAMERAS_H_

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "common/camera/rgbd_calibration.h"
#include "common/dataset/dataset_index.h"

namespace treeline::dataset {

// Takes the cameras of FOLDER/cameras.json, as `treeline import` and `treeline
// calibrate` write it, for the index's, if that file is there.
absl::Status ReadCamerasFile(const std::string& folder, DatasetIndex& index);

// Whether depth pixels see what colour pixels see.
bool DepthIsRegistered(const DatasetIndex& index);

// The calibration of an index with at least one frame. focal_length_px: what a
// pose file says of the colour camera; the option wins over it.
// INVALID_ARGUMENT if the format's usual camera is needed and pictures have
// another size, or if registered depth is given a camera; errors of reading.
absl::StatusOr<camera::RgbdCalibration> ChooseCalibration(
    const DatasetOptions& options, const DatasetIndex& index,
    std::optional<double> focal_length_px);

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_DATASET_CAMERAS_H_
