// All that was learned about one method on one recording.
#ifndef EVALUATION_ACCURACY_EVALUATED_METHOD_H_
#define EVALUATION_ACCURACY_EVALUATED_METHOD_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/geometry/rigid3.h"
#include "evaluation/accuracy/evaluation.h"
#include "evaluation/accuracy/foreign_images.h"
#include "evaluation/accuracy/perturbation.h"
#include "evaluation/accuracy/report_pictures.h"
#include "evaluation/accuracy/scene_coordinate_errors.h"
#include "evaluation/accuracy/split_ratios.h"
#include "server/core/forest/model_info.h"

namespace treeline::accuracy {

// What became of frames that were changed before they were asked about.
struct PerturbedResults {
  Perturbation perturbation;
  std::vector<FrameResult> results;
};

struct EvaluatedMethod {
  std::string name;  // of --compare, else the model's method
  // Not OK: it could not be trained, opened or asked; nothing else is known.
  absl::Status status;
  std::string model_path;  // empty: a baseline without a file
  forest::ModelInfo model;
  std::vector<FrameResult> results;  // one a frame of the recording
  // The largest resident memory while frames were localized.
  uint64_t peak_memory_bytes = 0;
  // What follows is empty where it was not asked for or cannot be known.
  std::vector<double> scene_errors_m;  // ascending; see SceneCoordinateErrors
  std::vector<NegativeTally> foreign;
  // The same frames in each, as they are first.
  std::vector<PerturbedResults> perturbed;
  std::vector<LevelSplits> splits;
  std::vector<ReportPicture> pictures;
  std::vector<ErrorHeatMap> heat_maps;
  // world_from_camera of the model's pose sensor.
  std::vector<geometry::Rigid3> training_poses;
};

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_EVALUATED_METHOD_H_
