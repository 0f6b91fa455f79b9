#include "common/ros2/conversions/camera_values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>

#include "common/image/decode.h"
#include "common/image/testing_depth_codecs.h"

namespace treeline::conversions {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

messages::CameraInfo Info() {
  messages::CameraInfo info;
  info.width = 640;
  info.height = 480;
  info.distortion_model = "plumb_bob";
  info.k = {525, 0, 319.5, 0, 526, 239.5, 0, 0, 1};
  info.p = {500, 0, 310, 0, 0, 501, 230, 0, 0, 0, 1, 0};
  return info;
}

TEST(CameraValuesTest, ModelsOfDistortion) {
  messages::CameraInfo info = Info();
  EXPECT_EQ(CameraOf(info, false)->model(), camera::CameraModel::kPinhole);
  info.d = {0, 0, 0, 0, 0};
  EXPECT_EQ(CameraOf(info, false)->model(), camera::CameraModel::kPinhole);
  info.d = {0.1, -0.2, 0.001, 0.002, 0};
  EXPECT_EQ(CameraOf(info, false)->model(), camera::CameraModel::kOpenCv);
  info.d = {0.1, -0.2, 0.001, 0.002, 0.3};
  auto made = CameraOf(info, false);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_EQ(made->model(), camera::CameraModel::kFullOpenCv);
  EXPECT_EQ(made->parameters()[8], 0.3);
  info.distortion_model = "rational_polynomial";
  info.d = {0.1, -0.2, 0.001, 0.002, 0.3, 1, 2, 3};
  EXPECT_EQ(CameraOf(info, false)->parameters()[11], 3);
  info.distortion_model = "equidistant";
  info.d = {0.1, 0.2, 0.3, 0.4};
  EXPECT_EQ(CameraOf(info, false)->model(),
            camera::CameraModel::kOpenCvFisheye);
  info.distortion_model = "thin_prism";
  EXPECT_THAT(std::string(CameraOf(info, false).status().message()),
              HasSubstr("thin_prism"));
}

TEST(CameraValuesTest, RectifiedPicturesHaveTheProjectionMatrix) {
  messages::CameraInfo info = Info();
  info.d = {0.1, -0.2, 0.001, 0.002, 0};
  const auto made = CameraOf(info, true);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_EQ(made->model(), camera::CameraModel::kPinhole);
  EXPECT_EQ(made->fx(), 500);
  EXPECT_EQ(made->cy(), 230);
}

TEST(CameraValuesTest, BinningKeepsWhereRaysGo) {
  messages::CameraInfo info = Info();
  const auto full = CameraOf(info, false);
  info.binning_x = info.binning_y = 2;
  const auto binned = CameraOf(info, false);
  ASSERT_TRUE(binned.ok()) << binned.status();
  EXPECT_EQ(binned->width(), 320);
  // The middle of a pixel of the binned picture is that of four of the whole.
  const auto a = full->Unproject({100.5, 60.5});
  const auto b = binned->Unproject({50, 30});
  ASSERT_TRUE(a.has_value() && b.has_value());
  EXPECT_NEAR(a->x, b->x, 1e-12);
  EXPECT_NEAR(a->y, b->y, 1e-12);
}

TEST(CameraValuesTest, ACameraThatNobodyCalibratedSaysSo) {
  messages::CameraInfo info = Info();
  info.k = {};
  EXPECT_THAT(std::string(CameraOf(info, false).status().message()),
              HasSubstr("calibrate"));
}

TEST(CameraValuesTest, ColourOfAllEncodings) {
  messages::Image image;
  image.width = 1;
  image.height = 2;
  image.encoding = "rgb8";
  image.step = 4;
  image.data = {1, 2, 3, 99, 4, 5, 6, 99};
  EXPECT_THAT(ColorOf(image)->rgb, ElementsAre(1, 2, 3, 4, 5, 6));
  image.encoding = "bgr8";
  EXPECT_THAT(ColorOf(image)->rgb, ElementsAre(3, 2, 1, 6, 5, 4));
  image.encoding = "bgra8";
  EXPECT_THAT(ColorOf(image)->rgb, ElementsAre(3, 2, 1, 6, 5, 4));
  image.encoding = "mono8";
  EXPECT_THAT(ColorOf(image)->rgb, ElementsAre(1, 1, 1, 4, 4, 4));
  image.encoding = "bayer_rggb8";
  EXPECT_THAT(std::string(ColorOf(image).status().message()),
              HasSubstr("\"bayer_rggb8\" is not known; rgb8"));
}

TEST(CameraValuesTest, ColourOfHalvedColourDifferences) {
  messages::Image image;
  image.width = 2;
  image.height = 2;
  image.encoding = "yuv422_yuy2";
  // Rows are longer than their pixels. Black and white; red (81, 90, 240).
  image.step = 6;
  image.data = {16, 128, 235, 128, 99, 99, 81, 90, 81, 240, 99, 99};
  const auto made = ColorOf(image);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_THAT(made->rgb,
              ElementsAre(0, 0, 0, 255, 255, 255, 254, 0, 0, 254, 0, 0));
  for (size_t i = 0; i + 1 < image.data.size(); i += 2) {
    std::swap(image.data[i], image.data[i + 1]);
  }
  image.encoding = "yuv422";
  EXPECT_EQ(ColorOf(image)->rgb, made->rgb);
  image.encoding = "uyvy";
  EXPECT_EQ(ColorOf(image)->rgb, made->rgb);
  image.width = 1;
  EXPECT_FALSE(ColorOf(image).ok());
}

TEST(CameraValuesTest, PicturesThatLieAboutTheirSizeAreErrors) {
  messages::Image image;
  image.width = 2;
  image.height = 2;
  image.encoding = "rgb8";
  image.step = 6;
  image.data.resize(11);
  EXPECT_FALSE(ColorOf(image).ok());
  image.data.resize(12);
  EXPECT_TRUE(ColorOf(image).ok());
  image.step = 5;
  EXPECT_FALSE(ColorOf(image).ok());
  image.width = 0x40000001;
  image.step = 3;
  EXPECT_FALSE(ColorOf(image).ok());
}

TEST(CameraValuesTest, DepthInMillimetresAndInMetres) {
  messages::Image image;
  image.width = 2;
  image.height = 1;
  image.encoding = "16UC1";
  image.step = 4;
  image.data = {0x34, 0x12, 0, 0};
  EXPECT_THAT(DepthOf(image)->values, ElementsAre(0x1234, 0));
  image.is_bigendian = 1;
  EXPECT_THAT(DepthOf(image)->values, ElementsAre(0x3412, 0));
  image.is_bigendian = 0;
  image.encoding = "32FC1";
  image.step = 8;
  image.data.clear();
  for (const float depth_m : {1.5F, std::nanf("")}) {
    const auto bytes = std::bit_cast<std::array<uint8_t, 4>>(depth_m);
    image.data.insert(image.data.end(), bytes.begin(), bytes.end());
  }
  EXPECT_THAT(DepthOf(image)->values, ElementsAre(1500, 0));
}

TEST(CameraValuesTest, CompressedPictures) {
  const image::ColorImage color = {
      .width = 2, .height = 1, .rgb = {10, 20, 30, 40, 50, 60}};
  const auto png = image::EncodePng(color);
  ASSERT_TRUE(png.ok());
  messages::CompressedImage message;
  message.format = "rgb8; png compressed rgb8";
  message.data.assign(png->begin(), png->end());
  EXPECT_EQ(ColorOf(message)->rgb, color.rgb);
  const image::DepthImage depth = {.width = 2, .height = 1, .values = {700, 0}};
  const auto depth_png = image::EncodeDepthPng(depth);
  ASSERT_TRUE(depth_png.ok());
  message.format = "16UC1; compressedDepth png";
  message.data.assign(12, 0);
  message.data.insert(message.data.end(), depth_png->begin(), depth_png->end());
  EXPECT_EQ(DepthOf(message)->values, depth.values);
  message.format = "16UC1; compressedDepth rvl";
  EXPECT_FALSE(DepthOf(message).ok());  // it is still the PNG
  const std::string rvl = image::EncodedRvl(2, 1, depth.values);
  message.data.assign(12, 0);
  message.data.insert(message.data.end(), rvl.begin(), rvl.end());
  const auto of_rvl = DepthOf(message);
  ASSERT_TRUE(of_rvl.ok()) << of_rvl.status();
  EXPECT_EQ(of_rvl->values, depth.values);
}

// As compressed_depth_image_transport quantizes floats: value = a / depth + b.
TEST(CameraValuesTest, CompressedDepthOfFloats) {
  constexpr float kMax_m = 10;
  constexpr float kA = 100.0F * (100.0F + 1);
  constexpr float kB = 1.0F - kA / kMax_m;
  image::DepthImage coded = {.width = 3, .height = 1, .values = {0}};
  for (const float depth_m : {1.0F, 4.0F}) {
    coded.values.push_back(static_cast<uint16_t>(kA / depth_m + kB));
  }
  const std::string png = image::EncodeDepthPng(coded).value();
  messages::CompressedImage message;
  message.format = "32FC1; compressedDepth png";
  message.data.assign(4, 0);
  for (const float parameter : {kA, kB}) {
    const auto bytes = std::bit_cast<std::array<uint8_t, 4>>(parameter);
    message.data.insert(message.data.end(), bytes.begin(), bytes.end());
  }
  message.data.insert(message.data.end(), png.begin(), png.end());
  const auto depth = DepthOf(message);
  ASSERT_TRUE(depth.ok()) << depth.status();
  EXPECT_EQ(depth->values[0], 0);
  // A step of the inverse depth is depth^2 / a: 0.1 mm, and 1.6 mm at 4 m.
  EXPECT_NEAR(depth->values[1], 1000, 1);
  EXPECT_NEAR(depth->values[2], 4000, 2);
}

TEST(CameraValuesTest, DepthOfTheTransportForColour) {
  const image::DepthImage depth = {.width = 2, .height = 1, .values = {700, 0}};
  const std::string png = image::EncodeDepthPng(depth).value();
  messages::CompressedImage message;
  message.format = "16UC1; png compressed ";
  message.data.assign(png.begin(), png.end());
  EXPECT_EQ(DepthOf(message)->values, depth.values);
}

TEST(CameraValuesTest, CamerasComeBackFromTheirInfo) {
  for (const char* text :
       {"PINHOLE,500,501,319.5,240",
        "OPENCV,500,501,320,240,0.1,-0.2,0.01,0.02",
        "FULL_OPENCV,500,501,320,240,0.1,-0.2,0.01,0.02,0.3,0.4,0.5,0.6",
        "OPENCV_FISHEYE,500,501,320,240,0.1,0.2,0.3,0.4"}) {
    const camera::Camera camera = *camera::Camera::Parse(text, 640, 480);
    const auto info = InfoOf(camera, {.stamp = {}, .frame_id = "camera"});
    ASSERT_TRUE(info.ok()) << info.status();
    const auto again = CameraOf(*info, false);
    ASSERT_TRUE(again.ok()) << again.status();
    EXPECT_EQ(*again, camera) << text;
  }
  // With two focal lengths, as ROS has it.
  const auto radial =
      InfoOf(*camera::Camera::Parse("RADIAL,500,320,240,0.1,0.2", 640, 480),
             {.stamp = {}, .frame_id = ""});
  ASSERT_TRUE(radial.ok());
  EXPECT_EQ(CameraOf(*radial, false)->ToString(),
            "OPENCV,500,500,320,240,0.1,0.2,0,0");
  EXPECT_THAT(std::string(InfoOf(*camera::Camera::Parse(
                                     "FOV,500,500,320,240,0.9", 640, 480),
                                 {.stamp = {}, .frame_id = ""})
                              .status()
                              .message()),
              HasSubstr("FOV"));
}

}  // namespace
}  // namespace treeline::conversions
