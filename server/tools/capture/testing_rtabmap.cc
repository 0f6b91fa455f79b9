#include "server/tools/capture/testing_rtabmap.h"

#include <libdeflate.h>
#include <sqlite3.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/file.h"
#include "common/image/decode.h"
#include "common/image/testing_depth_codecs.h"
#include "server/tools/capture/rtabmap_blobs.h"

namespace treeline::capture {
namespace {

constexpr int kIntsType = 4;    // CV_32SC1
constexpr int kFloatsType = 5;  // CV_32FC1
constexpr int kBytesType = 0;   // CV_8UC1

// On the little-endian machines that these tests run on.
template <typename T>
void Append(T value, std::string& out) {
  std::array<char, sizeof(T)> bytes{};
  std::memcpy(bytes.data(), &value, sizeof(T));
  out.append(bytes.data(), bytes.size());
}

std::array<double, 12> RowsOf(const geometry::Rigid3& pose) {
  const geometry::Mat3 r = pose.rotation.Matrix();
  const geometry::Vec3& t = pose.translation;
  return {r(0, 0), r(0, 1), r(0, 2), t.x,     r(1, 0), r(1, 1),
          r(1, 2), t.y,     r(2, 0), r(2, 1), r(2, 2), t.z};
}

void Must(bool is_true) {
  if (!is_true) std::abort();
}

void Execute(sqlite3* database, const std::string& sql) {
  Must(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr) ==
       SQLITE_OK);
}

void BindBlob(sqlite3_stmt* statement, int parameter,
              const std::optional<std::string>& blob) {
  if (!blob) {
    sqlite3_bind_null(statement, parameter);
  } else {
    sqlite3_bind_blob(statement, parameter, blob->data(),
                      static_cast<int>(blob->size()), SQLITE_TRANSIENT);
  }
}

bool IsSince(const std::string& version, const std::array<int, 3>& other) {
  return *ParseRtabmapVersion(version) >= other;
}

void CreateTables(const std::string& version, sqlite3* database) {
  Execute(database,
          "CREATE TABLE Node (id INTEGER NOT NULL, map_id INTEGER NOT NULL, "
          "weight INTEGER, stamp FLOAT, pose BLOB, ground_truth_pose BLOB, "
          "velocity BLOB, label TEXT, gps BLOB, env_sensors BLOB, time_enter "
          "DATE, PRIMARY KEY (id));"
          "CREATE TABLE Link (from_id INTEGER NOT NULL, to_id INTEGER NOT "
          "NULL, type INTEGER NOT NULL, information_matrix BLOB NOT NULL, "
          "transform BLOB, user_data BLOB);"
          "CREATE TABLE Word (id INTEGER NOT NULL, descriptor_size INTEGER NOT "
          "NULL, descriptor BLOB NOT NULL, time_enter DATE, PRIMARY KEY (id));"
          "CREATE UNIQUE INDEX IDX_Node_id on Node (id);");
  Execute(database,
          absl::StrCat(
              "CREATE TABLE Data (id INTEGER NOT NULL, image BLOB, depth BLOB,",
              IsSince(version, {0, 22, 0}) ? "depth_confidence BLOB," : "",
              "calibration BLOB, scan BLOB, scan_info BLOB, user_data BLOB, "
              "time_enter DATE, PRIMARY KEY (id));"
              "CREATE TABLE Admin (version TEXT, preview_image BLOB",
              IsSince(version, {0, 17, 0})
                  ? ", opt_cloud BLOB, opt_ids BLOB, opt_poses BLOB"
                  : "",
              ", time_enter DATE);"
              "INSERT INTO Admin(version) VALUES('",
              version, "');"));
}

class Insert {
 public:
  Insert(sqlite3* database, const std::string& sql) {
    Must(sqlite3_prepare_v2(database, sql.c_str(), -1, &statement_, nullptr) ==
         SQLITE_OK);
  }
  Insert(const Insert&) = delete;
  Insert& operator=(const Insert&) = delete;
  ~Insert() { sqlite3_finalize(statement_); }

  sqlite3_stmt* statement() { return statement_; }
  void Run() {
    Must(sqlite3_step(statement_) == SQLITE_DONE);
    sqlite3_reset(statement_);
  }

 private:
  sqlite3_stmt* statement_ = nullptr;
};

// compressImage() of Compression.cpp: RVL with a name and a size in front.
std::optional<std::string> DepthBlob(const image::DepthImage& depth,
                                     RtabmapDepth kind) {
  const auto width = static_cast<uint32_t>(depth.width);
  const auto height = static_cast<uint32_t>(depth.height);
  if (kind == RtabmapDepth::kRvl) {
    return "DEPTHRVL" + image::EncodedRvl(width, height, depth.values);
  }
  if (kind == RtabmapDepth::kPng) return *image::EncodeDepthPng(depth);
  if (kind == RtabmapDepth::kNone) return std::nullopt;
  std::vector<float> values_m;
  for (const uint16_t value : depth.values) {
    values_m.push_back(0.001F * static_cast<float>(value));
  }
  return image::EncodedFloatDepthPng(width, height, values_m);
}

void WriteWhole(const TrueScene& scene, const std::string& version,
                RtabmapDepth depth, const std::string& path) {
  WriteDatabase(RtabmapOf(scene, version, depth), path);
}

}  // namespace

void WriteDatabase(const RtabmapDatabase& database, const std::string& path) {
  Must(base::MakeParentFolder(path).ok());
  sqlite3* file = nullptr;
  Must(sqlite3_open(path.c_str(), &file) == SQLITE_OK);
  Execute(file, "BEGIN");
  CreateTables(database.version, file);
  const bool has_confidence = IsSince(database.version, {0, 22, 0});
  {
    // Columns as queryStepNode() and queryStepSensorData() name them.
    Insert node(file,
                "INSERT INTO Node(id, map_id, weight, pose, stamp) "
                "VALUES(?,?,?,?,?)");
    Insert data(file, absl::StrCat(
                          "INSERT INTO Data(id, image, depth, calibration",
                          has_confidence ? ", depth_confidence" : "",
                          ") VALUES(?,?,?,?", has_confidence ? ",?" : "", ")"));
    for (const RtabmapNode& row : database.nodes) {
      sqlite3_bind_int(node.statement(), 1, row.id);
      sqlite3_bind_int(node.statement(), 2, row.session);
      sqlite3_bind_int(node.statement(), 3, row.weight);
      BindBlob(node.statement(), 4, row.pose);
      sqlite3_bind_double(node.statement(), 5, 1.6e9 + row.id);
      node.Run();
      sqlite3_bind_int(data.statement(), 1, row.id);
      BindBlob(data.statement(), 2, row.image);
      BindBlob(data.statement(), 3, row.depth);
      BindBlob(data.statement(), 4, row.calibration);
      if (has_confidence) BindBlob(data.statement(), 5, row.confidence);
      data.Run();
    }
    if (database.optimized_ids || database.optimized_poses) {
      // saveOptimizedPosesQuery()
      Insert poses(file, "UPDATE Admin SET opt_ids=?, opt_poses=?");
      BindBlob(poses.statement(), 1, database.optimized_ids);
      BindBlob(poses.statement(), 2, database.optimized_poses);
      poses.Run();
    }
  }
  Execute(file, "COMMIT");
  Must(sqlite3_close(file) == SQLITE_OK);
}

geometry::Rigid3 RtabmapBaseFromCamera() {
  // The camera's z is ahead (x), its x to the right (-y), its y down (-z).
  return {geometry::Rotation3::FromMatrix({{0, 0, 1, -1, 0, 0, 0, -1, 0}}),
          {0.1, -0.05, 0.8}};
}

std::string RtabmapPose(const geometry::Rigid3& pose) {
  std::string bytes;
  for (const double value : RowsOf(pose)) {
    Append(static_cast<float>(value), bytes);
  }
  return bytes;
}

std::string RtabmapCalibration(const camera::Camera& camera,
                               const geometry::Rigid3& base_from_camera) {
  std::string bytes;
  // Version, kind, size, numbers of K, D, R, P and of the local transform.
  for (const int value :
       {0, 21, 4, 0, camera.width(), camera.height(), 9, 5, 9, 12, 12}) {
    Append(int32_t{value}, bytes);
  }
  const double fx = camera.fx();
  const double fy = camera.fy();
  const double cx = camera.cx();
  const double cy = camera.cy();
  for (const double value :
       {fx,  0.0, cx,  0.0, fy,  cy,  0.0, 0.0, 1.0,                  // K
        0.0, 0.0, 0.0, 0.0, 0.0,                                      // D
        1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0,                  // R
        fx,  0.0, cx,  0.0, 0.0, fy,  cy,  0.0, 0.0, 0.0, 1.0, 0.0})  // P
  {
    Append(value, bytes);
  }
  return bytes + RtabmapPose(base_from_camera);
}

std::string OldRtabmapCalibration(const camera::Camera& camera,
                                  const geometry::Rigid3& base_from_camera,
                                  bool has_size) {
  std::string bytes;
  for (const double value :
       {camera.fx(), camera.fy(), camera.cx(), camera.cy()}) {
    Append(static_cast<float>(value), bytes);
  }
  if (has_size) {
    Append(static_cast<float>(camera.width()), bytes);
    Append(static_cast<float>(camera.height()), bytes);
  }
  return bytes + RtabmapPose(base_from_camera);
}

std::string RtabmapMatrix(const std::string& values, int rows, int columns,
                          int type) {
  libdeflate_compressor* const compressor = libdeflate_alloc_compressor(6);
  std::string bytes(libdeflate_zlib_compress_bound(compressor, values.size()),
                    '\0');
  bytes.resize(libdeflate_zlib_compress(
      compressor, values.data(), values.size(), bytes.data(), bytes.size()));
  libdeflate_free_compressor(compressor);
  for (const int value : {rows, columns, type}) Append(int32_t{value}, bytes);
  return bytes;
}

void SetOptimizedPoses(const std::vector<int>& nodes,
                       const std::vector<geometry::Rigid3>& world_from_base,
                       RtabmapDatabase& database) {
  std::string ids;
  std::string poses;
  for (const int node : nodes) Append(int32_t{node}, ids);
  for (const geometry::Rigid3& pose : world_from_base) {
    poses += RtabmapPose(pose);
  }
  const auto count = static_cast<int>(nodes.size());
  database.optimized_ids = RtabmapMatrix(ids, 1, count, kIntsType);
  database.optimized_poses = RtabmapMatrix(poses, 1, 12 * count, kFloatsType);
}

RtabmapDatabase RtabmapOf(const TrueScene& scene, const std::string& version,
                          RtabmapDepth depth) {
  RtabmapDatabase database{.version = version,
                           .nodes = {},
                           .optimized_ids = {},
                           .optimized_poses = {}};
  const geometry::Rigid3 base_from_camera = RtabmapBaseFromCamera();
  const camera::Camera& color = scene.calibration.color;
  const bool has_optimized = IsSince(version, {0, 17, 0});
  std::vector<int> ids;
  std::vector<geometry::Rigid3> poses;
  for (size_t i = 0; i < scene.frames.size(); ++i) {
    const geometry::Rigid3 world_from_base =
        scene.world_from_camera[i] * base_from_camera.Inverse();
    geometry::Rigid3 odometry = world_from_base;
    if (has_optimized) odometry.translation.x += 1 + 0.01 * double(i);
    const image::DepthImage& map = *scene.frames[i].depth;
    ids.push_back(static_cast<int>(i) + 1);
    poses.push_back(world_from_base);
    database.nodes.push_back(
        {.id = ids.back(),
         .session = 0,
         .weight = 0,
         .pose = RtabmapPose(odometry),
         .image = *image::EncodeJpeg(scene.frames[i].color, 98),
         .depth = DepthBlob(map, depth),
         .confidence = RtabmapMatrix(std::string(map.values.size(), 100),
                                     map.height, map.width, kBytesType),
         .calibration =
             IsSince(version, {0, 18, 0})
                 ? RtabmapCalibration(color, base_from_camera)
                 : OldRtabmapCalibration(color, base_from_camera,
                                         IsSince(version, {0, 11, 2}))});
  }
  if (has_optimized) SetOptimizedPoses(ids, poses, database);
  return database;
}

void WriteRtabmap(const TrueScene& scene, const std::string& path) {
  WriteWhole(scene, "0.23.2", RtabmapDepth::kRvl, path);
}

void WriteOldRtabmap(const TrueScene& scene, const std::string& path) {
  WriteWhole(scene, "0.17.6", RtabmapDepth::kPng, path);
}

void WriteOldestRtabmap(const TrueScene& scene, const std::string& path) {
  WriteWhole(scene, "0.10.10", RtabmapDepth::kPng, path);
}

void WritePhoneRtabmap(const TrueScene& scene, const std::string& path) {
  WriteWhole(scene, "0.22.1", RtabmapDepth::kFloats, path);
}

}  // namespace treeline::capture
