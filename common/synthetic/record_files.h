// The files of a recording, in the layouts of public data sets.
#ifndef COMMON_SYNTHETIC_RECORD_FILES_H_
#define COMMON_SYNTHETIC_RECORD_FILES_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/dataset/text_formats.h"
#include "common/image/frame.h"
#include "common/synthetic/recorder.h"

namespace treeline {

// "0.033333"; times of 0 or later, to the microsecond.
std::string TimeText(Time_ns time);

// What a frame is called in lists of frames.
std::string StemOf(const RecordOptions& options, int frame, Time_ns time);

// The folders of a recording, relative to its own.
std::vector<std::string> FoldersOf(const RecordOptions& options);

// Writes a frame's files into the folders of FoldersOf below `folder`.
absl::Status WriteFrameFiles(const RecordOptions& options,
                             const std::string& folder, int index, Time_ns time,
                             const Frame& frame,
                             const Rigid3& world_from_camera);

// Writes what is truly seen, as RecordOptions says.
absl::Status WriteTruthFiles(const std::string& folder, int index,
                             const PixelRays& rays,
                             const std::vector<PixelTruth>& truth);

// rgb.txt, depth.txt and groundtruth.txt: names and contents. Poses and times
// are the frames'.
struct NamedText {
  std::string name;
  std::string text;
};
std::vector<NamedText> TumLists(const std::vector<TimedPose>& frames,
                                const std::string& world);

}  // namespace treeline

#endif  // COMMON_SYNTHETIC_RECORD_FILES_H_
