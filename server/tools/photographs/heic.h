// HEIC photographs, read by heif-convert, a program of libheif: decision 50.
#ifndef SERVER_TOOLS_PHOTOGRAPHS_HEIC_H_
#define SERVER_TOOLS_PHOTOGRAPHS_HEIC_H_

#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "common/image/image.h"

namespace treeline::photographs {

// By its name: .heic, .heif or .hif, in capitals or not.
bool IsHeicName(const std::string& name);

// The first picture of the file at `path`, upright and cropped as the file
// says. `program`: the path of heif-convert; it writes to the folder `work`,
// which is made where missing. INVALID_ARGUMENT, with what the program says:
// the file cannot be decoded. CANCELLED.
absl::StatusOr<image::ColorImage> ReadHeic(const std::string& path,
                                           const std::string& program,
                                           const std::string& work,
                                           const std::stop_token& stop);

}  // namespace treeline::photographs

#endif  // SERVER_TOOLS_PHOTOGRAPHS_HEIC_H_
