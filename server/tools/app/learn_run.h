// `treeline learn`, step by step.
#ifndef SERVER_TOOLS_APP_LEARN_RUN_H_
#define SERVER_TOOLS_APP_LEARN_RUN_H_

#include <stop_token>
#include <string>

#include "absl/status/status.h"
#include "common/dataset/dataset.h"
#include "server/core/training/training_options.h"
#include "server/tools/app/capture_flags.h"

namespace treeline::tools_app {

// Of `treeline learn --live`.
struct LiveFlags {
  bool is_live = false;
  // Frames a second of a recording; 0: as fast as they are learnt.
  double rate_hz = 30;
  // Seconds between two versions of the model that is renewed.
  double publish_every_s = 5;
  // Whose splits are kept; empty: the base that comes with the program.
  std::string base_model;
  // Poses of frames may be corrected; of each is kept what that needs.
  bool takes_corrections = false;
};

struct LearnOptions {
  std::string source;  // a capture, a recording, a URI or a map bundle
  std::string repository = "models";
  std::string scene;   // empty: from the source's name
  std::string output;  // empty: SCENE-learnt
  std::string method;  // empty: universal, or sift for structure from motion
  // How a capture is read.
  CaptureFlags capture;
  // Of a recording; its uri is filled in.
  dataset::DatasetOptions dataset;
  std::string calibration = "auto";
  training::TrainingOptions training;
  // Publish what was tested, without learning the held-out frames too.
  bool only_tested = false;
  LiveFlags live;
  bool quiet = false;
};

// Imports, calibrates, trains, tests on held-out frames, learns those too,
// predicts the coverage, publishes and writes a page. OUTPUT and the version in
// the repository are there when all of it is, or not at all. CANCELLED.
absl::Status LearnPlace(const LearnOptions& options,
                        const std::stop_token& stop);

}  // namespace treeline::tools_app

#endif  // SERVER_TOOLS_APP_LEARN_RUN_H_
