#include "server/tools/capture/rtabmap.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "common/sqlite/database.h"
#include "server/tools/capture/conventions.h"
#include "server/tools/capture/picture_files.h"
#include "server/tools/capture/rtabmap_blobs.h"

namespace treeline::capture {
namespace {

// Nodes that were taken out of the map again.
constexpr int64_t kRemovedWeight = -9;
// Confidence of 0, 50 and 100 is what ARKit calls 0, 1 and 2
// (RTABMapApp.cpp); Android's is in sevenths of 100.
constexpr int kPercentALevel = 50;

std::string NodeName(int64_t node) { return absl::StrCat("node ", node); }

std::string TextOf(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// The columns of one of several pictures that stand beside each other.
template <typename T>
std::vector<T> Column(const std::vector<T>& values, int width, int channels,
                      int cameras, int camera) {
  const auto row = static_cast<ptrdiff_t>(width) * channels;
  const ptrdiff_t part = row / cameras;
  std::vector<T> result;
  result.reserve(values.size() / static_cast<size_t>(cameras));
  for (auto at = values.begin(); at != values.end(); at += row) {
    result.insert(result.end(), at + part * camera, at + part * (camera + 1));
  }
  return result;
}

struct FramePlace {
  int64_t node = 0;
  int camera = 0;
  int cameras = 1;
};

class RtabmapPictures final : public PictureSource {
 public:
  RtabmapPictures(std::unique_ptr<sqlite::Database> database,
                  sqlite::Statement one_node, bool has_confidence,
                  const OpenOptions& options)
      : database_(std::move(database)),
        one_node_(std::move(one_node)),
        min_confidence_(has_confidence ? options.min_confidence : 0),
        unit_m_(options.depth_unit_m > 0 ? options.depth_unit_m : 0.001) {}

  void Add(const FramePlace& place) { places_.push_back(place); }

  absl::StatusOr<Pictures> Load(size_t frame) override {
    absl::StatusOr<Pictures> pictures = LoadUnnamed(places_.at(frame));
    if (pictures.ok()) return pictures;
    return base::Annotate(pictures.status(), NodeName(places_[frame].node));
  }

 private:
  absl::StatusOr<Pictures> LoadUnnamed(const FramePlace& place) {
    one_node_.Bind(1, place.node);
    TL_ASSIGN_OR_RETURN(const bool is_there, one_node_.Next());
    if (!is_there) return absl::NotFoundError("it is gone");
    Pictures pictures;
    pictures.encoded_color = TextOf(one_node_.Blob(0));
    TL_ASSIGN_OR_RETURN(pictures.color,
                        image::DecodeColor(pictures.encoded_color));
    const Bytes depth = one_node_.Blob(1);
    if (!depth.empty()) {
      TL_ASSIGN_OR_RETURN(pictures.depth, DecodeRtabmapDepth(depth, unit_m_));
      if (min_confidence_ > 0 && !one_node_.Blob(2).empty()) {
        TL_RETURN_IF_ERROR(DropUncertain(one_node_.Blob(2), *pictures.depth));
      }
    }
    if (place.cameras == 1) return pictures;
    return PartOf(place, std::move(pictures));
  }

  absl::Status DropUncertain(Bytes blob, image::DepthImage& depth) const {
    TL_ASSIGN_OR_RETURN(
        const std::vector<uint8_t> confidence,
        ParseDepthConfidence(blob, {depth.width, depth.height}));
    return KeepConfident(confidence, min_confidence_ * kPercentALevel, depth);
  }

  static absl::StatusOr<Pictures> PartOf(const FramePlace& place,
                                         Pictures pictures) {
    image::ColorImage& color = pictures.color;
    if (color.width % place.cameras != 0 ||
        (pictures.depth && pictures.depth->width % place.cameras != 0)) {
      return absl::InvalidArgumentError(absl::StrCat(
          "its picture cannot be shared by ", place.cameras, " cameras"));
    }
    pictures.encoded_color.clear();
    color.rgb = Column(color.rgb, color.width, 3, place.cameras, place.camera);
    color.width /= place.cameras;
    if (pictures.depth) {
      image::DepthImage& depth = *pictures.depth;
      depth.values =
          Column(depth.values, depth.width, 1, place.cameras, place.camera);
      depth.width /= place.cameras;
    }
    return pictures;
  }

  const std::unique_ptr<sqlite::Database> database_;
  sqlite::Statement one_node_;
  const int min_confidence_;
  const double unit_m_;
  std::vector<FramePlace> places_;
};

struct Node {
  int64_t id = 0;
  int64_t session = 0;
  std::optional<geometry::Rigid3> odometry;
  std::vector<RtabmapCamera> cameras;
};

struct Nodes {
  std::vector<Node> all;
  int with_stereo = 0;
};

// What one row tells of a node with pictures; nothing: it is left out.
std::optional<Node> NodeOf(const sqlite::Statement& row,
                           const RtabmapVersion& version, Nodes& nodes,
                           LeftOut& left_out) {
  Node node{.id = row.Int64(0),
            .session = row.Int64(1),
            .odometry = {},
            .cameras = {}};
  const std::string name = NodeName(node.id);
  if (row.Int64(2) <= kRemovedWeight) {
    left_out.Add("it was removed from the map", name);
    return std::nullopt;
  }
  if (row.Blob(5).empty()) {
    left_out.Add("it has no picture", name);
    return std::nullopt;
  }
  const auto size = image::ReadImageSize(TextOf(row.Blob(5)));
  if (!size.ok()) {
    left_out.Add("its picture cannot be read",
                 absl::StrCat(name, ": ", size.status().message()));
    return std::nullopt;
  }
  auto cameras = ParseRtabmapCalibration(row.Blob(4), version, *size);
  if (absl::IsUnimplemented(cameras.status())) {
    ++nodes.with_stereo;
    left_out.Add("it is of a stereo camera, without depth", name);
    return std::nullopt;
  }
  if (!cameras.ok()) {
    left_out.Add("its calibration cannot be read",
                 absl::StrCat(name, ": ", cameras.status().message()));
    return std::nullopt;
  }
  node.cameras = *std::move(cameras);
  const auto odometry = ParseRtabmapPose(row.Blob(3));
  if (odometry.ok()) node.odometry = *odometry;
  return node;
}

absl::StatusOr<Nodes> ReadNodes(const sqlite::Database& database,
                                const RtabmapVersion& version,
                                LeftOut& left_out) {
  TL_ASSIGN_OR_RETURN(
      sqlite::Statement rows,
      database.Prepare("SELECT Node.id, Node.map_id, Node.weight, Node.pose, "
                       "Data.calibration, Data.image FROM Node LEFT JOIN Data "
                       "ON Data.id = Node.id ORDER BY Node.id"));
  Nodes nodes;
  while (true) {
    TL_ASSIGN_OR_RETURN(const bool is_row, rows.Next());
    if (!is_row) break;
    std::optional<Node> node = NodeOf(rows, version, nodes, left_out);
    if (node) nodes.all.push_back(*std::move(node));
  }
  if (nodes.all.empty() && nodes.with_stereo > 0) {
    return absl::FailedPreconditionError(absl::StrCat(
        database.path(),
        ": was recorded with a stereo camera: it holds a second picture in "
        "place of depth. Learn the left pictures: rtabmap-export --images_id ",
        database.path(),
        ", then `treeline learn` the folder of left pictures "
        "(structure from motion finds poses of its own)"));
  }
  return nodes;
}

absl::StatusOr<RtabmapVersion> ReadVersion(const sqlite::Database& database) {
  const auto too_old = [&] {
    return absl::FailedPreconditionError(
        absl::StrCat(database.path(),
                     ": was made by RTAB-Map before 0.10; bring it up to date: "
                     "rtabmap-reprocess --Db/TargetVersion \"\" ",
                     database.path(), " new.db"));
  };
  for (const char* table : {"Data", "Admin"}) {
    TL_ASSIGN_OR_RETURN(const bool is_there, database.HasTable(table));
    if (!is_there) return too_old();
  }
  TL_ASSIGN_OR_RETURN(sqlite::Statement row,
                      database.Prepare("SELECT version FROM Admin LIMIT 1"));
  TL_ASSIGN_OR_RETURN(const bool is_row, row.Next());
  if (!is_row) return too_old();
  const auto version = ParseRtabmapVersion(row.Text(0));
  if (version.ok()) return version;
  return base::Annotate(version.status(),
                        absl::StrCat(database.path(), ": Admin.version"));
}

// Those of graph optimization, by node; nothing: there are none.
absl::StatusOr<std::map<int, geometry::Rigid3>> ReadOptimizedPoses(
    const sqlite::Database& database) {
  TL_ASSIGN_OR_RETURN(const bool is_new_enough,
                      database.HasColumn("Admin", "opt_poses"));
  if (!is_new_enough) return std::map<int, geometry::Rigid3>();
  TL_ASSIGN_OR_RETURN(
      sqlite::Statement row,
      database.Prepare("SELECT opt_ids, opt_poses FROM Admin WHERE opt_ids IS "
                       "NOT NULL AND opt_poses IS NOT NULL LIMIT 1"));
  TL_ASSIGN_OR_RETURN(const bool is_row, row.Next());
  if (!is_row || row.Blob(0).empty()) {
    return std::map<int, geometry::Rigid3>();
  }
  auto poses = ParseOptimizedPoses(row.Blob(0), row.Blob(1));
  if (poses.ok()) return poses;
  return absl::InvalidArgumentError(absl::StrCat(
      database.path(), ": optimized poses: ", poses.status().message(),
      "; `rtabmap-export --poses --save_in_db ", database.path(),
      "` computes them anew"));
}

// The session of most nodes.
int64_t LargestSession(const std::vector<Node>& nodes) {
  std::map<int64_t, int> sizes;
  for (const Node& node : nodes) ++sizes[node.session];
  const auto largest = std::ranges::max_element(
      sizes, {}, [](const auto& s) { return s.second; });
  return largest == sizes.end() ? 0 : largest->first;
}

// Where the base was, of the nodes that are told. Others are left out.
class Placement {
 public:
  Placement(const std::vector<Node>& nodes,
            std::map<int, geometry::Rigid3> optimized)
      : optimized_(std::move(optimized)), session_(LargestSession(nodes)) {}

  std::optional<geometry::Rigid3> Of(const Node& node,
                                     LeftOut& left_out) const {
    const std::string name = NodeName(node.id);
    if (!optimized_.empty()) {
      const auto found = optimized_.find(static_cast<int>(node.id));
      if (found != optimized_.end()) return found->second;
      left_out.Add("graph optimization did not place it", name);
      return std::nullopt;
    }
    if (node.session != session_) {
      left_out.Add(absl::StrCat("it is of another session than ", session_,
                                ", and no optimized poses relate them"),
                   name);
      return std::nullopt;
    }
    if (!node.odometry) left_out.Add("it has no rigid pose", name);
    return node.odometry;
  }

  std::string Note(const std::string& path) const {
    if (!optimized_.empty()) return "poses of the graph that was optimized";
    return absl::StrCat(
        "poses are odometry's, which drifts: the database holds no optimized "
        "ones. `rtabmap-export --poses --save_in_db ",
        path, "` computes them");
  }

 private:
  const std::map<int, geometry::Rigid3> optimized_;
  const int64_t session_;
};

// Camera after camera, each as one walk: taking every so many-th frame leaves
// out none of them.
void AddFrames(const std::vector<Node>& nodes, const Placement& placement,
               const geometry::Rotation3& z_up, Capture& capture,
               RtabmapPictures& pictures) {
  size_t most_cameras = 0;
  std::vector<std::optional<geometry::Rigid3>> placed;
  for (const Node& node : nodes) {
    placed.push_back(placement.Of(node, capture.left_out));
    most_cameras = std::max(most_cameras, node.cameras.size());
  }
  for (size_t camera = 0; camera < most_cameras; ++camera) {
    for (size_t i = 0; i < nodes.size(); ++i) {
      const Node& node = nodes[i];
      if (!placed[i] || camera >= node.cameras.size()) continue;
      const RtabmapCamera& of_frame = node.cameras[camera];
      std::string name = NodeName(node.id);
      if (node.cameras.size() > 1) absl::StrAppend(&name, " camera ", camera);
      capture.frames.push_back(
          {std::move(name), of_frame.camera,
           Rotated(z_up, *placed[i] * of_frame.base_from_camera)});
      pictures.Add({.node = node.id,
                    .camera = static_cast<int>(camera),
                    .cameras = static_cast<int>(node.cameras.size())});
    }
  }
  if (most_cameras > 1) {
    capture.notes.push_back(
        absl::StrCat("pictures of ", most_cameras,
                     " cameras beside each other, taken apart"));
  }
}

// Broken databases are mended by a program of RTAB-Map's own.
absl::Status WithAdvice(const absl::Status& status) {
  if (!absl::IsDataLoss(status)) return status;
  return absl::DataLossError(absl::StrCat(
      status.message(),
      "; copy it again, or mend it with RTAB-Map's rtabmap-recovery"));
}

absl::StatusOr<Capture> Open(const std::string& path,
                             const OpenOptions& options) {
  TL_ASSIGN_OR_RETURN(const geometry::Rotation3 z_up, ZUpFrom(options.up, "z"));
  TL_ASSIGN_OR_RETURN(sqlite::Database opened, sqlite::Database::Open(path));
  auto database = std::make_unique<sqlite::Database>(std::move(opened));
  TL_ASSIGN_OR_RETURN(const RtabmapVersion version, ReadVersion(*database));
  Capture capture;
  capture.format = "rtabmap";
  TL_ASSIGN_OR_RETURN(const Nodes nodes,
                      ReadNodes(*database, version, capture.left_out));
  TL_ASSIGN_OR_RETURN(auto optimized, ReadOptimizedPoses(*database));
  const Placement placement(nodes.all, std::move(optimized));
  capture.notes.push_back(placement.Note(path));
  TL_ASSIGN_OR_RETURN(const bool has_confidence,
                      database->HasColumn("Data", "depth_confidence"));
  TL_ASSIGN_OR_RETURN(
      sqlite::Statement one_node,
      database->Prepare(absl::StrCat("SELECT image, depth",
                                     has_confidence ? ", depth_confidence" : "",
                                     " FROM Data WHERE id = ?")));
  auto pictures = std::make_unique<RtabmapPictures>(
      std::move(database), std::move(one_node), has_confidence, options);
  AddFrames(nodes.all, placement, z_up, capture, *pictures);
  capture.pictures = std::move(pictures);
  return capture;
}

}  // namespace

bool IsRtabmap(const std::string& path) {
  if (!sqlite::IsDatabase(path)) return false;
  const auto database = sqlite::Database::Open(path);
  if (!database.ok()) return false;
  // One that is cut off is opened, and says so.
  const auto has = [&](const char* table) {
    return database->HasTable(table).value_or(absl::EndsWith(path, ".db"));
  };
  return has("Node") && has("Word") && has("Link");
}

absl::StatusOr<Capture> OpenRtabmap(const std::string& path,
                                    const OpenOptions& options) {
  absl::StatusOr<Capture> capture = Open(path, options);
  if (capture.ok()) return capture;
  return WithAdvice(capture.status());
}

}  // namespace treeline::capture
