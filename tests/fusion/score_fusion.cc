// score_fusion --world cafe --log cafe.tlog: fuses the depth views of a log
// into an OctoMap and scores it against the world's surfaces.
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "common/base/file.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "common/dataset/text_formats.h"
#include "nav_agent/fusion/octomap_builder.h"
#include "nav_agent/octomap/octree_file.h"
#include "tests/fusion/fusion_log.h"
#include "tests/fusion/surface_truth.h"

namespace treeline {
namespace {

struct Flags {
  std::string world;
  std::string log;
  std::string poses;
  std::string output;
  std::string wrong;
  int every = 1;
  int truth_step = 2;
  double noise_m = 0;
  double noise_rad = 0;
  fusion::FusionOptions fusion;
};

double ProcessorSeconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

// Estimated poses in the frame of the truth: both begin at the same pose.
absl::StatusOr<std::vector<StampedPose>> ReadEstimate(
    const std::string& path, const std::vector<StampedPose>& truth) {
  TL_ASSIGN_OR_RETURN(const std::string text, base::ReadFile(path));
  TL_ASSIGN_OR_RETURN(const std::vector<dataset::TimedPose> timed,
                      dataset::ParseTimedPoses(text, path));
  if (timed.empty()) return absl::NotFoundError(path + " holds no poses");
  std::vector<StampedPose> poses;
  const auto stamp_of = [](const dataset::TimedPose& pose) {
    return base::MonotonicTime(std::chrono::nanoseconds(pose.time));
  };
  const geometry::Rigid3 world_from_map =
      PoseAt(truth, stamp_of(timed.front())) *
      timed.front().world_from_camera.Inverse();
  poses.reserve(timed.size());
  for (const dataset::TimedPose& pose : timed) {
    poses.push_back({stamp_of(pose), world_from_map * pose.world_from_camera});
  }
  return poses;
}

// White noise on a pose.
geometry::Rigid3 Disturbed(const geometry::Rigid3& pose, const Flags& flags,
                           uint64_t index) {
  if (flags.noise_m == 0 && flags.noise_rad == 0) return pose;
  base::Random random(1, index);
  const auto draw = [&random] {
    return geometry::Vec3{random.NextGaussian(), random.NextGaussian(),
                          random.NextGaussian()};
  };
  const geometry::Vec3 turn = flags.noise_rad * draw();
  return {.rotation = geometry::Rotation3::FromAxisAngle(turn) * pose.rotation,
          .translation = pose.translation + flags.noise_m * draw()};
}

// "x y z" of each wrong voxel's middle (m).
absl::Status WriteWrong(const octree::VoxelMap& map, const SurfaceTruth& truth,
                        const std::string& path) {
  std::string text;
  for (int x = 0; x < map.size().x; ++x) {
    for (int y = 0; y < map.size().y; ++y) {
      for (int z = 0; z < map.size().z; ++z) {
        if (map.At({x, y, z}) != octree::Voxel::kOccupied ||
            truth.IsNearSurface(
                {x + map.lowest().x, y + map.lowest().y, z + map.lowest().z})) {
          continue;
        }
        const geometry::Vec3 center = map.CenterOf({x, y, z});
        text += absl::StrCat(center.x, " ", center.y, " ", center.z, "\n");
      }
    }
  }
  return base::WriteFileAtomically(path, text);
}

absl::Status Run(const Flags& flags) {
  TL_ASSIGN_OR_RETURN(
      const worlds::World world,
      worlds::MakeWorld(flags.world, {.with_people = false, .paint = false}));
  TL_ASSIGN_OR_RETURN(const std::vector<StampedPose> true_poses,
                      ReadTruePoses(flags.log));
  std::vector<StampedPose> poses = true_poses;
  if (!flags.poses.empty()) {
    TL_ASSIGN_OR_RETURN(poses, ReadEstimate(flags.poses, true_poses));
  }
  TL_ASSIGN_OR_RETURN(SurfaceTruth truth,
                      SurfaceTruth::Make(world, flags.fusion.resolution_m));
  TL_ASSIGN_OR_RETURN(fusion::OctomapBuilder builder,
                      fusion::OctomapBuilder::Make(flags.fusion));
  double fusion_s = 0;
  const auto add = [&](const LoggedView& view) {
    truth.Observe(view.depth, view.camera,
                  PoseAt(true_poses, view.stamp) * view.base_from_camera,
                  flags.fusion.max_depth_m, flags.truth_step);
    const geometry::Rigid3 map_from_camera =
        Disturbed(PoseAt(poses, view.stamp) * view.base_from_camera, flags,
                  static_cast<uint64_t>(builder.views()));
    const double begin_s = ProcessorSeconds();
    const absl::Status status = builder.InsertDepth(
        builder.views(), view.depth, view.camera, map_from_camera);
    fusion_s += ProcessorSeconds() - begin_s;
    return status;
  };
  TL_RETURN_IF_ERROR(ForEachView(flags.log, flags.every, add));
  const double begin_s = ProcessorSeconds();
  TL_ASSIGN_OR_RETURN(const octree::VoxelMap map, builder.Map());
  const double map_s = ProcessorSeconds() - begin_s;
  const FusionScore score = truth.Score(map);
  std::printf("%s: precision %.4f, recall %.4f, of ground in its column %.4f\n",
              flags.world.c_str(), score.precision(), score.recall(),
              score.ground_recall());
  std::printf("  occupied %lld, observed %lld, free %lld\n",
              static_cast<long long>(score.occupied),
              static_cast<long long>(score.observed),
              static_cast<long long>(map.CountFree()));
  const fusion::FusionMemory memory = builder.memory();
  std::printf(
      "  %lld views, %.2f ms each; map %.1f MB, clouds %.1f MB, working %.1f "
      "MB; Map() %.1f ms\n",
      static_cast<long long>(builder.views()),
      1e3 * fusion_s / static_cast<double>(builder.views()),
      static_cast<double>(memory.map) / 1e6,
      static_cast<double>(memory.clouds) / 1e6,
      static_cast<double>(memory.working) / 1e6, 1e3 * map_s);
  if (!flags.wrong.empty()) {
    TL_RETURN_IF_ERROR(WriteWrong(map, truth, flags.wrong));
  }
  return flags.output.empty() ? absl::OkStatus()
                              : octree::WriteOctree(map, flags.output);
}

void AddOptions(CLI::App& app, Flags& flags) {
  app.add_option("--world", flags.world, "The world the log is of")->required();
  app.add_option("--log", flags.log, "An agent log with true poses")
      ->required();
  app.add_option("--poses", flags.poses,
                 "Fuse with these poses of the base (TUM), not the true ones");
  app.add_option("--output", flags.output,
                 "Where to write the map, .bt or .ot");
  app.add_option("--wrong", flags.wrong, "Where to write the wrong voxels");
  app.add_option("--every", flags.every, "Use one frame of so many");
  app.add_option("--truth-step", flags.truth_step,
                 "Pixels from one ray of the truth to the next");
  app.add_option("--noise-m", flags.noise_m, "Disturbs the poses");
  app.add_option("--noise-rad", flags.noise_rad, "Disturbs the poses");
  fusion::FusionOptions& fusion = flags.fusion;
  app.add_option("--resolution", fusion.resolution_m);
  app.add_option("--max-depth", fusion.max_depth_m);
  app.add_option("--threshold", fusion.occupied_threshold);
  app.add_option("--hit", fusion.hit_probability);
  app.add_option("--miss", fusion.miss_probability);
  app.add_option("--pixel-step", fusion.pixel_step);
  app.add_option("--outlier-neighbors", fusion.outlier_neighbors);
  app.add_option("--outlier-deviations", fusion.outlier_deviations);
}

}  // namespace
}  // namespace treeline

int main(int argc, char** argv) {
  CLI::App app("Fuses a simulated log and scores the map");
  treeline::Flags flags;
  treeline::AddOptions(app, flags);
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = treeline::Run(flags);
  if (status.ok()) return 0;
  std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return 1;
}
