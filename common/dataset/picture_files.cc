#include "common/dataset/picture_files.h"

#include <cstdint>

#include "common/base/file.h"
#include "common/base/status_macros.h"

namespace treeline::dataset {
namespace {

constexpr uint64_t kMaxPictureBytes = 128u << 20;

}  // namespace

absl::StatusOr<std::string> ReadPicture(const std::string& path) {
  return base::ReadFile(path, kMaxPictureBytes);
}

absl::StatusOr<image::ImageSize> ReadPictureSize(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const std::string bytes, ReadPicture(path));
  const absl::StatusOr<image::ImageSize> size = image::ReadImageSize(bytes);
  if (!size.ok()) return base::Annotate(size.status(), path);
  return size;
}

}  // namespace treeline::dataset
