#include "client/relocalizer/frame_files.h"

#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/file.h"
#include "common/base/folder.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"

namespace treeline::relocalizer {
namespace {

// Far more than a server takes.
constexpr uint64_t kMaxFileBytes = 256 << 20;

absl::StatusOr<FrameFiles> FilesOf(const std::string& stem,
                                   const std::string& root) {
  const std::string base = absl::StrCat(root, "/", stem);
  FrameFiles files{
      .stem = stem, .color = base + ".color.jpg", .depth = base + ".depth.png"};
  if (!base::IsFile(files.color)) files.color = base + ".color.png";
  if (!base::IsFile(files.color)) {
    return absl::NotFoundError(absl::StrCat("neither ", base, ".color.jpg nor ",
                                            base, ".color.png is there"));
  }
  if (!base::IsFile(files.depth)) files.depth.clear();
  return files;
}

}  // namespace

absl::StatusOr<std::vector<FrameFiles>> ReadFrameList(
    const std::string& list_path, const std::string& root) {
  TL_ASSIGN_OR_RETURN(const std::string text, base::ReadFile(list_path));
  std::vector<FrameFiles> list;
  for (const absl::string_view line : absl::StrSplit(text, '\n')) {
    const std::vector<absl::string_view> parts = absl::StrSplit(line, '#');
    const absl::string_view stem = absl::StripAsciiWhitespace(parts[0]);
    if (stem.empty()) continue;
    const absl::StatusOr<FrameFiles> files =
        FilesOf(std::string(stem.data(), stem.size()), root);
    if (!files.ok()) return base::Annotate(files.status(), list_path);
    list.push_back(*files);
  }
  if (list.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(list_path, " names no frames"));
  }
  return list;
}

absl::StatusOr<wire::QueryFrame> ReadFrame(const FrameFiles& files,
                                           const FrameFileOptions& options) {
  wire::QueryFrame frame;
  wire::EncodedImage color;
  TL_ASSIGN_OR_RETURN(color.bytes, base::ReadFile(files.color, kMaxFileBytes));
  if (!options.camera.empty()) {
    const absl::StatusOr<image::ColorImage> image =
        image::DecodeColor(color.bytes);
    if (!image.ok()) return base::Annotate(image.status(), files.color);
    const absl::StatusOr<camera::Camera> camera =
        camera::Camera::Parse(options.camera, image->width, image->height);
    if (!camera.ok()) return base::Annotate(camera.status(), "--camera");
    frame.camera = *camera;
  }
  frame.color = std::move(color);
  if (!files.depth.empty()) {
    wire::EncodedImage depth;
    TL_ASSIGN_OR_RETURN(depth.bytes,
                        base::ReadFile(files.depth, kMaxFileBytes));
    frame.depth = wire::QueryDepth{
        .image = std::move(depth),
        .unit_m = options.depth_unit_m,
        .registration = options.depth_is_registered
                            ? wire::DepthRegistration::kRegisteredToColor
                            : wire::DepthRegistration::kSceneCalibration};
  }
  return frame;
}

}  // namespace treeline::relocalizer
