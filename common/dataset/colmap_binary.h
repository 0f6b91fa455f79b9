// cameras.bin, images.bin and points3D.bin of COLMAP: little-endian, no
// padding.
#ifndef COMMON_DATASET_COLMAP_BINARY_H_
#define COMMON_DATASET_COLMAP_BINARY_H_

#include "absl/status/status.h"
#include "common/dataset/colmap.h"
#include "common/dataset/colmap_builder.h"

namespace treeline::dataset {

// INVALID_ARGUMENT, "FILE: byte N: what", for what is none of these.
absl::Status ReadCamerasBinary(const ColmapFile& file, ColmapBuilder& builder);
absl::Status ReadImagesBinary(const ColmapFile& file, ColmapBuilder& builder);
absl::Status ReadPointsBinary(const ColmapFile& file, ColmapBuilder& builder);

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_COLMAP_BINARY_H_
