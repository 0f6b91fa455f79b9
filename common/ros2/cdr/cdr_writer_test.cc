#include "common/ros2/cdr/cdr_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

namespace treeline::cdr {
namespace {

using ::testing::ElementsAre;

TEST(CdrWriterTest, BeginsWithItsEncoding) {
  EXPECT_THAT(CdrWriter().Take(), ElementsAre(0, 1, 0, 0));
}

TEST(CdrWriterTest, AlignsToTheSizeCountedFromBehindTheEncoding) {
  CdrWriter writer;
  writer.Write(uint8_t{0xab});
  writer.Write(uint16_t{0x1234});
  writer.Write(int32_t{-2});
  writer.Write(true);
  writer.Write(1.0);
  EXPECT_THAT(std::move(writer).Take(),
              ElementsAre(0, 1, 0, 0,              //
                          0xab, 0, 0x34, 0x12,     //
                          0xfe, 0xff, 0xff, 0xff,  //
                          1, 0, 0, 0, 0, 0, 0, 0,  //
                          0, 0, 0, 0, 0, 0, 0xf0, 0x3f));
}

TEST(CdrWriterTest, StringsHaveLengthAndZeroByte) {
  CdrWriter writer;
  writer.WriteString("map");
  writer.WriteString("");
  EXPECT_THAT(std::move(writer).Take(),
              ElementsAre(0, 1, 0, 0,                    //
                          4, 0, 0, 0, 'm', 'a', 'p', 0,  //
                          1, 0, 0, 0, 0));
}

TEST(CdrWriterTest, EmptyArraysAreNotAligned) {
  CdrWriter writer;
  writer.WriteCount(0);
  writer.WriteArray(std::span<const double>());
  writer.Write(uint8_t{7});
  EXPECT_THAT(std::move(writer).Take(), ElementsAre(0, 1, 0, 0, 0, 0, 0, 0, 7));
}

TEST(CdrWriterTest, ArraysFollowTheirCountAtTheirOwnAlignment) {
  CdrWriter writer;
  const std::array<double, 1> value = {2.0};
  writer.WriteCount(value.size());
  writer.WriteArray(std::span<const double>(value));
  EXPECT_THAT(std::move(writer).Take(),
              ElementsAre(0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0,  //
                          0, 0, 0, 0, 0, 0, 0, 0x40));
}

}  // namespace
}  // namespace treeline::cdr
