#include "server/core/localizer/assumed_lens.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/base/random.h"

namespace treeline::localizer {
namespace {

constexpr double kFocal_px = 500;

// Points before a camera at the origin that takes 640 x 480 pixels, in a
// share of its view, and their rays by the camera that is assumed.
pose::RayPredictions Seen(const camera::Camera& camera,
                          const camera::Camera& assumed, int points,
                          double share) {
  base::Random random(7, 1);
  pose::RayPredictions scene;
  for (int i = 0; i < points; ++i) {
    const double z = random.NextUniform(1, 4);
    const geometry::Vec3 point{z * share * random.NextUniform(-0.6, 0.6),
                               z * share * random.NextUniform(-0.45, 0.45), z};
    camera::Pixel pixel = camera.Project(point);
    pixel.x += random.NextGaussian();
    pixel.y += random.NextGaussian();
    const std::optional<camera::Pixel> ray = assumed.Unproject(pixel);
    if (!ray) continue;
    scene.ray.push_back(*ray);
    scene.ray_sigma.push_back(1 / kFocal_px);
    scene.predictions.push_back({point, {1e-6, 0, 0, 1e-6, 0, 1e-6}});
  }
  return scene;
}

camera::Camera Parse(const char* text) {
  return *camera::Camera::Parse(text, 640, 480);
}

// The pose that fits best where the principal point is taken for another: the
// camera turned.
geometry::Rigid3 PoseBy(const camera::Camera& camera,
                        const camera::Camera& assumed) {
  const double x = (camera.cx() - assumed.cx()) / kFocal_px;
  const double y = (camera.cy() - assumed.cy()) / kFocal_px;
  return {geometry::Rotation3::FromAxisAngle({y, -x, 0}), {}};
}

class AssumedLensTest : public testing::Test {
 protected:
  std::optional<AssumedLens> Find(const char* true_camera, int points = 250,
                                  double share = 1) {
    const camera::Camera camera = Parse(true_camera);
    return FindAssumedLens(Seen(camera, assumed_, points, share),
                           PoseBy(camera, assumed_), 3 / kFocal_px, assumed_,
                           min_odds_);
  }
  // The camera that is found in two rounds.
  camera::Camera Corrected(const char* true_camera) {
    for (int round = 0; round < 2; ++round) {
      const auto lens = Find(true_camera);
      EXPECT_TRUE(lens.has_value()) << true_camera;
      if (!lens) break;
      EXPECT_EQ(lens->is_as_assumed, round == 1) << true_camera;
      if (round == 0) assumed_ = *WithLens(assumed_, lens->found);
    }
    return assumed_;
  }

  double min_odds_ = 30;
  camera::Camera assumed_ = Parse("SIMPLE_PINHOLE,500,319.5,239.5");
};

TEST_F(AssumedLensTest, AWholePictureOfAnOrdinaryLensIsLeftAlone) {
  for (const char* ordinary :
       {"SIMPLE_PINHOLE,500,319.5,239.5", "SIMPLE_PINHOLE,500,324,235",
        "SIMPLE_RADIAL,500,319.5,239.5,0.01"}) {
    EXPECT_TRUE(Find(ordinary)->is_as_assumed) << ordinary;
  }
}

TEST_F(AssumedLensTest, AsAssumedItAddsLessToAPoseThanAnyLensDoes) {
  const auto usual = Find("SIMPLE_PINHOLE,500,319.5,239.5");
  min_odds_ = 1e9;
  const auto any = Find("SIMPLE_PINHOLE,500,319.5,239.5");
  ASSERT_TRUE(usual->is_as_assumed && !any->is_as_assumed);
  for (const size_t axis : {0U, 7U, 14U}) {
    EXPECT_GT(usual->found.added[axis], 0) << axis;
    EXPECT_LT(usual->found.added[axis], any->found.added[axis]) << axis;
  }
}

TEST_F(AssumedLensTest, AWindowsPrincipalPointIsFound) {
  const camera::Camera found = Corrected("SIMPLE_PINHOLE,500,250,280");
  EXPECT_NEAR(found.cx(), 250, 25);
  EXPECT_NEAR(found.cy(), 280, 25);
  // What need not be otherwise is not.
  EXPECT_LT(std::abs(found.parameters()[3]), 0.02);
}

TEST_F(AssumedLensTest, BentLinesAreStraightened) {
  const camera::Camera found = Corrected("SIMPLE_RADIAL,500,319.5,239.5,-0.15");
  EXPECT_NEAR(found.parameters()[3], -0.15, 0.03);
  EXPECT_NEAR(found.cx(), 319.5, 8);
}

TEST_F(AssumedLensTest, BothAtOnce) {
  const camera::Camera found = Corrected("SIMPLE_RADIAL,500,250,280,-0.15");
  EXPECT_NEAR(found.parameters()[3], -0.15, 0.04);
  EXPECT_NEAR(found.cx(), 250, 25);
}

TEST_F(AssumedLensTest, TheLensOfTheScenesCameraCounts) {
  assumed_ = Parse("RADIAL,500,319.5,239.5,-0.1,0.02");
  EXPECT_TRUE(Find("RADIAL,500,319.5,239.5,-0.1,0.02")->is_as_assumed);
  const auto straight = Find("SIMPLE_PINHOLE,500,319.5,239.5");
  ASSERT_TRUE(straight.has_value());
  EXPECT_FALSE(straight->is_as_assumed);
  EXPECT_NEAR(WithLens(assumed_, straight->found)->parameters()[3], 0, 0.04);
}

TEST_F(AssumedLensTest, FeaturesInAPartOfThePictureDoNotSayThatItIsWhole) {
  const auto few = Find("SIMPLE_PINHOLE,500,319.5,239.5", 40, 0.15);
  EXPECT_TRUE(!few || !few->is_as_assumed);
  // Nor that it is not.
  min_odds_ = 0.03;
  EXPECT_TRUE(Find("SIMPLE_PINHOLE,500,319.5,239.5", 40, 0.15)->is_as_assumed);
  EXPECT_FALSE(Find("SIMPLE_PINHOLE,500,250,280")->is_as_assumed);
  EXPECT_FALSE(Find("SIMPLE_PINHOLE,500,319.5,239.5", 3).has_value());
}

TEST_F(AssumedLensTest, AFisheyeIsNotStraightened) {
  pose::LensEstimate bent;
  bent.radial = 0.1;
  EXPECT_FALSE(
      WithLens(Parse("SIMPLE_RADIAL_FISHEYE,500,320,240,0.1"), bent).ok());
}

}  // namespace
}  // namespace treeline::localizer
