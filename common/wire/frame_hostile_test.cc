// Frames that are not good: each is refused, and the message names the field.
#include <limits>
#include <string>

#include "common/wire/camera.h"
#include "common/wire/frame.h"
#include "common/wire/geometry.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::wire {
namespace {

using ::testing::StartsWith;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kWidth = 40;
constexpr int kHeight = 30;

camera::Camera SmallCamera() {
  const double parameters[] = {35, 20, 15};
  return camera::Camera::Create(camera::CameraModel::kSimplePinhole, kWidth,
                                kHeight, parameters, 3)
      .value();
}

camera::RgbdCalibration SceneCalibration() {
  return {.color = SmallCamera(),
          .depth = SmallCamera(),
          .color_from_depth = geometry::Rigid3{}};
}

image::ColorImage SomeColor() {
  image::ColorImage image{.width = kWidth, .height = kHeight, .rgb = {}};
  image.rgb.assign(kWidth * kHeight * 3, 90);
  return image;
}

image::DepthImage SomeDepth() {
  image::DepthImage image{.width = kWidth, .height = kHeight, .values = {}};
  image.values.assign(kWidth * kHeight, 1500);
  return image;
}

// Everything stated, everything valid.
v1::Frame GoodFrame() {
  QueryFrame query{.color = SomeColor(), .camera = SmallCamera()};
  query.depth = QueryDepth{
      .image = SomeDepth(),
      .registration = DepthRegistration::kExplicit,
      .geometry = QueryDepth::Geometry{SmallCamera(), geometry::Rigid3{}}};
  return ToProto(query);
}

absl::StatusOr<image::Frame> Decode(const v1::Frame& proto,
                                    const image::DecodeLimits& limits = {}) {
  return FromProto(proto, SceneCalibration(), limits, "frame");
}

template <typename Change>
void ExpectRefused(const char* field, Change change,
                   const image::DecodeLimits& limits = {}) {
  v1::Frame bad = GoodFrame();
  change(bad);
  const auto result = Decode(bad, limits);
  ASSERT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument)
      << field << ": " << result.status();
  EXPECT_THAT(std::string(result.status().message()),
              StartsWith(std::string(field) + ":"));
}

TEST(HostileFrame, TheGoodOneIsAccepted) {
  const auto frame = Decode(GoodFrame());
  EXPECT_TRUE(frame.ok()) << frame.status();
}

TEST(HostileFrame, NothingAtAll) {
  EXPECT_EQ(Decode(v1::Frame()).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(HostileFrame, NoColor) {
  ExpectRefused("frame.color", [](auto& f) { f.clear_color(); });
  ExpectRefused("frame.color.encoded",
                [](auto& f) { f.mutable_color()->set_encoded(""); });
}

TEST(HostileFrame, ColorThatIsNoImage) {
  ExpectRefused("frame.color.encoded", [](auto& f) {
    f.mutable_color()->set_encoded("GIF89a, which nobody asked for");
  });
  const std::string jpeg = image::EncodeJpeg(SomeColor(), 90).value();
  ExpectRefused("frame.color.encoded", [&](auto& f) {
    f.mutable_color()->set_encoded(jpeg.substr(0, jpeg.size() / 2));
  });
  const std::string png = image::EncodePng(SomeColor()).value();
  ExpectRefused("frame.color.encoded", [&](auto& f) {
    f.mutable_color()->set_encoded(png.substr(0, png.size() / 2));
  });
}

TEST(HostileFrame, RawColorWithAnotherNumberOfBytes) {
  ExpectRefused("frame.color.rgb8.data", [](auto& f) {
    f.mutable_color()->mutable_rgb8()->mutable_data()->pop_back();
  });
  ExpectRefused("frame.color.rgb8.data", [](auto& f) {
    f.mutable_color()->mutable_rgb8()->mutable_data()->push_back(0);
  });
  ExpectRefused("frame.color.rgb8.data", [](auto& f) {
    f.mutable_color()->mutable_rgb8()->clear_data();
  });
}

TEST(HostileFrame, RawColorWithAbsurdSizes) {
  const auto with_size = [](int32_t width, int32_t height) {
    return [=](v1::Frame& f) {
      f.mutable_color()->mutable_rgb8()->set_width_px(width);
      f.mutable_color()->mutable_rgb8()->set_height_px(height);
    };
  };
  ExpectRefused("frame.color.rgb8", with_size(0, kHeight));
  ExpectRefused("frame.color.rgb8", with_size(-kWidth, -kHeight));
  ExpectRefused("frame.color.rgb8", with_size(kWidth, -1));
  // Products of these overflow 32 and 64 bits.
  ExpectRefused("frame.color.rgb8", with_size(65536, 65536));
  ExpectRefused("frame.color.rgb8", with_size(2147483647, 2147483647));
}

TEST(HostileFrame, RawColorOverTheLimits) {
  ExpectRefused("frame.color.rgb8", [](auto&) {}, {.max_width = kWidth - 1});
  ExpectRefused("frame.color.rgb8", [](auto&) {}, {.max_height = kHeight - 1});
  ExpectRefused("frame.color.rgb8", [](auto&) {},
                {.max_pixels = kWidth * kHeight - 1});
  EXPECT_TRUE(Decode(GoodFrame(), {.max_width = kWidth,
                                   .max_height = kHeight,
                                   .max_pixels = kWidth * kHeight})
                  .ok());
}

TEST(HostileFrame, Camera) {
  ExpectRefused("frame.camera",
                [](auto& f) { f.mutable_camera()->set_parameters(0, kNan); });
  ExpectRefused("frame.camera",
                [](auto& f) { f.mutable_camera()->set_width_px(-1); });
  ExpectRefused("frame.camera",
                [](auto& f) { f.mutable_camera()->clear_model(); });
}

TEST(HostileFrame, CameraOfAnotherSizeThanTheImage) {
  ExpectRefused("frame.camera",
                [](auto& f) { f.mutable_camera()->set_width_px(kWidth + 1); });
}

TEST(HostileFrame, NoCameraAndAnotherSizeThanTheScenes) {
  ExpectRefused("frame.camera", [](auto& f) {
    f.clear_camera();
    v1::Rgb8Image& raw = *f.mutable_color()->mutable_rgb8();
    raw.set_height_px(kHeight - 1);
    raw.mutable_data()->resize(kWidth * (kHeight - 1) * 3);
  });
}

TEST(HostileFrame, Orientation) {
  for (const int value : {5, -1}) {
    ExpectRefused("frame.orientation", [=](auto& f) {
      f.set_orientation(static_cast<v1::Orientation>(value));
    });
  }
}

TEST(HostileFrame, Gravity) {
  for (const double length : {0.0, 1e-4, 1e200, kNan, kInfinity}) {
    ExpectRefused("frame.gravity_in_camera_mps2", [=](auto& f) {
      f.mutable_gravity_in_camera_mps2()->set_y(length);
    });
    // Nor is it passed over where it does not count.
    ExpectRefused("frame.gravity_in_camera_mps2", [=](auto& f) {
      f.set_orientation(v1::ORIENTATION_TOP_UP);
      f.mutable_gravity_in_camera_mps2()->set_y(length);
    });
  }
}

TEST(HostileFrame, DepthUnit) {
  for (const double unit_m : {0.0, -0.001, kNan, kInfinity, 1.5}) {
    ExpectRefused("frame.depth.unit_m",
                  [=](auto& f) { f.mutable_depth()->set_unit_m(unit_m); });
  }
}

TEST(HostileFrame, DepthRegistration) {
  for (const int value : {0, 4, -1}) {
    ExpectRefused("frame.depth.registration", [=](auto& f) {
      f.mutable_depth()->set_registration(
          static_cast<v1::DepthRegistration>(value));
    });
  }
}

TEST(HostileFrame, DepthCalibrationThatDoesNotFitTheRegistration) {
  ExpectRefused("frame.depth.calibration",
                [](auto& f) { f.mutable_depth()->clear_calibration(); });
  for (const auto registration : {v1::DEPTH_REGISTRATION_REGISTERED_TO_COLOR,
                                  v1::DEPTH_REGISTRATION_SCENE_CALIBRATION}) {
    ExpectRefused("frame.depth.calibration", [=](auto& f) {
      f.mutable_depth()->set_registration(registration);
    });
  }
}

TEST(HostileFrame, DepthCamera) {
  ExpectRefused("frame.depth.calibration.depth_camera", [](auto& f) {
    f.mutable_depth()->mutable_calibration()->clear_depth_camera();
  });
  ExpectRefused("frame.depth.calibration.depth_camera", [](auto& f) {
    f.mutable_depth()
        ->mutable_calibration()
        ->mutable_depth_camera()
        ->set_parameters(1, kInfinity);
  });
}

TEST(HostileFrame, ColorFromDepth) {
  ExpectRefused("frame.depth.calibration.color_from_depth", [](auto& f) {
    f.mutable_depth()->mutable_calibration()->clear_color_from_depth();
  });
  ExpectRefused("frame.depth.calibration.color_from_depth", [](auto& f) {
    f.mutable_depth()
        ->mutable_calibration()
        ->mutable_color_from_depth()
        ->mutable_rotation()
        ->set_x(0.5);
  });
}

TEST(HostileFrame, DepthScale) {
  for (const double scale : {0.0, -1.0, 0.49, 2.01, kNan, kInfinity}) {
    ExpectRefused("frame.depth.depth_scale",
                  [=](auto& f) { f.mutable_depth()->set_depth_scale(scale); });
  }
  ExpectRefused("frame.depth.depth_scale", [](auto& f) {
    f.mutable_depth()->clear_calibration();
    f.mutable_depth()->set_registration(
        v1::DEPTH_REGISTRATION_SCENE_CALIBRATION);
    f.mutable_depth()->set_depth_scale(1);
  });
}

TEST(HostileFrame, DepthThatIsNoImage) {
  ExpectRefused("frame.depth", [](auto& f) { f.mutable_depth()->clear_raw(); });
  ExpectRefused("frame.depth.png",
                [](auto& f) { f.mutable_depth()->set_png("not a PNG"); });
  const std::string png = image::EncodeDepthPng(SomeDepth()).value();
  ExpectRefused("frame.depth.png", [&](auto& f) {
    f.mutable_depth()->set_png(png.substr(0, png.size() - 20));
  });
  // Eight bits a channel: colour sent as depth.
  ExpectRefused("frame.depth.png", [](auto& f) {
    f.mutable_depth()->set_png(image::EncodePng(SomeColor()).value());
  });
  ExpectRefused("frame.depth.raw.data", [](auto& f) {
    f.mutable_depth()->mutable_raw()->mutable_data()->pop_back();
  });
  ExpectRefused("frame.depth.raw", [](auto& f) {
    f.mutable_depth()->mutable_raw()->set_width_px(-kWidth);
  });
}

TEST(HostileFrame, DepthOfAnotherSizeThanItsCamera) {
  ExpectRefused("frame.depth", [](auto& f) {
    v1::Uint16Image& raw = *f.mutable_depth()->mutable_raw();
    raw.set_width_px(kWidth / 2);
    raw.mutable_data()->resize(kWidth / 2 * kHeight * 2);
  });
}

}  // namespace
}  // namespace treeline::wire
