// Traversable maps of synthetic buildings, scored against the truth: the long
// form of traversability_world_test. Figures: docs/research/traversability.md.
//
//   traversability_worlds MAP OUTPUT WORLD...
//     MAP     exact (all surfaces), noise (voxels missed and too many) or scan
//             (a depth camera's drive along the tour)
//     OUTPUT  a folder for maps and pictures of wrong cells; - for none
#include <cstdio>
#include <cstdlib>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "nav_agent/octomap/octree_file.h"
#include "nav_agent/traversability/level_files.h"
#include "nav_agent/traversability/testing_scene.h"
#include "tests/traversable_worlds/testing_world.h"

namespace treeline {
namespace {

constexpr traversability::VoxelNoise kNoise{
    .seed = 3, .dropped = 0.05, .near = 0.005, .far = 1e-4};

absl::StatusOr<octree::VoxelMap> MakeMap(const worlds::World& world,
                                         const std::string& kind) {
  if (kind == "scan") return ScanWorld(world, ScanOptions());
  if (kind == "exact") return VoxelizeWorld(world);
  if (kind == "noise")
    return traversability::WithNoise(VoxelizeWorld(world), kNoise);
  return absl::InvalidArgumentError("MAP is exact, noise or scan");
}

// The truth, with wrong cells orange and dangerous ones red.
image::ColorImage PictureOfVerdicts(const worlds::GroundTruth& truth,
                                    const WorldScore& score, int level) {
  image::ColorImage picture{
      .width = truth.width(), .height = truth.height(), .rgb = {}};
  for (int y = truth.height() - 1; y >= 0; --y) {
    for (int x = 0; x < truth.width(); ++x) {
      const worlds::GroundCell& cell = truth.at({level, x, y});
      const size_t i =
          static_cast<size_t>(y) * static_cast<size_t>(truth.width()) +
          static_cast<size_t>(x);
      const Verdict verdict = score.verdicts[static_cast<size_t>(level)][i];
      std::array<uint8_t, 3> color = {205, 205, 205};
      if (cell.state == worlds::GroundState::kFree) color = {255, 255, 255};
      if (cell.state == worlds::GroundState::kOccupied) color = {0, 0, 0};
      if (verdict == Verdict::kNotCounted &&
          cell.state != worlds::GroundState::kUnknown) {
        color = {120, 120, 255};
      }
      if (verdict == Verdict::kWrong) {
        color = cell.state == worlds::GroundState::kFree
                    ? std::array<uint8_t, 3>{255, 140, 0}
                    : std::array<uint8_t, 3>{200, 0, 255};
      }
      if (verdict == Verdict::kDanger) color = {255, 0, 0};
      picture.rgb.insert(picture.rgb.end(), color.begin(), color.end());
    }
  }
  return picture;
}

absl::Status ScoreOne(const std::string& name, const std::string& kind,
                      const std::string& output) {
  worlds::WorldOptions world_options;
  world_options.paint = false;
  world_options.threads = 1;
  TL_ASSIGN_OR_RETURN(const worlds::World world,
                      worlds::MakeWorld(name, world_options));
  const traversability::TraversabilityOptions options;
  TL_ASSIGN_OR_RETURN(const worlds::GroundTruth truth,
                      worlds::GroundTruth::Compute(
                          world, {.resolution_m = 0.05,
                                  .max_slope_rad = options.max_slope_rad,
                                  .max_step_m = options.max_step_m,
                                  .clearance_m = options.robot_height_m}));
  TL_ASSIGN_OR_RETURN(const octree::VoxelMap voxels, MakeMap(world, kind));
  TL_ASSIGN_OR_RETURN(const traversability::TraversableMap map,
                      traversability::ExtractTraversableMap(voxels, options));
  const WorldScore score = ScoreWorld(truth, voxels, map);
  std::printf(
      "%-12s levels %zu (true %zu) joins %zu cells %7lld right %.2f %% "
      "[free/occ %lld occ/free %lld unk/free %lld] stairs %lld edges %lld "
      "low %lld slope %.2f/%.2f ramp %.2f/%.2f deg room %.3f/%.3f m\n",
      name.c_str(), map.levels.size(), truth.levels().size(), map.joins.size(),
      static_cast<long long>(score.cells), 100 * score.RightShare(),
      static_cast<long long>(score.free_but_occupied),
      static_cast<long long>(score.occupied_but_free),
      static_cast<long long>(score.unknown_but_free),
      static_cast<long long>(score.free_stairs),
      static_cast<long long>(score.free_edges),
      static_cast<long long>(score.free_low_edges),
      Quantile(score.slope_errors_deg, 0.5),
      Quantile(score.slope_errors_deg, 0.95),
      Quantile(score.ramp_slope_errors_deg, 0.5),
      Quantile(score.ramp_slope_errors_deg, 0.95),
      Quantile(score.clearance_errors_m, 0.5),
      Quantile(score.clearance_errors_m, 0.95));
  if (output == "-") return absl::OkStatus();
  const std::string folder = absl::StrCat(
      output, "/", absl::StrReplaceAll(name, {{":", "-"}}), "-", kind);
  TL_RETURN_IF_ERROR(
      traversability::WriteTraversableMap(map, options.max_slope_rad, folder));
  TL_RETURN_IF_ERROR(octree::WriteOctree(voxels, folder + "/map.bt"));
  for (size_t level = 0; level < truth.levels().size(); ++level) {
    TL_ASSIGN_OR_RETURN(const std::string png,
                        image::EncodePng(PictureOfVerdicts(
                            truth, score, static_cast<int>(level))));
    TL_RETURN_IF_ERROR(base::WriteFileAtomically(
        absl::StrCat(folder, "/truth-", level, ".png"), png));
  }
  return absl::OkStatus();
}

}  // namespace
}  // namespace treeline

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: %s exact|noise|scan OUTPUT|- WORLD...\n",
                 argv[0]);
    return EXIT_FAILURE;
  }
  for (int i = 3; i < argc; ++i) {
    const absl::Status status = treeline::ScoreOne(argv[i], argv[1], argv[2]);
    if (!status.ok()) {
      std::fprintf(stderr, "%s: %s\n", argv[i], status.ToString().c_str());
      return EXIT_FAILURE;
    }
  }
  return EXIT_SUCCESS;
}
