// The first step of `treeline learn`: a capture becomes a recording.
#ifndef SERVER_TOOLS_APP_LEARN_IMPORT_H_
#define SERVER_TOOLS_APP_LEARN_IMPORT_H_

#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/tools/app/capture_flags.h"

namespace treeline::tools_app {

struct ImportedCapture {
  std::string uri;  // how the recording is opened
  std::string train_list;
  std::string test_list;
  // What was taken for granted, converted and left out.
  std::vector<std::string> notes;
  // What follows "N frames": " of a stray capture, 300 with depth".
  std::string what;
};

// Makes a recording of a capture, of photographs or of a video in `folder`,
// which is not there yet. Of a capture with very many frames, evenly spread
// ones are taken unless the flags say which.
absl::StatusOr<ImportedCapture> ImportCapture(const std::string& source,
                                              const CaptureFlags& flags,
                                              const std::string& folder,
                                              bool quiet,
                                              const std::stop_token& stop);

}  // namespace treeline::tools_app

#endif  // SERVER_TOOLS_APP_LEARN_IMPORT_H_
