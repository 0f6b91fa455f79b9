#include "nav_agent/service/map_pictures.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "common/image/decode.h"

namespace treeline::agent_service {
namespace {

void AppendU32(std::string& bytes, uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) {
    bytes.push_back(static_cast<char>((value >> shift) & 0xFF));
  }
}

void AppendFloat(std::string& bytes, double value) {
  AppendU32(bytes, std::bit_cast<uint32_t>(static_cast<float>(value)));
}

uint8_t ShadeOf(core::Occupancy occupancy) {
  switch (occupancy) {
    case core::Occupancy::kFree:
      return 255;
    case core::Occupancy::kOccupied:
      return 0;
    case core::Occupancy::kUnknown:
      break;
  }
  return 160;
}

bool IsEnclosed(const octree::VoxelMap& voxels, octree::VoxelIndex v) {
  constexpr std::array<octree::VoxelIndex, 6> kSteps = {
      {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};
  return std::all_of(
      kSteps.begin(), kSteps.end(), [&](const octree::VoxelIndex& step) {
        return voxels.At({v.x + step.x, v.y + step.y, v.z + step.z}) ==
               octree::Voxel::kOccupied;
      });
}

}  // namespace

absl::StatusOr<std::string> LevelPng(const core::OccupancyGrid& grid) {
  image::ColorImage image{
      .width = grid.width, .height = grid.height, .rgb = {}};
  image.rgb.reserve(grid.cells.size() * 3);
  for (int row = grid.height - 1; row >= 0; --row) {
    for (int x = 0; x < grid.width; ++x) {
      image.rgb.insert(image.rgb.end(), 3, ShadeOf(grid.At({x, row})));
    }
  }
  return image::EncodePng(image);
}

std::string LevelHeights(const traversability::TraversableLevel& level) {
  std::string bytes = "TLVH";
  bytes.reserve(12 + 4 * level.height_m.size());
  AppendU32(bytes, static_cast<uint32_t>(level.grid.width));
  AppendU32(bytes, static_cast<uint32_t>(level.grid.height));
  for (const float middle_m : level.height_m) {
    // The map has the middle of the highest voxel; the robot stands on its top.
    AppendFloat(bytes, std::isnan(middle_m)
                           ? std::numeric_limits<double>::quiet_NaN()
                           : middle_m + level.grid.resolution_m / 2);
  }
  return bytes;
}

std::string OctomapBytes(const octree::VoxelMap& voxels,
                         const geometry::Rigid2& map_from_voxels) {
  std::string points;
  uint32_t count = 0;
  const octree::VoxelIndex size = voxels.size();
  for (int x = 0; x < size.x; ++x) {
    for (int y = 0; y < size.y; ++y) {
      for (int z = 0; z < size.z; ++z) {
        const octree::VoxelIndex v{x, y, z};
        if (voxels.At(v) != octree::Voxel::kOccupied || IsEnclosed(voxels, v))
          continue;
        const geometry::Vec3 center = voxels.CenterOf(v);
        const geometry::Vec2 in_map =
            map_from_voxels * geometry::Vec2{center.x, center.y};
        AppendFloat(points, in_map.x);
        AppendFloat(points, in_map.y);
        AppendFloat(points, center.z);
        ++count;
      }
    }
  }
  std::string bytes = "TLVX";
  AppendU32(bytes, count);
  AppendFloat(bytes, voxels.resolution_m());
  bytes += points;
  return bytes;
}

geometry::Rigid2 MapFromVoxels(const octree::VoxelMap& voxels,
                               const traversability::TraversableMap& levels) {
  if (levels.levels.empty()) return {};
  const double r = voxels.resolution_m();
  return levels.levels[0].grid.map_from_grid *
         geometry::Rigid2{
             .translation = {-r * voxels.lowest().x, -r * voxels.lowest().y}};
}

}  // namespace treeline::agent_service
