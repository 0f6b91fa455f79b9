// The pictures of a capture that keeps them as files.
#ifndef SERVER_TOOLS_CAPTURE_PICTURE_FILES_H_
#define SERVER_TOOLS_CAPTURE_PICTURE_FILES_H_

#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/tools/capture/capture.h"

namespace treeline::capture {

// Paths of one frame; an empty one is not there.
struct FrameFiles {
  std::string color;
  std::string depth;       // 16-bit grey PNG
  std::string confidence;  // 8-bit grey PNG of the same size
};

// How depth files are read.
struct DepthRules {
  double unit_m = 0.001;
  // The confidence map's values from here on are kept.
  int min_confidence_value = 0;
};

// A depth map in mm. What is not measured, or does not fit, is 0.
absl::StatusOr<image::DepthImage> DecodeDepth_mm(absl::string_view png,
                                                 double unit_m);
// The same depth in mm.
image::DepthImage ToMillimetres(image::DepthImage depth);
// Sets depth of less confidence to 0. INVALID_ARGUMENT unless there is a value
// for each pixel.
absl::Status KeepConfident(std::span<const uint8_t> confidence, int min_value,
                           image::DepthImage& depth);
// The same, with the map as a PNG.
absl::Status KeepConfident(absl::string_view confidence_png, int min_value,
                           image::DepthImage& depth);

// Depth and confidence of a frame, if it has depth.
absl::StatusOr<std::optional<image::DepthImage>> ReadDepth_mm(
    const FrameFiles& files, const DepthRules& rules);

class PictureFiles final : public PictureSource {
 public:
  PictureFiles(std::vector<FrameFiles> frames, DepthRules rules)
      : frames_(std::move(frames)), rules_(rules) {}
  absl::StatusOr<Pictures> Load(size_t frame) override;

 private:
  const std::vector<FrameFiles> frames_;
  const DepthRules rules_;
};

// The path where it is a file, else an empty one.
std::string IfFile(std::string path);
// The first of PATH.jpg, .jpeg, .png and those in capitals that is a file.
std::string FindPicture(const std::string& path);

// The folder of most photographs (JPEG, PNG, HEIC), three or more, among
// `capture`, or the folder that the file lies in, and the folders in it; empty:
// there is none.
std::string PhotographFolderIn(const std::string& capture);

// Whether a comes before b, with runs of digits compared as numbers, so that
// frame_9 comes before frame_10.
bool NaturalLess(absl::string_view a, absl::string_view b);

// The names in `folder` that have this ending, without it, in natural order.
std::vector<std::string> StemsIn(const std::string& folder,
                                 absl::string_view ending);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_PICTURE_FILES_H_
