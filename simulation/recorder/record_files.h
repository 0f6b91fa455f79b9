// The files of a recording, in the layouts of public data sets.
#ifndef SIMULATION_RECORDER_RECORD_FILES_H_
#define SIMULATION_RECORDER_RECORD_FILES_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/dataset/text_formats.h"
#include "common/image/frame.h"
#include "simulation/recorder/recorder.h"

namespace treeline::recorder {

// "0.033333"; times of 0 or later, to the microsecond.
std::string TimeText(dataset::Time_ns time);

// What a frame is called in lists of frames.
std::string StemOf(const RecordOptions& options, int frame,
                   dataset::Time_ns time);

// The folders of a recording, relative to its own.
std::vector<std::string> FoldersOf(const RecordOptions& options);

// Writes a frame's files into the folders of FoldersOf below `folder`.
absl::Status WriteFrameFiles(const RecordOptions& options,
                             const std::string& folder, int index,
                             dataset::Time_ns time, const image::Frame& frame,
                             const geometry::Rigid3& world_from_camera);

// Writes what is truly seen, as RecordOptions says.
absl::Status WriteTruthFiles(const std::string& folder, int index,
                             const renderer::PixelRays& rays,
                             const std::vector<renderer::PixelTruth>& truth);

// rgb.txt, depth.txt and groundtruth.txt: names and contents. Poses and times
// are the frames'.
struct NamedText {
  std::string name;
  std::string text;
};
std::vector<NamedText> TumLists(const std::vector<dataset::TimedPose>& frames,
                                const std::string& world);

}  // namespace treeline::recorder

#endif  // SIMULATION_RECORDER_RECORD_FILES_H_
