// Frames that are good: what the server sees of what the client had.
#include "common/wire/frame.h"

#include <string>
#include <utility>

#include "absl/strings/escaping.h"
#include "common/base/random.h"
#include "common/camera/assumed_camera.h"
#include "common/wire/camera.h"
#include "gtest/gtest.h"

namespace treeline::wire {
namespace {

constexpr int kWidth = 40;
constexpr int kHeight = 30;

// Smooth, so that JPEG keeps it.
image::ColorImage SomeColor(int width = kWidth, int height = kHeight) {
  image::ColorImage image{.width = width, .height = height, .rgb = {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.rgb.push_back(static_cast<uint8_t>(5 * x));
      image.rgb.push_back(static_cast<uint8_t>(6 * y));
      image.rgb.push_back(static_cast<uint8_t>(100 + x - y));
    }
  }
  return image;
}

image::DepthImage SomeDepth(int width = kWidth, int height = kHeight) {
  base::Random random(/*seed=*/3, /*stream=*/0);
  image::DepthImage image{
      .width = width, .height = height, .values = {}, .unit_m = 0.0002};
  for (int i = 0; i < width * height; ++i) {
    image.values.push_back(static_cast<uint16_t>(random.NextBelow(65536)));
  }
  return image;
}

camera::Camera CameraOf(int width, int height, double focal_length_px) {
  const double parameters[] = {focal_length_px, width / 2.0, height / 2.0};
  return camera::Camera::Create(camera::CameraModel::kSimplePinhole, width,
                                height, parameters, 3)
      .value();
}

// A scene whose depth camera is smaller than its colour camera.
camera::RgbdCalibration SceneCalibration() {
  camera::RgbdCalibration scene;
  scene.color = CameraOf(kWidth, kHeight, 35);
  scene.depth = CameraOf(kWidth / 2, kHeight / 2, 18);
  scene.color_from_depth = {geometry::Rotation3::FromAxisAngle({0, 0.01, 0}),
                            {0.025, 0, 0}};
  scene.depth_scale = 1.01;
  scene.pose_sensor = camera::RgbdSensor::kDepth;
  return scene;
}

QueryFrame Query(QueryDepth depth) {
  return {
      .color = SomeColor(), .camera = std::nullopt, .depth = std::move(depth)};
}

absl::StatusOr<image::Frame> Decode(const QueryFrame& query) {
  return FromProto(ToProto(query), SceneCalibration(), image::DecodeLimits{},
                   "frame");
}

TEST(WireFrame, RawColorArrivesBitForBit) {
  const auto frame = Decode({.color = SomeColor()});
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(frame->color.width, kWidth);
  EXPECT_EQ(frame->color.height, kHeight);
  EXPECT_EQ(frame->color.rgb, SomeColor().rgb);
  EXPECT_FALSE(frame->depth.has_value());
  EXPECT_FALSE(frame->calibration.has_value());
}

TEST(WireFrame, PngColorArrivesBitForBit) {
  const auto frame =
      Decode({.color = EncodedImage{image::EncodePng(SomeColor()).value()}});
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(frame->color.rgb, SomeColor().rgb);
}

TEST(WireFrame, JpegColorArrivesAsItsDecoderGivesIt) {
  const std::string jpeg = image::EncodeJpeg(SomeColor(), 95).value();
  const auto frame = Decode({.color = EncodedImage{jpeg}});
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(frame->color.rgb, image::DecodeColor(jpeg)->rgb);
}

TEST(WireFrame, RawAndPngDepthArriveBitForBit) {
  const image::DepthImage depth = SomeDepth(kWidth / 2, kHeight / 2);
  for (const bool encoded : {false, true}) {
    QueryDepth query{.image = depth, .unit_m = 0.0002};
    if (encoded)
      query.image = EncodedImage{image::EncodeDepthPng(depth).value()};
    const auto frame = Decode(Query(query));
    ASSERT_TRUE(frame.ok()) << frame.status();
    ASSERT_TRUE(frame->depth.has_value());
    EXPECT_EQ(frame->depth->width, kWidth / 2);
    EXPECT_EQ(frame->depth->height, kHeight / 2);
    EXPECT_EQ(frame->depth->values, depth.values);
    EXPECT_EQ(frame->depth->unit_m, 0.0002);
  }
}

TEST(WireFrame, RawDepthIsLittleEndianOnTheWire) {
  QueryDepth depth{
      .image = image::DepthImage{.width = 1, .height = 1, .values = {0x1234}}};
  EXPECT_EQ(ToProto(Query(depth)).depth().raw().data(), "\x34\x12");
}

TEST(WireFrame, SceneCalibrationAloneIsLeftToTheScene) {
  const auto frame =
      Decode(Query({.image = SomeDepth(kWidth / 2, kHeight / 2)}));
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_FALSE(frame->calibration.has_value());
}

TEST(WireFrame, OwnColorCameraReplacesOnlyTheScenesColorCamera) {
  for (const bool with_depth : {false, true}) {
    QueryFrame query{.color = SomeColor(60, 50),
                     .camera = CameraOf(60, 50, 77)};
    if (with_depth) {
      query.depth = QueryDepth{.image = SomeDepth(kWidth / 2, kHeight / 2)};
    }
    const auto frame = Decode(query);
    ASSERT_TRUE(frame.ok()) << frame.status();
    camera::RgbdCalibration expected = SceneCalibration();
    expected.color = CameraOf(60, 50, 77);
    EXPECT_EQ(frame->calibration, expected);
  }
}

TEST(WireFrame, ACameraIsAssumedForAPictureOfAnotherSize) {
  const v1::Frame proto = ToProto({.color = SomeColor(60, 50)});
  const camera::RgbdCalibration scene = SceneCalibration();
  const auto frame = FromProto(proto, scene, image::DecodeLimits{}, "frame");
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_TRUE(frame->is_camera_assumed);
  camera::RgbdCalibration expected = scene;
  expected.color = camera::AssumedCamera(60, 50, std::nullopt, scene.color);
  EXPECT_EQ(frame->calibration, expected);
  EXPECT_EQ(AssumedCamera(proto, *frame, scene), expected.color);
  // Not where it is known, nor for depth.
  const auto of_scene = Decode({.color = SomeColor()});
  ASSERT_TRUE(of_scene.ok());
  EXPECT_FALSE(of_scene->is_camera_assumed);
  const auto stated =
      Decode({.color = SomeColor(60, 50), .camera = CameraOf(60, 50, 77)});
  ASSERT_TRUE(stated.ok());
  EXPECT_FALSE(stated->is_camera_assumed);
  const auto with_depth = Decode(
      {.color = SomeColor(60, 50),
       .depth = QueryDepth{.image = SomeDepth(kWidth / 2, kHeight / 2)}});
  EXPECT_TRUE(absl::IsInvalidArgument(with_depth.status()));
}

TEST(WireFrame, RegisteredDepthSharesTheScenesColorCamera) {
  const auto frame =
      Decode(Query({.image = SomeDepth(),
                    .registration = DepthRegistration::kRegisteredToColor}));
  ASSERT_TRUE(frame.ok()) << frame.status();
  const camera::RgbdCalibration expected{
      .color = SceneCalibration().color,
      .depth = SceneCalibration().color,
      .color_from_depth = geometry::Rigid3{},
      .depth_scale = 1,
      .pose_sensor = camera::RgbdSensor::kDepth};
  EXPECT_EQ(frame->calibration, expected);
}

TEST(WireFrame, RegisteredDepthSharesTheRequestsColorCamera) {
  QueryFrame query{.color = SomeColor(60, 50), .camera = CameraOf(60, 50, 77)};
  query.depth =
      QueryDepth{.image = SomeDepth(60, 50),
                 .registration = DepthRegistration::kRegisteredToColor,
                 .depth_scale = 1.02};
  const auto frame = Decode(query);
  ASSERT_TRUE(frame.ok()) << frame.status();
  const camera::RgbdCalibration expected{
      .color = CameraOf(60, 50, 77),
      .depth = CameraOf(60, 50, 77),
      .color_from_depth = geometry::Rigid3{},
      .depth_scale = 1.02,
      .pose_sensor = camera::RgbdSensor::kDepth};
  EXPECT_EQ(frame->calibration, expected);
}

TEST(WireFrame, ExplicitDepthCameraIsUsedAsSent) {
  const geometry::Rigid3 color_from_depth{
      geometry::Rotation3::FromAxisAngle({0.1, 0.2, 0.3}), {0.05, -0.01, 0.02}};
  const auto frame = Decode(Query(
      {.image = SomeDepth(16, 12),
       .registration = DepthRegistration::kExplicit,
       .geometry = QueryDepth::Geometry{CameraOf(16, 12, 14), color_from_depth},
       .depth_scale = 0.97}));
  ASSERT_TRUE(frame.ok()) << frame.status();
  const camera::RgbdCalibration expected{
      .color = SceneCalibration().color,
      .depth = CameraOf(16, 12, 14),
      .color_from_depth = color_from_depth,
      .depth_scale = 0.97,
      .pose_sensor = camera::RgbdSensor::kDepth};
  EXPECT_EQ(frame->calibration, expected);
}

// One decoding serves scenes with different calibrations.
TEST(WireFrame, PixelsAndCalibrationAreTheTwoHalvesOfAFrame) {
  QueryDepth depth;
  depth.image = SomeDepth(kWidth / 2, kHeight / 2);
  depth.unit_m = 0.0002;
  QueryFrame query = Query(depth);
  query.camera = CameraOf(kWidth, kHeight, 50);
  const v1::Frame proto = ToProto(query);
  camera::RgbdCalibration other = SceneCalibration();
  other.depth_scale = 0.98;
  const auto pixels = PixelsFromProto(proto, image::DecodeLimits{}, "frame");
  ASSERT_TRUE(pixels.ok()) << pixels.status();
  EXPECT_EQ(pixels->calibration, std::nullopt);
  for (const camera::RgbdCalibration& scene : {SceneCalibration(), other}) {
    const auto whole = FromProto(proto, scene, image::DecodeLimits{}, "frame");
    ASSERT_TRUE(whole.ok()) << whole.status();
    EXPECT_EQ(pixels->color.rgb, whole->color.rgb);
    EXPECT_EQ(pixels->depth->values, whole->depth->values);
    const auto calibration =
        CalibrationFromProto(proto, *pixels, scene, "frame");
    ASSERT_TRUE(calibration.ok()) << calibration.status();
    EXPECT_EQ(*calibration, whole->calibration);
  }
}

TEST(WireFrame, PixelsMustFitTheCamerasOfTheScene) {
  const v1::Frame proto = ToProto(
      {.color = SomeColor(), .camera = std::nullopt, .depth = std::nullopt});
  const auto pixels = PixelsFromProto(proto, image::DecodeLimits{}, "frame");
  ASSERT_TRUE(pixels.ok());
  camera::RgbdCalibration scene = SceneCalibration();
  EXPECT_TRUE(CalibrationFromProto(proto, *pixels, scene, "frame").ok());
  // One is assumed, by either half.
  scene.color = CameraOf(kWidth + 2, kHeight, 35);
  const auto assumed = CalibrationFromProto(proto, *pixels, scene, "frame");
  ASSERT_TRUE(assumed.ok()) << assumed.status();
  EXPECT_EQ(
      *assumed,
      FromProto(proto, scene, image::DecodeLimits{}, "frame")->calibration);
  // With a stated one there is nothing to assume.
  v1::Frame stated = proto;
  *stated.mutable_camera() = ToProto(CameraOf(kWidth + 2, kHeight, 35));
  EXPECT_EQ(CalibrationFromProto(stated, *pixels, scene, "frame").status(),
            FromProto(stated, scene, image::DecodeLimits{}, "frame").status());
  EXPECT_FALSE(CalibrationFromProto(stated, *pixels, scene, "frame").ok());
}

// A JPEG whose EXIF says that its right side is up: turn it clockwise thrice.
std::string JpegWithRightSideUp() {
  const std::string jpeg = image::EncodeJpeg(SomeColor(), 95).value();
  std::string exif(
      "\xff\xe1\x00\x22"
      "Exif\0\0MM\0*\0\0\0\x08\0\x01",
      20);
  exif += std::string("\x01\x12\0\x03\0\0\0\x01\0\x08\0\0\0\0\0\0", 16);
  return jpeg.substr(0, 2) + exif + jpeg.substr(2);
}

// One whose EXIF states a focal length, in terms of film.
std::string JpegOfLens(int focal_35mm) {
  const std::string jpeg = image::EncodeJpeg(SomeColor(), 95).value();
  const std::string tag_ends(4, '\0');
  const std::string exif =
      std::string("Exif\0\0MM\0*\0\0\0\x08", 14) +
      // A directory that holds where the other one is, and that one.
      std::string("\0\x01\x87\x69\0\x04\0\0\0\x01\0\0\0\x1a", 14) + tag_ends +
      std::string("\0\x01\xa4\x05\0\x03\0\0\0\x01\0", 11) +
      static_cast<char>(focal_35mm) + std::string(2, '\0') + tag_ends;
  return jpeg.substr(0, 2) + "\xff\xe1" + '\0' +
         static_cast<char>(exif.size() + 2) + exif + jpeg.substr(2);
}

// The scene's camera has 35 px of a diagonal of 50 px: 30 mm.
TEST(WireFrame, ACameraIsAssumedForAPictureOfAnotherLens) {
  for (const int same : {26, 30, 35}) {
    const auto frame = Decode({.color = EncodedImage{JpegOfLens(same)}});
    ASSERT_TRUE(frame.ok()) << frame.status();
    EXPECT_FALSE(frame->is_camera_assumed) << same;
  }
  for (const int other : {13, 52}) {
    const QueryFrame query{.color = EncodedImage{JpegOfLens(other)}};
    const auto frame = Decode(query);
    ASSERT_TRUE(frame.ok()) << frame.status();
    EXPECT_TRUE(frame->is_camera_assumed);
    ASSERT_TRUE(frame->calibration.has_value());
    EXPECT_NEAR(frame->calibration->color.fx(), other * 50 / 43.2666, 1e-3);
    EXPECT_EQ(CalibrationFromProto(ToProto(query), *frame, SceneCalibration(),
                                   "frame")
                  .value(),
              frame->calibration);
    // With depth it is the scene's, and so is one that is stated.
    QueryFrame deep = query;
    deep.depth = QueryDepth{.image = SomeDepth(kWidth / 2, kHeight / 2)};
    EXPECT_FALSE(Decode(deep)->is_camera_assumed);
    QueryFrame stated = query;
    stated.camera = CameraOf(kWidth, kHeight, 35);
    EXPECT_FALSE(Decode(stated)->is_camera_assumed);
  }
}

TEST(WireFrame, TheWayUpArrivesAsStated) {
  for (const image::QuarterTurn turn : image::kQuarterTurns) {
    QueryFrame query{.color = EncodedImage{JpegWithRightSideUp()}};
    query.orientation = {turn, true};
    query.gravity_in_camera_mps2 = geometry::Vec3{0, -9.81, 0};
    const auto frame = Decode(query);
    ASSERT_TRUE(frame.ok()) << frame.status();
    EXPECT_EQ(frame->orientation, (image::Orientation{turn, true}));
    // Nothing of the frame itself is turned.
    EXPECT_EQ(frame->color.width, kWidth);
  }
}

TEST(WireFrame, EachEnumeratorNamesTheSideThatIsUp) {
  QueryFrame query{.color = SomeColor()};
  EXPECT_EQ(ToProto(query).orientation(), v1::ORIENTATION_UNSPECIFIED);
  query.orientation = {image::QuarterTurn::kNone, true};
  EXPECT_EQ(ToProto(query).orientation(), v1::ORIENTATION_TOP_UP);
  query.orientation = {image::QuarterTurn::kClockwise, true};
  EXPECT_EQ(ToProto(query).orientation(), v1::ORIENTATION_LEFT_UP);
  query.orientation = {image::QuarterTurn::kHalf, true};
  EXPECT_EQ(ToProto(query).orientation(), v1::ORIENTATION_BOTTOM_UP);
  query.orientation = {image::QuarterTurn::kCounterclockwise, true};
  EXPECT_EQ(ToProto(query).orientation(), v1::ORIENTATION_RIGHT_UP);
}

// Other programs speak this contract too: the bytes must stay.
TEST(WireFrame, TheWayUpHasTheseBytes) {
  QueryFrame query;
  query.orientation = {image::QuarterTurn::kClockwise, false};
  query.gravity_in_camera_mps2 = geometry::Vec3{1, 0, 0};
  v1::Frame proto = ToProto(query);
  proto.clear_color();
  EXPECT_EQ(absl::BytesToHexString(proto.SerializeAsString()),
            "2004"
            "2a0909000000000000f03f"
            "3001");
}

TEST(WireFrame, GravitySaysTheWayUpBeforeExifDoes) {
  QueryFrame query{.color = EncodedImage{JpegWithRightSideUp()}};
  EXPECT_EQ(Decode(query)->orientation,
            (image::Orientation{image::QuarterTurn::kCounterclockwise, false}));
  query.gravity_in_camera_mps2 = geometry::Vec3{9.7, 0.3, 1};
  EXPECT_EQ(Decode(query)->orientation,
            (image::Orientation{image::QuarterTurn::kClockwise, true}));
  // Of a camera that looks down it says nothing.
  query.gravity_in_camera_mps2 = geometry::Vec3{0, 0.1, 9.8};
  EXPECT_EQ(Decode(query)->orientation,
            (image::Orientation{image::QuarterTurn::kCounterclockwise, false}));
  // A guess takes EXIF's place, and not that of gravity.
  query.orientation = {image::QuarterTurn::kHalf, false};
  EXPECT_EQ(Decode(query)->orientation,
            (image::Orientation{image::QuarterTurn::kHalf, false}));
  query.gravity_in_camera_mps2 = geometry::Vec3{9.7, 0.3, 1};
  EXPECT_EQ(Decode(query)->orientation,
            (image::Orientation{image::QuarterTurn::kClockwise, true}));
  // A picture without any of it may be any way up.
  EXPECT_EQ(Decode({.color = SomeColor()})->orientation, image::Orientation{});
}

}  // namespace
}  // namespace treeline::wire
