// Accuracy camera by camera, where a recording has several.
#ifndef EVALUATION_ACCURACY_CAMERA_ROWS_H_
#define EVALUATION_ACCURACY_CAMERA_ROWS_H_

#include <string>
#include <vector>

#include "evaluation/accuracy/answer_counts.h"
#include "evaluation/accuracy/evaluated_method.h"

namespace treeline::accuracy {

struct CameraRow {
  std::string camera;  // FrameResult::camera, or kOtherCameras
  AnswerCounts counts;
};

// A photograph may have a camera of its own: those beyond the most frequent
// ones are one row.
inline constexpr size_t kMaxCameraRows = 12;
inline constexpr const char* kOtherCameras = "others";

// Those with most frames first. Empty if there are not two cameras.
std::vector<CameraRow> CameraRows(const EvaluatedMethod& method,
                                  double confidence_threshold);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_CAMERA_ROWS_H_
