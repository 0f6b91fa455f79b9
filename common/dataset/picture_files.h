// The pictures of a data set, as files.
#ifndef COMMON_DATASET_PICTURE_FILES_H_
#define COMMON_DATASET_PICTURE_FILES_H_

#include <string>

#include "absl/status/statusor.h"
#include "common/image/decode.h"

namespace treeline::dataset {

// The bytes of an encoded picture, 128 MiB at most; errors of base::ReadFile.
absl::StatusOr<std::string> ReadPicture(const std::string& path);
// Its size, by its header; errors of ReadImageSize with the path.
absl::StatusOr<image::ImageSize> ReadPictureSize(const std::string& path);

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_PICTURE_FILES_H_
