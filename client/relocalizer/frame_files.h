// Query frames from image files.
#ifndef CLIENT_RELOCALIZER_FRAME_FILES_H_
#define CLIENT_RELOCALIZER_FRAME_FILES_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/wire/query_frame.h"

namespace treeline::relocalizer {

// The files of one query.
struct FrameFiles {
  // As the list has it; empty for a single query.
  std::string stem = {};
  std::string color = {};
  std::string depth = {};  // empty: none
};

// How the images are to be understood.
struct FrameFileOptions {
  double depth_unit_m = 0.001;
  bool depth_is_registered = false;
  // "MODEL,p1,p2,..." of the colour camera; empty: the scene's.
  std::string camera = {};
};

// One query a line of `list_path`, in its order; '#' starts a comment. The
// images of stem S are ROOT/S.color.jpg or ROOT/S.color.png and, if it is
// there, ROOT/S.depth.png. NOT_FOUND names the first stem that has no colour
// image; INVALID_ARGUMENT for an empty list.
absl::StatusOr<std::vector<FrameFiles>> ReadFrameList(
    const std::string& list_path, const std::string& root);

// Reads the files. Images are sent as they are, so they are not decoded here;
// but for the size of the colour image, which `camera` goes with. Errors name
// the file or the option.
absl::StatusOr<wire::QueryFrame> ReadFrame(const FrameFiles& files,
                                           const FrameFileOptions& options);

}  // namespace treeline::relocalizer

#endif  // CLIENT_RELOCALIZER_FRAME_FILES_H_
