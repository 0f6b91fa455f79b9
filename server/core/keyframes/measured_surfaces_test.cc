#include "server/core/keyframes/measured_surfaces.h"

#include "gtest/gtest.h"

namespace treeline::keyframes {
namespace {

constexpr geometry::Vec3 kFacing{0, 0, -1};

// A wall 2 m away; something 1 m away before the left half of it; nothing
// measured in the last columns.
class MeasuredSurfacesTest : public testing::Test {
 protected:
  MeasuredSurfacesTest() {
    calibration_.color = calibration_.depth =
        *camera::Camera::Parse("PINHOLE,50,50,32,24", 64, 48);
    depth_.width = 64;
    depth_.height = 48;
    depth_.unit_m = 0.001;
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 64; ++x) {
        depth_.values.push_back(x < 32 ? 1000 : (x < 60 ? 2000 : 0));
      }
    }
  }

  image::DepthImage depth_;
  camera::RgbdCalibration calibration_;
};

TEST_F(MeasuredSurfacesTest, SaysWhatIsMeasuredInThePixelOfAPoint) {
  const MeasuredSurfaces surfaces(depth_, calibration_);
  const auto point = surfaces.At({0.4, 0, 2});
  ASSERT_TRUE(point.has_value());
  EXPECT_NEAR(point->in_color.z, 2, 1e-9);
  EXPECT_NEAR(point->in_color.x, 0.4, 0.5 / 50 * 2);
  EXPECT_GT(point->sigma_m, 0);
}

TEST_F(MeasuredSurfacesTest, SaysNothingOutsideOrWithoutDepth) {
  const MeasuredSurfaces surfaces(depth_, calibration_);
  EXPECT_FALSE(surfaces.At({0, 0, -1}).has_value());
  EXPECT_FALSE(surfaces.At({9, 0, 2}).has_value());
  EXPECT_FALSE(surfaces.At({1.2, 0, 2}).has_value());  // column 62
  EXPECT_EQ(surfaces.SurfaceAt({1.2, 0, 2}, kFacing), Surface::kUnknown);
}

TEST_F(MeasuredSurfacesTest, TellsWhatLiesOnASurfaceFromWhatItHides) {
  const MeasuredSurfaces surfaces(depth_, calibration_);
  EXPECT_EQ(surfaces.SurfaceAt({0.4, 0, 2}, kFacing), Surface::kLying);
  EXPECT_EQ(surfaces.SurfaceAt({0.4, 0, 1.5}, kFacing), Surface::kElsewhere);
  EXPECT_EQ(surfaces.SurfaceAt({-0.4, 0, 2}, kFacing), Surface::kHidden);
  EXPECT_EQ(surfaces.SurfaceAt({0.5, 0, 2.5}, kFacing), Surface::kHidden);
  // A little behind: the surface is not where the point is, and hides nothing.
  EXPECT_EQ(surfaces.SurfaceAt({0.4, 0, 2.08}, kFacing), Surface::kElsewhere);
}

TEST_F(MeasuredSurfacesTest, WithoutANormalOnlyWhatIsHiddenIsKnown) {
  const MeasuredSurfaces surfaces(depth_, calibration_);
  EXPECT_EQ(surfaces.SurfaceAt({0.4, 0, 2}, {}), Surface::kUnknown);
  EXPECT_EQ(surfaces.SurfaceAt({-0.4, 0, 2}, {}), Surface::kHidden);
}

}  // namespace
}  // namespace treeline::keyframes
