// VisualSFM's models and 4-Scenes' info.txt, as arbitrary bytes: no crash, and
// no model that contradicts itself.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "absl/strings/string_view.h"
#include "common/dataset/nvm.h"
#include "common/dataset/twelve_scenes.h"

namespace treeline {
namespace {

void CheckModel(const dataset::SfmModel& model) {
  for (const dataset::SfmModel::Image& image : model.images) {
    if (!geometry::IsFinite(image.camera_from_world)) std::abort();
    for (const dataset::SfmModel::Keypoint& keypoint : image.keypoints) {
      if (keypoint.point < 0 ||
          keypoint.point >= static_cast<int>(model.points.size())) {
        std::abort();
      }
    }
  }
}

void Parse(absl::string_view text) {
  if (const auto nvm = dataset::ParseNvm(text, "fuzz"); nvm.ok()) {
    const std::vector<image::ImageSize> sizes(nvm->images.size(), {640, 480});
    const auto model = dataset::ToSfmModel(*nvm, sizes, "fuzz");
    if (model.ok()) CheckModel(*model);
  }
  if (const auto info = dataset::ParseTwelveScenesInfo(text, "fuzz");
      info.ok()) {
    if (!geometry::IsFinite(info->calibration.color_from_depth) ||
        !(info->depth_unit_m > 0)) {
      std::abort();
    }
  }
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  treeline::Parse(absl::string_view(reinterpret_cast<const char*>(data), size));
  return 0;
}
