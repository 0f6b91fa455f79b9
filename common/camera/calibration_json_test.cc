#include "common/camera/calibration_json.h"

#include <string>

#include "gtest/gtest.h"

namespace treeline::camera {
namespace {

TEST(CalibrationJsonTest, RoundTrips) {
  RgbdCalibration calibration;
  calibration.depth =
      *Camera::Parse("OPENCV,586,586,300,220,-0.05,0,0,0", 640, 480);
  calibration.color_from_depth = {
      geometry::Rotation3::FromAxisAngle({0.1, 0.2, -0.3}), {0.1, -0.2, 0.3}};
  calibration.depth_scale = 1.0123;
  const auto read = CalibrationFromJson(CalibrationToJson(calibration));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->depth, calibration.depth);
  EXPECT_EQ(read->depth_scale, calibration.depth_scale);
  EXPECT_LT(geometry::AngleBetween_rad(read->color_from_depth.rotation,
                                       calibration.color_from_depth.rotation),
            1e-15);
}

TEST(CalibrationJsonTest, RefusesNonsense) {
  const std::string good = CalibrationToJson(RgbdCalibration{});
  const auto with = [&](absl::string_view from, absl::string_view to) {
    std::string text = good;
    const size_t at = text.find(std::string(from));
    EXPECT_NE(at, std::string::npos) << from;
    return CalibrationFromJson(text.replace(at, from.size(), std::string(to)))
        .status()
        .code();
  };
  constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
  EXPECT_EQ(with("\"depth_scale\": 1.0", "\"depth_scale\": 3"), kInvalid);
  EXPECT_EQ(with("\"depth_scale\": 1.0", "\"depth_scale\": \"1\""), kInvalid);
  EXPECT_EQ(with("\"qw\": 1.0", "\"qw\": 0.5"), kInvalid);
  EXPECT_EQ(with("PINHOLE", "PINHOLES"), kInvalid);
  EXPECT_EQ(with("\"pose_sensor\": \"color\"", "\"pose_sensor\": \"nose\""),
            kInvalid);
  EXPECT_EQ(CalibrationFromJson("").status().code(), kInvalid);
}

}  // namespace
}  // namespace treeline::camera
