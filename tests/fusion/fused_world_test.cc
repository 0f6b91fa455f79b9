// The short form of score_fusion: a few views of a world, with the noise of the
// depth camera, and the targets of the long one.
#include <cmath>
#include <vector>

#include "common/base/random.h"
#include "gtest/gtest.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/fusion/octomap_builder.h"
#include "simulation/renderer/renderer.h"
#include "simulation/sensors/synthetic_camera.h"
#include "tests/fusion/surface_truth.h"

namespace treeline {
namespace {

// The robot's camera along a world's tour: at each corner it looks about, three
// views of 58 degrees to each side of the way.
std::vector<geometry::Rigid3> CameraPoses(const worlds::World& world,
                                          size_t corners) {
  const geometry::Rigid3 base_from_camera = core::RobotModel().base_from_camera;
  std::vector<geometry::Rigid3> poses;
  for (size_t i = 0; i + 1 < world.tour.size() && i < corners; ++i) {
    const worlds::Float3 at = world.tour[i];
    const worlds::Float3 next = world.tour[i + 1];
    const double ahead_rad =
        std::atan2(double{next.y - at.y}, double{next.x - at.x});
    for (const double turn_rad : {-0.7, 0.0, 0.7}) {
      const geometry::Rigid3 world_from_base{
          .rotation =
              geometry::Rotation3::FromAxisAngle({0, 0, ahead_rad + turn_rad}),
          .translation = {double{at.x}, double{at.y}, double{at.z}}};
      poses.push_back(world_from_base * base_from_camera);
    }
  }
  return poses;
}

FusionScore ScoreWorld(const char* name, double noise_m, double noise_rad) {
  const camera::Camera camera =
      *camera::Camera::Parse("SIMPLE_PINHOLE,292.5,159.5,119.5", 320, 240);
  const auto renderer = *renderer::Renderer::CreateUnlit(
      *worlds::MakeWorld(name, {.with_people = false, .paint = false}));
  const renderer::PixelRays rays(camera);
  fusion::OctomapBuilder builder = *fusion::OctomapBuilder::Make();
  SurfaceTruth truth = *SurfaceTruth::Make(renderer->world(), 0.05);
  const std::vector<geometry::Rigid3> poses = CameraPoses(renderer->world(), 8);
  for (size_t i = 0; i < poses.size(); ++i) {
    const image::DepthImage depth = sensors::MeasureDepth(
        rays, renderer->RenderDepth(rays, poses[i], 1), {},
        /*seed=*/1, i, /*threads=*/1);
    truth.Observe(depth, camera, poses[i], builder.options().max_depth_m, 2);
    base::Random random(2, i);
    const auto draw = [&random] {
      return geometry::Vec3{random.NextGaussian(), random.NextGaussian(),
                            random.NextGaussian()};
    };
    const geometry::Rigid3 estimated{
        .rotation = geometry::Rotation3::FromAxisAngle(noise_rad * draw()) *
                    poses[i].rotation,
        .translation = poses[i].translation + noise_m * draw()};
    EXPECT_TRUE(
        builder.InsertDepth(static_cast<int64_t>(i), depth, camera, estimated)
            .ok());
  }
  return truth.Score(*builder.Map());
}

TEST(FusedWorld, TruePosesGiveTheSurfacesThatWereObserved) {
  const FusionScore score = ScoreWorld("cafe", 0, 0);
  EXPECT_GT(score.observed, 10000);
  EXPECT_GE(score.precision(), 0.95);
  EXPECT_GE(score.recall(), 0.90);
  EXPECT_GE(score.ground_recall(), 0.90);
}

// As good as poses of SLAM are: 2.5 cm and 0.3 degrees, each view for itself.
TEST(FusedWorld, PosesWithErrorsGiveThemToo) {
  const FusionScore score = ScoreWorld("lab", 0.015, 0.003);
  EXPECT_GT(score.observed, 10000);
  EXPECT_GE(score.precision(), 0.95);
  EXPECT_GE(score.recall(), 0.90);
}

}  // namespace
}  // namespace treeline
