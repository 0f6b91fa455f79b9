#include "tests/fusion/surface_truth.h"

#include <cmath>
#include <utility>
#include <vector>

#include "common/base/status_macros.h"

namespace treeline {
namespace {

// Room around the world, and how far beyond the range noise reaches.
constexpr double kMargin_m = 1;
constexpr double kBeyond_m = 0.3;

worlds::Float3 ToFloat3(geometry::Vec3 v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y),
          static_cast<float>(v.z)};
}

// Whether a voxel within one of `v` is occupied; v is numbered as in `map`.
bool HasOccupiedNear(const octree::VoxelMap& map, octree::VoxelIndex v) {
  for (int dx = -1; dx <= 1; ++dx) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dz = -1; dz <= 1; ++dz) {
        if (map.At({v.x + dx, v.y + dy, v.z + dz}) ==
            octree::Voxel::kOccupied) {
          return true;
        }
      }
    }
  }
  return false;
}

bool HasOccupiedInColumn(const octree::VoxelMap& map, octree::VoxelIndex v) {
  return map.At({v.x, v.y, v.z - 1}) == octree::Voxel::kOccupied ||
         map.At(v) == octree::Voxel::kOccupied ||
         map.At({v.x, v.y, v.z + 1}) == octree::Voxel::kOccupied;
}

// How many occupied voxels `map` has, and how many of them `other` has too,
// within one voxel.
struct Matches {
  int64_t all = 0;
  int64_t near = 0;
  int64_t in_column = 0;
};
Matches CountMatches(const octree::VoxelMap& map,
                     const octree::VoxelMap& other) {
  Matches matches;
  const octree::VoxelIndex shift{map.lowest().x - other.lowest().x,
                                 map.lowest().y - other.lowest().y,
                                 map.lowest().z - other.lowest().z};
  for (int y = 0; y < map.size().y; ++y) {
    for (int x = 0; x < map.size().x; ++x) {
      for (int z = 0; z < map.size().z; ++z) {
        if (map.At({x, y, z}) != octree::Voxel::kOccupied) continue;
        ++matches.all;
        const octree::VoxelIndex v{x + shift.x, y + shift.y, z + shift.z};
        if (HasOccupiedNear(other, v)) ++matches.near;
        if (HasOccupiedInColumn(other, v)) ++matches.in_column;
      }
    }
  }
  return matches;
}

}  // namespace

absl::StatusOr<SurfaceTruth> SurfaceTruth::Make(const worlds::World& world,
                                                double resolution_m) {
  TL_ASSIGN_OR_RETURN(renderer::RayCaster caster,
                      renderer::RayCaster::Create(world));
  const auto voxels = [resolution_m](double length_m) {
    return static_cast<int>(std::ceil(length_m / resolution_m));
  };
  const int margin = voxels(kMargin_m);
  TL_ASSIGN_OR_RETURN(
      octree::VoxelMap surface,
      octree::VoxelMap::Make(resolution_m, {-margin, -margin, -margin},
                             {voxels(double{world.size_m.x}) + 2 * margin,
                              voxels(double{world.size_m.y}) + 2 * margin,
                              voxels(double{world.size_m.z}) + 2 * margin}));
  return SurfaceTruth(world, std::move(caster), std::move(surface));
}

void SurfaceTruth::Observe(const image::DepthImage& measured,
                           const camera::Camera& camera,
                           const geometry::Rigid3& world_from_camera,
                           double max_depth_m, int pixel_step) {
  std::vector<worlds::Float3> directions;
  std::vector<double> depths_m;
  for (int y = 0; y < measured.height; y += pixel_step) {
    for (int x = 0; x < measured.width; x += pixel_step) {
      const uint16_t value =
          measured.values[static_cast<size_t>(y * measured.width + x)];
      if (!image::IsMeasured(value)) continue;
      const auto ray = camera.Unproject({double(x), double(y)});
      if (!ray) continue;
      // One long along the axis: hits are at their depth.
      directions.push_back(ToFloat3(world_from_camera.rotation *
                                    geometry::Vec3{ray->x, ray->y, 1}));
      depths_m.push_back(value * measured.unit_m);
    }
  }
  std::vector<renderer::RayHit> hits(directions.size());
  const worlds::Float3 origin = ToFloat3(world_from_camera.translation);
  caster_.CastMany(origin, directions, hits);
  for (size_t i = 0; i < hits.size(); ++i) {
    if (hits[i].surface == renderer::RayHit::kNothing) continue;
    const double z_m = double{hits[i].distance};
    if (z_m > max_depth_m + kBeyond_m ||
        std::abs(z_m - depths_m[i]) > 0.1 + 0.02 * z_m * z_m) {
      continue;
    }
    const worlds::Surface& hit = world_->surfaces[hits[i].surface];
    const worlds::Float3 point = hit.PointAt(hits[i].u, hits[i].v);
    const octree::VoxelIndex v =
        surface_.IndexOf({double{point.x}, double{point.y}, double{point.z}});
    if (!surface_.Contains(v)) continue;
    surface_.Set(v, octree::Voxel::kOccupied);
    if (z_m > max_depth_m) continue;
    observed_.Set(v, octree::Voxel::kOccupied);
    if (std::abs(hit.Normal().z) > 0.7F)
      ground_.Set(v, octree::Voxel::kOccupied);
  }
}

FusionScore SurfaceTruth::Score(const octree::VoxelMap& map) const {
  const Matches precision = CountMatches(map, surface_);
  const Matches recall = CountMatches(observed_, map);
  const Matches ground = CountMatches(ground_, map);
  return {.occupied = precision.all,
          .right = precision.near,
          .observed = recall.all,
          .found = recall.near,
          .observed_ground = ground.all,
          .found_ground = ground.in_column};
}

bool SurfaceTruth::IsNearSurface(octree::VoxelIndex voxel) const {
  const octree::VoxelIndex lowest = surface_.lowest();
  return HasOccupiedNear(
      surface_, {voxel.x - lowest.x, voxel.y - lowest.y, voxel.z - lowest.z});
}

}  // namespace treeline
