// What `treeline recognize` prints and writes.
#ifndef EVALUATION_ACCURACY_SCENE_RECOGNITION_OUTPUT_H_
#define EVALUATION_ACCURACY_SCENE_RECOGNITION_OUTPUT_H_

#include <string>
#include <vector>

#include "evaluation/accuracy/scene_recognition.h"

namespace treeline::accuracy {

// What the figures are of.
struct RecognitionRun {
  std::string command;
  std::string cpu;
  std::string software_version;
  std::string started_utc;
  std::vector<std::string> scenes;
  double read_ms = 0;
  RecognitionOptions options;
};

std::string RecognitionTable(const std::vector<RecognitionTally>& tallies,
                             const RecognitionRun& run);
// docs/explanation/scene-recognition.md has its keys.
std::string RecognitionJson(const std::vector<RecognitionTally>& tallies,
                            const RecognitionRun& run);
// The data of a report: the same keys, and "kind", "recognition".
std::string RecognitionReportJson(const std::vector<RecognitionTally>& tallies,
                                  const RecognitionRun& run);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_SCENE_RECOGNITION_OUTPUT_H_
