// A scene of Replica as NICE-SLAM rendered it, and as many programs after it
// (ESLAM, Point-SLAM, SplaTAM, ...) read and write scenes.
//
// Conventions (github.com/cvg/nice-slam, src/utils/datasets.py, class Replica;
// configs/Replica/replica.yaml): results/frameN.jpg and results/depthN.png (16
// bit), traj.txt with a line of 16 numbers a frame: camera to world, x right, y
// down, z forward (the class turns y and z round for its own use). The world
// has z up. cam_params.json, here or in the folder above, has "camera" with w,
// h, fx, fy, cx, cy and scale, the units of depth in a metre; cx of the
// released scenes is (w - 1) / 2, so that pixel centres are at integers.
#ifndef SERVER_TOOLS_CAPTURE_REPLICA_H_
#define SERVER_TOOLS_CAPTURE_REPLICA_H_

#include <string>

#include "absl/status/statusor.h"
#include "server/tools/capture/capture.h"

namespace treeline::capture {

bool IsReplica(const std::string& folder);
absl::StatusOr<Capture> OpenReplica(const std::string& folder,
                                    const OpenOptions& options);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_REPLICA_H_
