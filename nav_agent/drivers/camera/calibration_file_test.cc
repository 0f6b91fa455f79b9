#include "nav_agent/drivers/camera/calibration_file.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::camera_driver {
namespace {

using ::testing::HasSubstr;

TEST(CalibrationFile, EverythingIsRead) {
  const auto calibration = ParseCalibration(
      "width: 640\n"
      "height: 480\n"
      "color: PINHOLE,525,526,319.5,239.5\n"
      "depth: SIMPLE_PINHOLE,575,320,240\n"
      "color_from_depth:\n"
      "  translation_m: [-0.025, 0.001, 0]\n"
      "  rotation_wxyz: [0, 0, 0, 1]\n"
      "depth_scale: 1.01\n",
      "xtion.yaml");
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  EXPECT_EQ(calibration->color.ToString(), "PINHOLE,525,526,319.5,239.5");
  EXPECT_EQ(calibration->depth.ToString(), "SIMPLE_PINHOLE,575,320,240");
  EXPECT_EQ(calibration->color_from_depth.translation.x, -0.025);
  EXPECT_EQ(calibration->color_from_depth.rotation.z, 1);
  EXPECT_EQ(calibration->depth_scale, 1.01);
}

TEST(CalibrationFile, WithoutDepthItIsRegistered) {
  const auto calibration = ParseCalibration(
      "width: 320\nheight: 240\ncolor: PINHOLE,262,262,160,120\n", "x.yaml");
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  EXPECT_EQ(calibration->depth, calibration->color);
  EXPECT_EQ(calibration->color_from_depth, geometry::Rigid3{});
}

TEST(CalibrationFile, ErrorsSayWhere) {
  const struct {
    const char* text;
    const char* error;
  } cases[] = {
      {"width: 640\nheight: 480\n", "color"},
      {"width: 0\nheight: 480\ncolor: PINHOLE,1,1,1,1\n", "x.yaml:1"},
      {"width: 640\nheight: 480\ncolor: PINHOLE,525\n", "x.yaml:3"},
      {"width: 640\nheight: 480\ncolour: PINHOLE,525\n",
       "did you mean 'color'"},
      {"width: 640\nheight: 480\ncolor: PINHOLE,525,525,320,240\n"
       "color_from_depth:\n  translation_m: [0, 0, 0]\n"
       "  rotation_wxyz: [1, 1, 0, 0]\n",
       "x.yaml:"},
      {"width: 640\nheight: 480\ncolor: PINHOLE,525,525,320,240\n"
       "depth_scale: 3\n",
       "x.yaml:4"},
  };
  for (const auto& [text, error] : cases) {
    const auto calibration = ParseCalibration(text, "x.yaml");
    EXPECT_EQ(calibration.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(calibration.status().message()), HasSubstr(error));
  }
  EXPECT_EQ(ReadCalibration("/no/such.yaml").status().code(),
            absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace treeline::camera_driver
