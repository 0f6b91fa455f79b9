// For tests: scenes laid out as data sets and programs of research write them.
#ifndef SERVER_TOOLS_CAPTURE_TESTING_DATASETS_H_
#define SERVER_TOOLS_CAPTURE_TESTING_DATASETS_H_

#include <string>

#include "server/tools/capture/testing_captures.h"

namespace treeline::capture {

// saveToFile() of ScanNet's sensorData.h: JPEG, depth by zlib.
std::string SensBytes(const TrueScene& scene);
void WriteSens(const TrueScene& scene, const std::string& path);

// With cam_params.json in the scene's folder.
void WriteReplica(const TrueScene& scene, const std::string& folder);

// As realsense_recorder.py and integrate_scene.py lay it down, in a world with
// y down.
void WriteOpen3d(const TrueScene& scene, const std::string& folder);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_TESTING_DATASETS_H_
