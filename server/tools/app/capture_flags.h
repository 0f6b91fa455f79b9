// The options that say how a capture is read, the same for `import` and
// `learn`.
#ifndef SERVER_TOOLS_APP_CAPTURE_FLAGS_H_
#define SERVER_TOOLS_APP_CAPTURE_FLAGS_H_

#include <string>

#include "server/tools/capture/capture.h"
#include "server/tools/capture/recording_writer.h"
#include "server/tools/photographs/import_photographs.h"

namespace CLI {
class App;
}

namespace treeline::tools_app {

struct CaptureFlags {
  std::string format = "auto";
  capture::OpenOptions open;
  capture::WriteOptions write;
  bool keep_turn = false;
  // Of photographs and videos; the rest of it follows from the above.
  photographs::PhotographOptions photographs;
};

// Adds all but the folder to write. `flags` must live as long as `command`.
// `group`: of the help; empty: CLI11's own.
void AddCaptureFlags(CLI::App& command, CaptureFlags& flags,
                     const std::string& group = "");

// Whether `path` holds photographs or a video, and is no capture of a format
// that is known.
bool IsPictures(const std::string& path, const std::string& format);

// What to do with pictures without depth, of the capture at `path`.
std::string PicturesAlone(const std::string& path);

// How they are made a recording in `folder`.
photographs::PhotographOptions PhotographOptionsOf(const CaptureFlags& flags,
                                                   const std::string& folder,
                                                   bool quiet);

// The formats by name, a line each, for the help.
std::string CaptureFormatsHelp();

}  // namespace treeline::tools_app

#endif  // SERVER_TOOLS_APP_CAPTURE_FLAGS_H_
