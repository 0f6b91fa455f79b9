// A database of RTAB-Map: of its node in ROS, its desktop program and its apps
// for iPhone and Android.
//
// Conventions (github.com/introlab/rtabmap, July 2026; the blobs in
// rtabmap_blobs.h):
//   tables   DBDriverSqlite3.cpp and resources/DatabaseSchema.sql.in: Node with
//            id, map_id (the session), weight (-9: removed) and pose; Data with
//            image, depth, calibration and, since 0.22, depth_confidence; Admin
//            with version and, since 0.17, opt_ids and opt_poses.
//   poses    of the robot's base, in a world with z up. opt_poses are those
//   that
//            graph optimization found when the database was closed, of all
//            sessions that loops tie together (saveOptimizedPosesQuery());
//            Node.pose is odometry's, of its session.
//   cameras  base_from_camera is the "local transform" to the optical frame (x
//            right, y down, z forward). Pictures of several cameras stand
//            beside each other (SensorData.h), each as wide as the others.
//   depth    registered to colour, with its field of view, often smaller
//            (util3d.cpp, cloudFromDepthRGB()). RVL or PNG in mm, floats in m.
//            Of a stereo camera the second picture is the right one.
#ifndef SERVER_TOOLS_CAPTURE_RTABMAP_H_
#define SERVER_TOOLS_CAPTURE_RTABMAP_H_

#include <string>

#include "absl/status/statusor.h"
#include "server/tools/capture/capture.h"

namespace treeline::capture {

bool IsRtabmap(const std::string& path);
// FAILED_PRECONDITION, with what to do: a stereo camera's, or older than 0.10.
absl::StatusOr<Capture> OpenRtabmap(const std::string& path,
                                    const OpenOptions& options);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_RTABMAP_H_
