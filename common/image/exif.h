// What EXIF says of a JPEG: its way up and its lens.
#ifndef COMMON_IMAGE_EXIF_H_
#define COMMON_IMAGE_EXIF_H_

#include <optional>

#include "absl/strings/string_view.h"
#include "common/image/orientation.h"

namespace treeline::image {

// The turn that makes the pixels of a JPEG file upright, by the tag Orientation
// of its first EXIF segment (EXIF 2.32, 4.6.4; TIFF 6.0, section 2). nullopt:
// no JPEG, no such tag, a broken one, or a mirrored picture, of which no camera
// has a pose. Reads at most 64 segments and 256 tags before the picture itself,
// and allocates nothing. Safe on hostile bytes.
std::optional<QuarterTurn> ReadExifUprightTurn(absl::string_view jpeg);

// The tag FocalLengthIn35mmFilm, mm: the focal length at which film of 36 x 24
// mm has the picture's angle of view (across the diagonal, as phones state it).
// nullopt: not stated (0 means that, too), and as above.
std::optional<double> ReadExifFocal35_mm(absl::string_view jpeg);

}  // namespace treeline::image

#endif  // COMMON_IMAGE_EXIF_H_
