// Pictures that do not show the scene: all of them must come back not
// localized.
#ifndef EVALUATION_ACCURACY_FOREIGN_IMAGES_H_
#define EVALUATION_ACCURACY_FOREIGN_IMAGES_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/camera/rgbd_calibration.h"
#include "common/dataset/dataset.h"
#include "evaluation/accuracy/evaluation.h"
#include "server/core/localizer/localizer.h"

namespace treeline::accuracy {

// Where foreign pictures come from, as the command line says it.
struct NegativeSource {
  std::string name;  // as given
  // Made by BuiltinForeignFrame if true, else frames of a recording.
  bool builtin = false;
  int builtin_count = 0;
  dataset::DatasetOptions dataset;
};

// Built-in pictures that are asked about unless a number is given. Each is
// asked about with and without depth.
inline constexpr int kBuiltinForeignImages = 280;

// "builtin", "builtin,N", "URI" or "URI,FRAMES" with a frame list; a recording
// may be followed by ";color-camera=CAMERA", ";depth-camera=CAMERA" and
// ";depth-unit=M", each as the option of that name has it. INVALID_ARGUMENT for
// anything else.
absl::StatusOr<NegativeSource> ParseForeignSource(absl::string_view text);

// Picture `index` of an endless series, of the sizes of `calibration`, with
// depth: noise of several grains, walls of one colour with and without sensor
// noise, gradients, stripes, black and white; depths flat, slanted, random or
// missing. A function of its arguments alone.
image::Frame BuiltinForeignFrame(const camera::RgbdCalibration& calibration,
                                 int index);

// What became of a source's pictures.
struct NegativeTally {
  std::string source;
  bool with_depth = false;
  int images = 0;
  int accepted = 0;   // came back localized: false accepts
  int confident = 0;  // those of them at or above the confidence threshold
  int not_localized = 0;
  int refused = 0;     // the localizer refused them: no depth, for example
  int unreadable = 0;  // files that could not be read
  // Names of the first few that were accepted, and messages of the first few
  // that could not be read.
  std::vector<std::string> accepted_names{};
  std::vector<std::string> problems{};
};

// Asks about every picture of every source, with depth where it has some and
// without: two tallies a source, the second the one without depth. The
// pictures of a recording go with its own cameras where they differ from the
// scene's in size or are known; see QueryCalibration. A picture that cannot be
// read is counted and the rest goes on. Errors are those of opening a
// recording; CANCELLED.
absl::StatusOr<std::vector<NegativeTally>> AskForeign(
    const localizer::Localizer& localizer,
    const std::vector<NegativeSource>& sources, double confidence_threshold,
    const EvaluationOptions& options);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_FOREIGN_IMAGES_H_
