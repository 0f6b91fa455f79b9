// How well scene coordinates were predicted, before any pose was fitted: the
// predictions against recorded depth and true poses (thesis Fig. 3.6 and 4.5).
#ifndef EVALUATION_ACCURACY_SCENE_COORDINATE_ERRORS_H_
#define EVALUATION_ACCURACY_SCENE_COORDINATE_ERRORS_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/dataset/dataset.h"
#include "evaluation/accuracy/evaluation.h"
#include "server/core/localizer/localizer.h"

namespace treeline::accuracy {

// Frames that errors are collected from unless said otherwise.
inline constexpr int kSceneErrorFrames = 60;

// Distances between predicted and true scene coordinates (m) of every
// correspondence whose pixel has depth, on up to `max_frames` frames, evenly
// spread over those with depth and ground truth. Where a pixel has several
// predictions it is the one that the localizer reports: the one that supports
// the pose or, if none does, the first. In ascending order. Frames that cannot
// be read or are refused are left out. CANCELLED.
absl::StatusOr<std::vector<double>> SceneCoordinateErrors(
    const localizer::Localizer& localizer, const dataset::Dataset& dataset,
    int max_frames, const EvaluationOptions& options);

// A picture beside a map of its prediction errors.
struct ErrorHeatMap {
  std::string stem;
  int width = 0;  // of the frame (px)
  int height = 0;
  std::string photo_jpeg;
  // The picture in grey, coloured where predictions were made by their mean
  // error, each truncated to kHeatMapMax_m; see HeatColor.
  std::string map_jpeg;
  int predictions = 0;
  double median_error_m = 0;
};
inline constexpr double kHeatMapMax_m = 0.5;

// Colour of an error at a fraction in [0, 1] of kHeatMapMax_m, as "#rrggbb".
std::string HeatColor(double fraction);

// Heat maps of the frames named by index. `dense` is a localizer that samples
// many pixels. Frames without depth, ground truth or predictions are left out.
std::vector<ErrorHeatMap> TakeHeatMaps(const localizer::Localizer& dense,
                                       const dataset::Dataset& dataset,
                                       const std::vector<int>& frames,
                                       const EvaluationOptions& options);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_SCENE_COORDINATE_ERRORS_H_
