#include "common/wire/camera.h"

#include <limits>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::wire {
namespace {

using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::string MessageOf(const absl::Status& status) {
  return std::string(status.message());
}

camera::Camera MustParse(const char* text, int width, int height) {
  const auto camera = camera::Camera::Parse(text, width, height);
  EXPECT_TRUE(camera.ok()) << camera.status();
  return camera.value_or(camera::Camera());
}

class EveryModel : public testing::TestWithParam<const char*> {};

TEST_P(EveryModel, RoundTripsBitForBit) {
  const camera::Camera camera = MustParse(GetParam(), 641, 479);
  const v1::Camera proto = ToProto(camera);
  EXPECT_EQ(proto.model(),
            std::string(camera::CameraModelName(camera.model())));
  EXPECT_EQ(proto.parameters_size(),
            camera::CameraParameterCount(camera.model()));
  const auto back = FromProto(proto, "camera");
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(*back, camera);
}

INSTANTIATE_TEST_SUITE_P(
    Wire, EveryModel,
    testing::Values(
        "SIMPLE_PINHOLE,525.1,319.5,239.5", "PINHOLE,585.3,584.7,320.25,240.75",
        "SIMPLE_RADIAL,525,319.5,239.5,-0.1",
        "RADIAL,525,319.5,239.5,-0.1,0.01",
        "OPENCV,517.3,516.5,318.6,255.3,0.2624,-0.9531,-0.0054,0.0026",
        "FULL_OPENCV,517,516,318,255,0.26,-0.95,-0.005,0.002,1.1,0.1,0.2,0.3",
        "OPENCV_FISHEYE,380,380,320,240,-0.01,0.02,-0.003,0.0004",
        "FOV,380,380,320,240,0.9", "SIMPLE_RADIAL_FISHEYE,380,320,240,-0.01",
        "RADIAL_FISHEYE,380,320,240,-0.01,0.02",
        "THIN_PRISM_FISHEYE,380,380,320,240,-0.01,0.02,0.001,0.002,-0.003,"
        "0.0004,0.005,0.006"));

void ExpectRefused(const v1::Camera& bad, const char* why) {
  const auto result = FromProto(bad, "frame.camera");
  EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument) << why;
  EXPECT_THAT(MessageOf(result.status()), HasSubstr("frame.camera")) << why;
  // The message goes back to the client: it must stay readable.
  EXPECT_LT(result.status().message().size(), 400u) << why;
}

TEST(WireCamera, HostileValuesAreRefusedByName) {
  const v1::Camera good = ToProto(camera::Camera());
  ASSERT_TRUE(FromProto(good, "x").ok());
  const auto with = [&](auto change) {
    v1::Camera bad = good;
    change(bad);
    return bad;
  };
  ExpectRefused(v1::Camera(), "nothing set");
  ExpectRefused(with([](auto& c) { c.set_model("PINHOLLE"); }),
                "no such model");
  ExpectRefused(with([](auto& c) { c.set_model("PINHOLE\n"); }), "new line");
  ExpectRefused(with([](auto& c) { c.set_model(std::string(1 << 20, 'P')); }),
                "a megabyte of name");
  ExpectRefused(with([](auto& c) { c.set_parameters(0, kNan); }), "NaN");
  ExpectRefused(with([](auto& c) { c.set_parameters(2, kNan); }), "NaN centre");
  ExpectRefused(with([](auto& c) {
                  c.set_parameters(3, std::numeric_limits<double>::infinity());
                }),
                "infinity");
  ExpectRefused(with([](auto& c) { c.set_parameters(1, 0); }), "f = 0");
  ExpectRefused(with([](auto& c) { c.set_parameters(1, -585); }), "f < 0");
  ExpectRefused(with([](auto& c) { c.add_parameters(0); }), "one too many");
  ExpectRefused(with([](auto& c) { c.mutable_parameters()->RemoveLast(); }),
                "one too few");
  ExpectRefused(
      with([](auto& c) { c.mutable_parameters()->Resize(100'000, 1.0); }),
      "100,000 parameters");
  ExpectRefused(with([](auto& c) { c.set_width_px(-640); }), "width < 0");
  ExpectRefused(with([](auto& c) { c.set_height_px(0); }), "height 0");
  ExpectRefused(with([](auto& c) { c.set_width_px(2147483647); }),
                "width 2^31");
}

camera::RgbdCalibration SomeCalibration() {
  camera::RgbdCalibration calibration;
  calibration.color = MustParse("PINHOLE,525,526,319.5,239.5", 640, 480);
  calibration.depth = MustParse("SIMPLE_PINHOLE,290,160,120", 320, 240);
  calibration.color_from_depth = {
      geometry::Rotation3::FromAxisAngle({0.01, -0.02, 0.003}),
      {0.025, 0.001, -0.002}};
  calibration.depth_scale = 1.0123;
  calibration.pose_sensor = camera::RgbdSensor::kDepth;
  return calibration;
}

TEST(WireCamera, CalibrationsRoundTripBitForBit) {
  const camera::RgbdCalibration calibration = SomeCalibration();
  const auto back = FromProto(ToProto(calibration), "calibration");
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(*back, calibration);
}

TEST(WireCamera, CalibrationsNameTheFieldThatIsWrong) {
  const v1::RgbdCalibration good = ToProto(SomeCalibration());
  const auto message = [&](auto change) {
    v1::RgbdCalibration bad = good;
    change(bad);
    const auto result = FromProto(bad, "c");
    EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
    return MessageOf(result.status());
  };
  EXPECT_THAT(message([](auto& c) { c.mutable_color()->set_width_px(0); }),
              HasSubstr("c.color:"));
  EXPECT_THAT(message([](auto& c) { c.clear_depth(); }), HasSubstr("c.depth:"));
  EXPECT_THAT(message([](auto& c) { c.clear_color_from_depth(); }),
              HasSubstr("c.color_from_depth:"));
  EXPECT_THAT(message([](auto& c) { c.set_depth_scale(kNan); }),
              HasSubstr("c.depth_scale:"));
  EXPECT_THAT(message([](auto& c) { c.set_depth_scale(2.001); }),
              HasSubstr("c.depth_scale:"));
  EXPECT_THAT(
      message([](auto& c) { c.set_pose_sensor(v1::RGBD_SENSOR_UNSPECIFIED); }),
      HasSubstr("c.pose_sensor:"));
}

}  // namespace
}  // namespace treeline::wire
