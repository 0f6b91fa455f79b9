#include "server/core/training/appearance_builder.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "common/base/parallel_for.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "server/core/recognition/appearance_words.h"

namespace treeline::training {
namespace {

std::vector<int> SelectImages(const dataset::Dataset& dataset, int max_images) {
  std::vector<int> usable;
  for (int i = 0; i < dataset.size(); ++i) {
    if (dataset.frame(i).world_from_camera) usable.push_back(i);
  }
  const auto most = static_cast<size_t>(max_images);
  if (usable.size() <= most) return usable;
  std::vector<int> thinned;
  for (size_t k = 0; k < most; ++k) {
    thinned.push_back(usable[k * usable.size() / most]);
  }
  return thinned;
}

struct ImageWords {
  absl::Status status;
  std::vector<uint32_t> words;
};

absl::Status Extract(const dataset::Dataset& dataset, int image,
                     ImageWords& part) {
  TL_ASSIGN_OR_RETURN(dataset::Dataset::Encoded encoded,
                      dataset.ReadEncoded(image));
  encoded.depth.clear();  // decoded for nothing
  const absl::StatusOr<image::Frame> frame = dataset.Decode(encoded);
  if (!frame.ok()) {
    return base::Annotate(frame.status(), dataset.frame(image).color_path);
  }
  recognition::AppearanceWords words;
  part.words = words.Extract(frame->color);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<recognition::SceneDescriptor> BuildSceneDescriptor(
    const dataset::Dataset& dataset, const AppearanceOptions& options,
    bool quiet, const std::stop_token& stop) {
  if (options.max_images < 1) {
    return absl::InvalidArgumentError("max_images must be positive");
  }
  const std::vector<int> images = SelectImages(dataset, options.max_images);
  std::vector<ImageWords> parts(images.size());
  {
    base::Progress progress(
        "appearance", std::max<int64_t>(1, static_cast<int64_t>(images.size())),
        quiet);
    base::ParallelFor(
        static_cast<int64_t>(images.size()), options.threads, [&](int64_t i) {
          if (stop.stop_requested()) return;
          ImageWords& part = parts[static_cast<size_t>(i)];
          part.status = Extract(dataset, images[static_cast<size_t>(i)], part);
          progress.Add(1);
        });
  }
  if (stop.stop_requested()) {
    return absl::CancelledError("training was interrupted");
  }
  recognition::SceneDescriptor descriptor;
  for (const ImageWords& part : parts) {
    TL_RETURN_IF_ERROR(part.status);
    descriptor.Add(part.words);
  }
  return descriptor;
}

}  // namespace treeline::training
