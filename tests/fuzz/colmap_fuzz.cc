// COLMAP's model files, text and binary, as arbitrary bytes: no crash, and no
// model that contradicts itself. An input is a byte whose bits say which files
// are binary (1 cameras, 2 images, 4 points), then cameras and images, each
// after its length in two bytes, then points.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "common/dataset/colmap.h"

namespace treeline {
namespace {

// The part at `at` after its length; whatever is left if that is more.
std::string NextPart(const uint8_t* data, size_t size, size_t& at) {
  if (at + 2 > size) return "";
  const size_t length = std::min<size_t>(
      static_cast<size_t>(data[at] | data[at + 1] << 8), size - at - 2);
  const std::string part(reinterpret_cast<const char*>(data) + at + 2, length);
  at += 2 + length;
  return part;
}

void CheckModel(const dataset::SfmModel& model) {
  for (const camera::Camera& camera : model.cameras) {
    if (camera.width() < 1 || !(camera.fx() > 0)) std::abort();
  }
  for (const dataset::SfmModel::Image& image : model.images) {
    if (image.camera < 0 ||
        static_cast<size_t>(image.camera) >= model.cameras.size() ||
        !geometry::IsFinite(image.camera_from_world) || image.name.empty()) {
      std::abort();
    }
    for (const dataset::SfmModel::Keypoint& keypoint : image.keypoints) {
      if (keypoint.point < -1 ||
          keypoint.point >= static_cast<int>(model.points.size())) {
        std::abort();
      }
    }
  }
  for (const dataset::SfmModel::Point& point : model.points) {
    if (!geometry::IsFinite(point.position_in_world)) std::abort();
  }
}

void Parse(const uint8_t* data, size_t size) {
  if (size == 0) return;
  size_t at = 1;
  dataset::ColmapFiles files;
  files.cameras = dataset::ColmapFile{"cameras", NextPart(data, size, at),
                                      (data[0] & 1) != 0};
  files.images = {"images", NextPart(data, size, at), (data[0] & 2) != 0};
  files.points = dataset::ColmapFile{
      "points",
      std::string(reinterpret_cast<const char*>(data) + at, size - at),
      (data[0] & 4) != 0};
  const auto model = dataset::ParseColmap(files);
  if (model.ok()) CheckModel(*model);
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  treeline::Parse(data, size);
  return 0;
}
