// For tests: databases as RTAB-Map writes them.
#ifndef SERVER_TOOLS_CAPTURE_TESTING_RTABMAP_H_
#define SERVER_TOOLS_CAPTURE_TESTING_RTABMAP_H_

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/geometry/rigid3.h"
#include "server/tools/capture/testing_captures.h"

namespace treeline::capture {

enum class RtabmapDepth { kRvl, kPng, kFloats, kNone };

// One row of Node and of Data, as blobs; nothing: NULL.
struct RtabmapNode {
  int id = 0;
  int session = 0;
  int weight = 0;
  std::optional<std::string> pose;
  std::optional<std::string> image;
  std::optional<std::string> depth;
  std::optional<std::string> confidence;  // since 0.22
  std::optional<std::string> calibration;
};

struct RtabmapDatabase {
  std::string version = "0.21.4";
  std::vector<RtabmapNode> nodes;
  std::optional<std::string> optimized_ids;
  std::optional<std::string> optimized_poses;
};

// Tables, columns and their order of resources/DatabaseSchema.sql.in, or of
// what it was at that version (resources/backward_compatibility).
void WriteDatabase(const RtabmapDatabase& database, const std::string& path);

// Where the camera is on the robot: looking ahead, to the side of its middle.
geometry::Rigid3 RtabmapBaseFromCamera();

// Twelve floats (stepNode() in DBDriverSqlite3.cpp).
std::string RtabmapPose(const geometry::Rigid3& pose);
// serialize() of CameraModel.cpp, with K, five zeros for D, R and P.
std::string RtabmapCalibration(const camera::Camera& camera,
                               const geometry::Rigid3& base_from_camera);
// Before 0.18: floats, with or (before 0.11.2) without the size.
std::string OldRtabmapCalibration(const camera::Camera& camera,
                                  const geometry::Rigid3& base_from_camera,
                                  bool has_size);
// compressData2() of Compression.cpp; `type` is OpenCV's.
std::string RtabmapMatrix(const std::string& values, int rows, int columns,
                          int type);

// The scene in a database of this version, each frame a node from 1 on, placed
// by optimized poses where the version has them; odometry's are a metre and
// more beside. Depth as given.
RtabmapDatabase RtabmapOf(const TrueScene& scene, const std::string& version,
                          RtabmapDepth depth);
// Optimized poses of these nodes, in their order.
void SetOptimizedPoses(const std::vector<int>& nodes,
                       const std::vector<geometry::Rigid3>& world_from_base,
                       RtabmapDatabase& database);

// The whole scene: today's version with RVL, an old one with PNG, a phone's
// with floats.
void WriteRtabmap(const TrueScene& scene, const std::string& path);
void WriteOldRtabmap(const TrueScene& scene, const std::string& path);
void WriteOldestRtabmap(const TrueScene& scene, const std::string& path);
void WritePhoneRtabmap(const TrueScene& scene, const std::string& path);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_TESTING_RTABMAP_H_
