// What an evaluation was run on, and how.
#ifndef EVALUATION_ACCURACY_EVALUATION_RUN_H_
#define EVALUATION_ACCURACY_EVALUATION_RUN_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/accuracy/confidence_report.h"
#include "evaluation/accuracy/thresholds.h"

namespace treeline::accuracy {

// What methods were evaluated on, how, and with which command.
struct EvaluationRun {
  std::string dataset_uri;
  std::string frame_list;  // empty: all frames
  std::string pose_file;   // empty: the sequence's own poses
  uint64_t seed = 0;
  int threads = 1;
  std::vector<ThresholdRequest> thresholds = StandardThresholds();
  double confidence_threshold = kPublishedConfidence;
  std::optional<double> min_confidence;  // nullopt: the models' own
  std::string command;
  std::string cpu;
  std::string software_version;
  std::string started_utc;
  // Of the whole process, training included.
  uint64_t peak_memory_bytes = 0;
};

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_EVALUATION_RUN_H_
