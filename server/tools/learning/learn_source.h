// What somebody wants a scene to be learnt from, found out from its path.
#ifndef SERVER_TOOLS_LEARNING_LEARN_SOURCE_H_
#define SERVER_TOOLS_LEARNING_LEARN_SOURCE_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/dataset/dataset.h"

namespace treeline::learning {

enum class SourceKind {
  kCapture,    // what `treeline import` makes a recording of
  kRecording,  // a data set that can be opened as it is
  kMapBundle   // of `treeline-agent map`: its keyframes are a recording
};

struct LearnSource {
  SourceKind kind = SourceKind::kCapture;
  // kRecording, kMapBundle: how it is opened. kMapBundle: with its cameras.
  std::string uri{};
  // kMapBundle: what it calls its scene, and its calibration's file.
  std::string scene{};
  std::string calibration_path{};
  // kRecording: whether it says itself what its cameras are, as what
  // `treeline import` wrote does.
  bool has_cameras = false;
  // Lists of frames to learn and to test that lie beside the recording; empty
  // unless both are there.
  std::string train_list{};
  std::string test_list{};
};

// `given` is a URI of a data set ("tum:DIR"), a folder in a layout that a data
// set has, a map bundle, or else taken for a capture. NOT_FOUND: there is
// nothing of that name.
absl::StatusOr<LearnSource> FindLearnSource(const std::string& given);

// A name for the scene of `given`: "office" of "captures/office.r3d".
std::string SceneNameOf(const std::string& given);

// FAILED_PRECONDITION, with what to do, unless there are frames that `method`
// can learn: poses, and depth for all methods but sift, which needs a structure
// from motion. `given` is what the user called it.
absl::Status CheckLearnable(const dataset::Dataset& dataset,
                            const std::string& method,
                            const std::string& given);

// How many frames `method` cannot use, for people; empty: none.
std::string LeftOutText(const dataset::Dataset& dataset,
                        const std::string& method);

}  // namespace treeline::learning

#endif  // SERVER_TOOLS_LEARNING_LEARN_SOURCE_H_
