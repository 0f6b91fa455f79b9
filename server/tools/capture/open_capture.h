// Which formats of captures are known, and which one a path is of.
#ifndef SERVER_TOOLS_CAPTURE_OPEN_CAPTURE_H_
#define SERVER_TOOLS_CAPTURE_OPEN_CAPTURE_H_

#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "server/tools/capture/capture.h"

namespace treeline::capture {

struct CaptureFormat {
  const char* name;
  const char* summary;  // one line for the help
  bool (*is_it)(const std::string& path);
  absl::StatusOr<Capture> (*open)(const std::string& path,
                                  const OpenOptions& options);
};

// In the order in which `auto` tries them.
std::span<const CaptureFormat> CaptureFormats();

// Reads what is small of a capture: cameras, poses, names of files. format:
// a name of CaptureFormats, or "auto". NOT_FOUND: there is no such path.
// INVALID_ARGUMENT: it is of no known format, or is not as its format has it.
absl::StatusOr<Capture> OpenCapture(const std::string& path,
                                    const std::string& format,
                                    const OpenOptions& options);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_OPEN_CAPTURE_H_
