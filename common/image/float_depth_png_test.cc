#include "common/image/float_depth_png.h"

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "common/image/decode.h"
#include "common/image/testing_depth_codecs.h"
#include "gtest/gtest.h"

namespace treeline::image {
namespace {

TEST(FloatDepthPngTest, MetresBecomeMillimetres) {
  const std::string png = EncodedFloatDepthPng(
      4, 2,
      {0, 1.2345F, 65.534F, 65.6F, -1, std::numeric_limits<float>::quiet_NaN(),
       std::numeric_limits<float>::infinity(), 0.001F});
  ASSERT_TRUE(IsFloatDepthPng(png));
  const auto depth = DecodeFloatDepthPng(png);
  ASSERT_TRUE(depth.ok()) << depth.status();
  EXPECT_EQ(depth->width, 4);
  EXPECT_EQ(depth->height, 2);
  EXPECT_EQ(depth->unit_m, 0.001);
  EXPECT_EQ(depth->values,
            (std::vector<uint16_t>{0, 1235, 65534, 0, 0, 0, 0, 1}));
}

TEST(FloatDepthPngTest, DepthInWholeNumbersIsNoFloats) {
  const auto png = EncodeDepthPng(
      {.width = 2, .height = 1, .values = {1, 2}, .unit_m = 0.001});
  ASSERT_TRUE(png.ok());
  EXPECT_FALSE(IsFloatDepthPng(*png));
  EXPECT_FALSE(DecodeFloatDepthPng(*png).ok());
  EXPECT_FALSE(IsFloatDepthPng("no PNG"));
}

TEST(FloatDepthPngTest, WhatIsCutOffIsRefused) {
  const std::string png = EncodedFloatDepthPng(2, 2, {1, 2, 3, 4});
  for (size_t size = 0; size + 12 < png.size(); ++size) {
    EXPECT_FALSE(DecodeFloatDepthPng(png.substr(0, size)).ok()) << size;
  }
}

}  // namespace
}  // namespace treeline::image
