// Photographs and videos, brought into one folder as structure from motion
// takes them.
#ifndef SERVER_TOOLS_PHOTOGRAPHS_PHOTOGRAPHS_H_
#define SERVER_TOOLS_PHOTOGRAPHS_PHOTOGRAPHS_H_

#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/image/decode.h"

namespace treeline::photographs {

// Larger photographs are left out. Phones take up to 108 megapixels, and what
// is read is made smaller at once.
inline constexpr image::DecodeLimits kPhotographLimits{
    .max_width = 16384, .max_height = 16384, .max_pixels = 128 << 20};

// A folder with three JPEG, PNG or HEIC files or more; a file that ends as
// videos do.
bool IsPhotographs(const std::string& path);
bool IsVideo(const std::string& path);

struct PictureOptions {
  // Longer pictures are made smaller (px); 0: none.
  int max_side_px = 1600;
  // Of a video, every so many-th frame; 0: about 200, evenly spread.
  int every = 0;
  // Reads HEIC photographs: a path, or a name in PATH. Where it is not
  // installed, they are left out.
  std::string heif_convert = "heif-convert";
};

struct CopiedPictures {
  std::vector<std::string> names;  // below the folder, in their order
  // Whether all have one size: then they are taken to be of one camera.
  bool is_one_size = true;
  int longest_side_px = 0;
  // Those that could not be read, and why: each by its name, HEIC files without
  // their program together.
  std::vector<std::string> left_out;
};

// Writes the pictures of `source`, upright as their EXIF says and without it,
// to `folder`, which is there: photographs by their names, frames of a video as
// frame-000000.jpg with their numbers. `done` is called once a picture.
// A photograph that cannot be read is left out; a video that ends early is
// taken as far as it goes. CANCELLED.
absl::StatusOr<CopiedPictures> CopyPictures(const std::string& source,
                                            const std::string& folder,
                                            const PictureOptions& options,
                                            const std::function<void()>& done,
                                            const std::stop_token& stop);

// How many pictures CopyPictures will look at, and at least 1.
absl::StatusOr<int> CountPictures(const std::string& source,
                                  const PictureOptions& options);

}  // namespace treeline::photographs

#endif  // SERVER_TOOLS_PHOTOGRAPHS_PHOTOGRAPHS_H_
