#include "common/dataset/nvm.h"

#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::dataset {
namespace {

using ::testing::HasSubstr;

// The second camera stands at (1, 2, 3) and is turned by 180 degrees about x.
constexpr char kModel[] =
    "NVM_V3 \n"
    "\n"
    "2\n"
    "seq1/a.jpg\t800 1 0 0 0 0 0 0 0 0\n"
    "with\"space.jpg\t1670 0 1 0 0 1 2 3 -0.05 0\n"
    "\n"
    "2\n"
    "0.5 -1 4 200 100 0 2 0 17 10.5 -20 1 4 -3 7.25\n"
    "1 1 1 0 0 0 1 1 5 0 0\n"
    "\n"
    "0\n";

constexpr image::ImageSize kSizes[] = {{640, 480}, {1920, 1080}};

std::string ErrorWith(const char* from, const char* to) {
  const auto nvm = ParseNvm(absl::StrReplaceAll(kModel, {{from, to}}), "m.nvm");
  EXPECT_EQ(nvm.status().code(), absl::StatusCode::kInvalidArgument)
      << nvm.status();
  return std::string(nvm.status().message());
}

TEST(NvmTest, ReadsCamerasAndMeasurementsAboutTheImageCentre) {
  const auto nvm = ParseNvm(kModel, "m.nvm");
  ASSERT_TRUE(nvm.ok()) << nvm.status();
  const auto model = ToSfmModel(*nvm, kSizes, "m.nvm");
  ASSERT_TRUE(model.ok()) << model.status();
  ASSERT_EQ(model->images.size(), 2u);
  EXPECT_EQ(model->cameras[0].ToString(), "PINHOLE,800,800,319.5,239.5");
  EXPECT_EQ(model->images[1].name, "with space.jpg");
  const geometry::Rigid3 world_from_camera =
      model->images[1].camera_from_world.Inverse();
  EXPECT_NEAR(
      geometry::Norm(world_from_camera.translation - geometry::Vec3{1, 2, 3}),
      0, 1e-12);
  EXPECT_NEAR((world_from_camera.rotation * geometry::Vec3{0, 0, 1}).z, -1,
              1e-12);
  ASSERT_EQ(model->images[0].keypoints.size(), 1u);
  EXPECT_EQ(model->images[0].keypoints[0].pixel.x, 330);
  EXPECT_EQ(model->images[0].keypoints[0].pixel.y, 219.5);
  EXPECT_EQ(model->images[0].keypoints[0].point, 0);
  ASSERT_EQ(model->images[1].keypoints.size(), 2u);
  EXPECT_EQ(model->images[1].keypoints[1].point, 1);
  EXPECT_EQ(model->points[0].track_length, 2);
  EXPECT_EQ(model->points[0].position_in_world, (geometry::Vec3{0.5, -1, 4}));
}

TEST(NvmTest, RadialDistortionActsOnTheMeasurement) {
  const auto nvm = ParseNvm(kModel, "m.nvm");
  const auto model = ToSfmModel(*nvm, kSizes, "m.nvm");
  ASSERT_TRUE(model.ok()) << model.status();
  const camera::Camera& camera = model->cameras[1];
  for (const double x : {-959.5, -300.0, 0.0, 959.5}) {
    for (const double y : {-539.5, 100.0, 539.5}) {
      const auto ray = camera.Unproject({camera.cx() + x, camera.cy() + y});
      ASSERT_TRUE(ray.has_value());
      const double nx = x / 1670;
      const double ny = y / 1670;
      const double scale = 1 - 0.05 * (nx * nx + ny * ny);
      // A tenth of a pixel, which the header promises.
      EXPECT_NEAR(ray->x, nx * scale, 0.1 / 1670) << x << ", " << y;
      EXPECT_NEAR(ray->y, ny * scale, 0.1 / 1670) << x << ", " << y;
    }
  }
}

TEST(NvmTest, FixedKGivesEveryImageItsIntrinsics) {
  const auto nvm = ParseNvm(
      absl::StrReplaceAll(kModel, {{"NVM_V3 ", "NVM_V3 FixedK 700 300 710 250"},
                                   {"-0.05", "0"}}),
      "m.nvm");
  ASSERT_TRUE(nvm.ok()) << nvm.status();
  const auto model = ToSfmModel(*nvm, kSizes, "m.nvm");
  ASSERT_TRUE(model.ok()) << model.status();
  EXPECT_EQ(model->cameras[1].ToString(), "PINHOLE,700,710,299.5,249.5");
  EXPECT_EQ(model->images[0].keypoints[0].pixel.x, 310);
}

TEST(NvmTest, ErrorsNameTheLineAndWhatIsWrong) {
  EXPECT_THAT(ErrorWith("NVM_V3", "NVM_V2"), HasSubstr("m.nvm:1: "));
  EXPECT_THAT(ErrorWith("\n2\nseq1", "\n3\nseq1"), HasSubstr("m.nvm:7: "));
  EXPECT_THAT(ErrorWith("\n2\nseq1", "\n2000000000\nseq1"),
              HasSubstr("do not fit"));
  EXPECT_THAT(ErrorWith("\n2\nseq1", "\n-2\nseq1"), HasSubstr("'-2'"));
  EXPECT_THAT(ErrorWith("800 1 0", "0 1 0"), HasSubstr("not positive"));
  EXPECT_THAT(ErrorWith("800 1 0", "800 nan 0"), HasSubstr("finite"));
  EXPECT_THAT(ErrorWith("800 1 0", "800 3 0"), HasSubstr("norm"));
  EXPECT_THAT(ErrorWith("seq1/a.jpg", "../a.jpg"), HasSubstr("leads out"));
  EXPECT_THAT(ErrorWith("seq1/a.jpg", "with\"space.jpg"),
              HasSubstr("already in line 4"));
  EXPECT_THAT(ErrorWith("0 2 0 17", "0 2 9 17"), HasSubstr("no image 9"));
  EXPECT_THAT(ErrorWith("0 2 0 17", "0 3 0 17"), HasSubstr("3 measurements"));
  EXPECT_THAT(ErrorWith("10.5 -20", "10.5 inf"), HasSubstr("m.nvm:8"));
}

TEST(NvmTest, TruncatedFilesAreRefused) {
  const std::string whole(kModel);
  // After the last point there is nothing that has to follow.
  const size_t end = whole.find("1 5 0 0");
  for (size_t size = 0; size < end; ++size) {
    EXPECT_FALSE(ParseNvm(whole.substr(0, size), "m.nvm").ok()) << size;
  }
}

}  // namespace
}  // namespace treeline::dataset
