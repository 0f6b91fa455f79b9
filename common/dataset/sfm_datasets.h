// COLMAP's and VisualSFM's models as data sets.
#ifndef COMMON_DATASET_SFM_DATASETS_H_
#define COMMON_DATASET_SFM_DATASETS_H_

#include "absl/status/statusor.h"
#include "common/dataset/dataset_index.h"

namespace treeline::dataset {

// A COLMAP model in `path` with its pictures in `image_folder`; see ReadColmap.
absl::StatusOr<DatasetIndex> IndexColmap(const IndexRequest& request);

// VisualSFM's file `path`, pictures relative to the folder it is in.
absl::StatusOr<DatasetIndex> IndexNvm(const IndexRequest& request);

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_SFM_DATASETS_H_
