#include "nav_agent/fusion/octomap_builder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "nav_agent/fusion/moved_voxels.h"
#include "nav_agent/octomap/log_odds_file.h"

namespace treeline::fusion {
namespace {

constexpr int kSide = OccupancyBlocks::kSide;
// OctoMap's keys reach so many voxels each way.
constexpr double kMapReach = 1 << 15;

absl::StatusOr<geometry::Rigid3> CheckedPose(const geometry::Rigid3& pose) {
  const geometry::Rotation3& q = pose.rotation;
  const double norm = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  if (!geometry::IsFinite(pose) || !(std::abs(norm - 1) <= 1e-3)) {
    return absl::InvalidArgumentError(
        "a view's pose is not a rotation and a translation");
  }
  return geometry::Rigid3{.rotation = geometry::Normalized(q),
                          .translation = pose.translation};
}

// The block that a place (in voxels) lies in.
int BlockOf(double place) {
  return static_cast<int>(std::floor(place / kSide));
}

// Rounded down to a multiple.
int Below(int value, int multiple) {
  const int rest = value % multiple;
  return value - (rest < 0 ? rest + multiple : rest);
}

// Sets the voxels of one block's column in `map`, runs at a time.
void PaintColumn(const OccupancyBlocks::Block& block, size_t column,
                 float occupied_log_odds, octree::VoxelIndex first,
                 octree::VoxelMap& map) {
  const unsigned known = block.known[column];
  const float* const values = block.log_odds.data() + column * kSide;
  const auto state_of = [known, values, occupied_log_odds](int z) {
    if ((known >> z & 1) == 0) return octree::Voxel::kUnknown;
    return values[z] >= occupied_log_odds ? octree::Voxel::kOccupied
                                          : octree::Voxel::kFree;
  };
  int begin = 0;
  while (begin < kSide) {
    const octree::Voxel state = state_of(begin);
    int end = begin + 1;
    while (end < kSide && state_of(end) == state) ++end;
    if (state != octree::Voxel::kUnknown) {
      map.SetRun(first.x, first.y, first.z + begin, first.z + end, state);
    }
    begin = end;
  }
}

}  // namespace

absl::StatusOr<OctomapBuilder> OctomapBuilder::Make(
    const FusionOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  return OctomapBuilder(options);
}

absl::Status OctomapBuilder::InsertDepth(
    int64_t id, const image::DepthImage& depth, const camera::Camera& camera,
    const geometry::Rigid3& map_from_camera) {
  TL_ASSIGN_OR_RETURN(CompactCloud cloud,
                      MakeDepthCloud(depth, camera, options_));
  return Insert(id, ViewKind::kSurfaces, std::move(cloud), map_from_camera);
}

absl::Status OctomapBuilder::InsertPoints(
    int64_t id, std::span<const geometry::Vec3> points_in_sensor,
    const geometry::Rigid3& map_from_sensor) {
  return Insert(id, ViewKind::kLines,
                MakePointCloud(points_in_sensor, options_), map_from_sensor);
}

absl::Status OctomapBuilder::Insert(int64_t id, ViewKind kind,
                                    CompactCloud cloud,
                                    const geometry::Rigid3& map_from_sensor) {
  if (view_of_id_.contains(id)) {
    return absl::AlreadyExistsError(
        absl::StrCat("there is a view ", id, " already"));
  }
  TL_ASSIGN_OR_RETURN(const geometry::Rigid3 pose,
                      CheckedPose(map_from_sensor));
  const int64_t cloud_bytes =
      cloud.bytes() + static_cast<int64_t>(sizeof(View) + 32);
  cloud_bytes_ += cloud_bytes;
  const auto changed = Fuse(cloud, kind, pose, map_);
  if (!changed.ok()) {
    cloud_bytes_ -= cloud_bytes;
    return changed.status();
  }
  changed_ = Union(changed_, *changed);
  view_of_id_[id] = views_.size();
  views_.push_back({.pose = {.id = id, .map_from_sensor = pose},
                    .kind = kind,
                    .cloud = std::move(cloud)});
  return absl::OkStatus();
}

int64_t OctomapBuilder::WorkingBytes(octree::VoxelIndex blocks) const {
  // A byte and a pointer for each block besides the grid's bits.
  return ViewGrid::BytesFor(blocks) * (2 * kSide * kSide + 9) /
             (2 * kSide * kSide) +
         static_cast<int64_t>(places_.size() * sizeof(geometry::Vec3));
}

absl::StatusOr<geometry::Vec3> OctomapBuilder::Trace(
    const CompactCloud& cloud, const geometry::Rigid3& map_from_sensor) {
  // Places in voxels of the map.
  const geometry::Mat3 rotation = map_from_sensor.rotation.Matrix();
  const geometry::Vec3 origin =
      map_from_sensor.translation / options_.resolution_m;
  const double scale = cloud.unit_m / options_.resolution_m;
  geometry::Vec3 low = origin;
  geometry::Vec3 high = origin;
  places_.resize(cloud.points.size());
  for (size_t i = 0; i < cloud.points.size(); ++i) {
    const CompactPoint& point = cloud.points[i];
    const geometry::Vec3 place =
        rotation *
            geometry::Vec3{scale * point.x, scale * point.y, scale * point.z} +
        origin;
    low = {std::min(low.x, place.x), std::min(low.y, place.y),
           std::min(low.z, place.z)};
    high = {std::max(high.x, place.x), std::max(high.y, place.y),
            std::max(high.z, place.z)};
    places_[i] = place;
  }
  const double reach = kMapReach - 2 * kSide;
  if (!(std::min({low.x, low.y, low.z}) >= -reach &&
        std::max({high.x, high.y, high.z}) <= reach)) {
    return absl::InvalidArgumentError(
        "a view lies more than 2^15 voxels from the map's origin");
  }

  // The view's box, with a voxel to spare on all sides.
  const octree::VoxelIndex first{BlockOf(low.x - 1), BlockOf(low.y - 1),
                                 BlockOf(low.z - 1)};
  const octree::VoxelIndex blocks{BlockOf(high.x + 1) + 1 - first.x,
                                  BlockOf(high.y + 1) + 1 - first.y,
                                  BlockOf(high.z + 1) + 1 - first.z};
  const int64_t working = WorkingBytes(blocks);
  if (options_.max_bytes - cloud_bytes_ - working < 0) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "the clouds (", cloud_bytes_ >> 10,
        " KiB) and the view's working space (", working >> 10,
        " KiB) take more than ", options_.max_bytes >> 10, " KiB"));
  }
  grid_.Reset(first, blocks);
  const geometry::Vec3 grid_from_map{static_cast<double>(-first.x * kSide),
                                     static_cast<double>(-first.y * kSide),
                                     static_cast<double>(-first.z * kSide)};
  const geometry::Vec3 eye = origin + grid_from_map;
  for (size_t i = 0; i < places_.size(); ++i) {
    const geometry::Vec3 place = places_[i] + grid_from_map;
    if (i < cloud.hits && !grid_.MarkOccupied(place)) continue;
    grid_.MarkFree(eye, place);
  }
  return eye;
}

absl::StatusOr<std::optional<ColumnBox>> OctomapBuilder::Fuse(
    const CompactCloud& cloud, ViewKind kind,
    const geometry::Rigid3& map_from_sensor, OccupancyBlocks& map) {
  TL_RETURN_IF_ERROR(Trace(cloud, map_from_sensor).status());
  const int64_t map_bytes =
      options_.max_bytes - cloud_bytes_ - WorkingBytes(grid_.blocks());
  return map.Add(grid_, kind, map_bytes / OccupancyBlocks::kBlockBytes);
}

absl::StatusOr<int64_t> OctomapBuilder::ForgetMoved() {
  MovedVoxels voxels(map_, options_);
  for (const View& view : views_) {
    TL_ASSIGN_OR_RETURN(const geometry::Vec3 eye,
                        Trace(view.cloud, view.pose.map_from_sensor));
    voxels.Add(grid_, view.kind, eye);
  }
  const std::vector<octree::VoxelIndex> moved = voxels.Find(map_);
  for (const octree::VoxelIndex& voxel : moved) {
    map_.MakeFree(voxel);
    changed_ = Union(changed_, ColumnBox{.begin_x = voxel.x,
                                         .begin_y = voxel.y,
                                         .end_x = voxel.x + 1,
                                         .end_y = voxel.y + 1});
  }
  return static_cast<int64_t>(moved.size());
}

absl::Status OctomapBuilder::SetPoses(std::span<const ViewPose> poses) {
  std::vector<geometry::Rigid3> new_poses;
  new_poses.reserve(views_.size());
  for (const View& view : views_) {
    new_poses.push_back(view.pose.map_from_sensor);
  }
  for (const ViewPose& pose : poses) {
    const auto found = view_of_id_.find(pose.id);
    if (found == view_of_id_.end()) {
      return absl::NotFoundError(absl::StrCat("there is no view ", pose.id));
    }
    TL_ASSIGN_OR_RETURN(new_poses[found->second],
                        CheckedPose(pose.map_from_sensor));
  }
  OccupancyBlocks map(options_);
  std::optional<ColumnBox> changed;
  for (size_t i = 0; i < views_.size(); ++i) {
    TL_ASSIGN_OR_RETURN(const auto box, Fuse(views_[i].cloud, views_[i].kind,
                                             new_poses[i], map));
    changed = Union(changed, box);
  }
  if (map_.blocks() > 0) {
    const octree::VoxelIndex low = map_.lowest_block();
    const octree::VoxelIndex high = map_.end_block();
    changed = Union(changed, ColumnBox{.begin_x = low.x * kSide,
                                       .begin_y = low.y * kSide,
                                       .end_x = high.x * kSide,
                                       .end_y = high.y * kSide});
  }
  changed_ = Union(changed_, changed);
  map_ = std::move(map);
  for (size_t i = 0; i < views_.size(); ++i) {
    views_[i].pose.map_from_sensor = new_poses[i];
  }
  return absl::OkStatus();
}

absl::StatusOr<octree::VoxelMap> OctomapBuilder::Map(int alignment) const {
  if (alignment < 1 || alignment > 4096) {
    return absl::InvalidArgumentError(
        absl::StrCat("alignment is ", alignment, "; it must be 1..4096"));
  }
  const octree::VoxelIndex low = map_.lowest_block();
  const octree::VoxelIndex high = map_.end_block();
  const octree::VoxelIndex lowest{Below(low.x * kSide, alignment),
                                  Below(low.y * kSide, alignment),
                                  low.z * kSide};
  const octree::VoxelIndex end{-Below(-high.x * kSide, alignment),
                               -Below(-high.y * kSide, alignment),
                               high.z * kSide};
  TL_ASSIGN_OR_RETURN(
      octree::VoxelMap map,
      octree::VoxelMap::Make(
          options_.resolution_m, lowest,
          {end.x - lowest.x, end.y - lowest.y, end.z - lowest.z},
          options_.max_bytes));
  for (int x = low.x; x < high.x; ++x) {
    for (int y = low.y; y < high.y; ++y) {
      for (int z = low.z; z < high.z; ++z) {
        const OccupancyBlocks::Block* const block = map_.Find({x, y, z});
        if (block == nullptr) continue;
        for (int column = 0; column < kSide * kSide; ++column) {
          PaintColumn(
              *block, static_cast<size_t>(column), map_.occupied_log_odds(),
              {x * kSide + column / kSide - lowest.x,
               y * kSide + column % kSide - lowest.y, z * kSide - lowest.z},
              map);
        }
      }
    }
  }
  return map;
}

absl::StatusOr<std::string> OctomapBuilder::FormatOt() const {
  return octree::FormatLogOddsOt(
      options_.resolution_m, map_.lowest_block(), map_.end_block(),
      [this](octree::VoxelIndex index) -> std::optional<octree::LogOddsBlock> {
        const OccupancyBlocks::Block* const block = map_.Find(index);
        if (block == nullptr) return std::nullopt;
        return octree::LogOddsBlock{.log_odds = block->log_odds,
                                    .known = block->known};
      });
}

std::optional<ColumnBox> OctomapBuilder::TakeChangedColumns() {
  return std::exchange(changed_, std::nullopt);
}

FusionMemory OctomapBuilder::memory() const {
  return {
      .map = map_.blocks() * OccupancyBlocks::kBlockBytes,
      .clouds = cloud_bytes_,
      .working = grid_.bytes() + static_cast<int64_t>(places_.capacity() *
                                                      sizeof(geometry::Vec3))};
}

}  // namespace treeline::fusion
