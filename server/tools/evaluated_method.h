// All that was learned about one method on one recording.
#ifndef SERVER_TOOLS_EVALUATED_METHOD_H_
#define SERVER_TOOLS_EVALUATED_METHOD_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/geometry/rigid3.h"
#include "server/core/forest/model_info.h"
#include "server/tools/evaluation.h"
#include "server/tools/foreign_images.h"
#include "server/tools/report_pictures.h"
#include "server/tools/scene_coordinate_errors.h"
#include "server/tools/split_ratios.h"

namespace treeline {

struct EvaluatedMethod {
  std::string name;  // of --compare, else the model's method
  // Not OK: it could not be trained, opened or asked; nothing else is known.
  absl::Status status;
  std::string model_path;  // empty: a baseline without a file
  ModelInfo model;
  std::vector<FrameResult> results;  // one a frame of the recording
  // The largest resident memory while frames were localized.
  uint64_t peak_memory_bytes = 0;
  // What follows is empty where it was not asked for or cannot be known.
  std::vector<double> scene_errors_m;  // ascending; see SceneCoordinateErrors
  std::vector<ForeignTally> foreign;
  std::vector<LevelSplits> splits;
  std::vector<ReportPicture> pictures;
  std::vector<ErrorHeatMap> heat_maps;
  // world_from_camera of the model's pose sensor.
  std::vector<Rigid3> training_poses;
};

}  // namespace treeline

#endif  // SERVER_TOOLS_EVALUATED_METHOD_H_
