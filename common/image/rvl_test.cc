#include "common/image/rvl.h"

#include <cstdint>
#include <string>
#include <vector>

#include "common/image/testing_depth_codecs.h"
#include "gtest/gtest.h"

namespace treeline::image {
namespace {

const std::vector<uint16_t> kValues = {0,    0, 1500,  1501,  1499, 0,
                                       7000, 1, 65535, 65534, 0,    0};

TEST(RvlTest, ReadsWhatWasWritten) {
  const auto depth = DecodeRvl(EncodedRvl(4, 3, kValues), 0.001);
  ASSERT_TRUE(depth.ok()) << depth.status();
  EXPECT_EQ(depth->width, 4);
  EXPECT_EQ(depth->height, 3);
  EXPECT_EQ(depth->values, kValues);
  EXPECT_EQ(depth->unit_m, 0.001);
}

TEST(RvlTest, ReadsPicturesThatBeginOrEndWithMeasuredValues) {
  for (const std::vector<uint16_t>& values :
       {std::vector<uint16_t>{5, 0, 0, 9}, std::vector<uint16_t>(4, 0),
        std::vector<uint16_t>(4, 900)}) {
    const auto depth = DecodeRvl(EncodedRvl(2, 2, values), 0.001);
    ASSERT_TRUE(depth.ok()) << depth.status();
    EXPECT_EQ(depth->values, values);
  }
}

TEST(RvlTest, WhatIsCutOffIsRefused) {
  const std::string whole = EncodedRvl(4, 3, kValues);
  for (size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(DecodeRvl(whole.substr(0, size), 0.001).ok()) << size;
  }
}

TEST(RvlTest, RunsThatLeaveThePictureAndHugeSizesAreRefused) {
  std::string longer = EncodedRvl(4, 3, kValues);
  longer[0] = 1;  // three pixels, and a run of more
  EXPECT_FALSE(DecodeRvl(longer, 0.001).ok());
  EXPECT_FALSE(DecodeRvl(EncodedRvl(1U << 31, 1, {0}), 0.001).ok());
  EXPECT_FALSE(DecodeRvl(EncodedRvl(0, 3, {}), 0.001).ok());
  // A number that never ends.
  EXPECT_FALSE(
      DecodeRvl(EncodedRvl(4, 3, {}) + std::string(64, '\xff'), 0.001).ok());
}

}  // namespace
}  // namespace treeline::image
