#include "server/tools/app/learn_import.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "server/tools/capture/open_capture.h"

namespace treeline::tools_app {
namespace {

// More frames of a capture add hours and hardly a view: phones record 60 a
// second.
constexpr int kManyFrames = 1200;

absl::StatusOr<ImportedCapture> ImportPictures(const std::string& source,
                                               const CaptureFlags& flags,
                                               const std::string& folder,
                                               bool quiet,
                                               const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(
      const photographs::ImportedPhotographs imported,
      photographs::ImportPhotographs(
          source, PhotographOptionsOf(flags, folder, quiet), stop));
  return ImportedCapture{
      .uri = imported.uri,
      .train_list = folder + "/train.txt",
      .test_list = folder + "/test.txt",
      .notes = imported.notes,
      .what = absl::StrFormat(" of %d, placed by structure from motion",
                              imported.pictures)};
}

}  // namespace

absl::StatusOr<ImportedCapture> ImportCapture(const std::string& source,
                                              const CaptureFlags& flags,
                                              const std::string& folder,
                                              bool quiet,
                                              const std::stop_token& stop) {
  if (IsPictures(source, flags.format)) {
    return ImportPictures(source, flags, folder, quiet, stop);
  }
  capture::WriteOptions write = flags.write;
  write.upright = !flags.keep_turn;
  write.folder = folder;
  write.source = source;
  TL_ASSIGN_OR_RETURN(capture::Capture capture,
                      capture::OpenCapture(source, flags.format, flags.open));
  ImportedCapture imported;
  const std::string format = capture.format;
  const int frames = static_cast<int>(capture.frames.size());
  if (write.every == 1 && frames > kManyFrames) {
    write.every = (frames + kManyFrames - 1) / kManyFrames;
    imported.notes.push_back(absl::StrFormat(
        "of %d frames every %d. was taken; --every N takes others", frames,
        write.every));
  }
  absl::StatusOr<capture::WrittenRecording> written;
  {
    base::Progress progress("importing",
                            std::max(1, capture::FramesToWrite(capture, write)),
                            quiet);
    written = capture::WriteRecording(
        std::move(capture), write, [&] { progress.Add(1); }, stop);
  }
  TL_RETURN_IF_ERROR(written.status());
  if (written->with_depth == 0) {
    return absl::FailedPreconditionError(
        absl::StrCat(source, ": no frame has depth. ", PicturesAlone(source)));
  }
  imported.uri = "7scenes:" + folder;
  imported.train_list = folder + "/train.txt";
  imported.test_list = folder + "/test.txt";
  imported.notes.insert(imported.notes.end(), written->notes.begin(),
                        written->notes.end());
  for (const std::string& line : written->left_out.Lines()) {
    imported.notes.push_back("left out: " + line);
  }
  imported.what = absl::StrFormat(" of a %s capture, %d with depth", format,
                                  written->with_depth);
  return imported;
}

}  // namespace treeline::tools_app
