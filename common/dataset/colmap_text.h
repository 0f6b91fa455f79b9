// cameras.txt, images.txt and points3D.txt of COLMAP.
#ifndef COMMON_DATASET_COLMAP_TEXT_H_
#define COMMON_DATASET_COLMAP_TEXT_H_

#include "absl/status/status.h"
#include "common/dataset/colmap.h"
#include "common/dataset/colmap_builder.h"

namespace treeline::dataset {

// INVALID_ARGUMENT, "FILE:LINE: what", for what is none of these.
absl::Status ReadCamerasText(const ColmapFile& file, ColmapBuilder& builder);
absl::Status ReadImagesText(const ColmapFile& file, ColmapBuilder& builder);
absl::Status ReadPointsText(const ColmapFile& file, ColmapBuilder& builder);

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_COLMAP_TEXT_H_
