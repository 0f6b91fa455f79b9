#include "common/ros2/cdr/cdr_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace treeline::cdr {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(CdrReaderTest, ReadsBothByteOrders) {
  const std::vector<uint8_t> little = {0, 1, 0, 0, 9,    0,    0,    0,
                                       4, 3, 2, 1, 0xfe, 0xff, 0xff, 0xff};
  const std::vector<uint8_t> big = {0, 0, 0, 0, 9,    0,    0,    0,
                                    1, 2, 3, 4, 0xff, 0xff, 0xff, 0xfe};
  for (const std::vector<uint8_t>& bytes : {little, big}) {
    CdrReader reader(bytes);
    EXPECT_EQ(reader.Read<uint8_t>(), 9);
    EXPECT_EQ(reader.Read<uint32_t>(), 0x01020304U);
    EXPECT_EQ(reader.Read<int32_t>(), -2);
    EXPECT_TRUE(reader.Finish().ok()) << reader.Finish();
  }
}

TEST(CdrReaderTest, ReadsWhatTheWriterWrote) {
  CdrWriter writer;
  writer.WriteString("camera");
  writer.Write(false);
  writer.Write(-2.5);
  const std::array<float, 3> ranges = {1, 2, 3};
  writer.WriteCount(ranges.size());
  writer.WriteArray(std::span<const float>(ranges));
  const std::vector<uint8_t> bytes = std::move(writer).Take();
  CdrReader reader(bytes);
  EXPECT_EQ(reader.ReadString(), "camera");
  EXPECT_FALSE(reader.Read<bool>());
  EXPECT_EQ(reader.Read<double>(), -2.5);
  std::vector<float> read(reader.ReadCount(sizeof(float)));
  reader.ReadArray(std::span<float>(read));
  EXPECT_THAT(read, ElementsAre(1, 2, 3));
  EXPECT_TRUE(reader.Finish().ok()) << reader.Finish();
}

TEST(CdrReaderTest, EveryCutIsAnError) {
  CdrWriter writer;
  writer.WriteString("x");
  writer.Write(1.0);
  const std::vector<uint8_t> bytes = std::move(writer).Take();
  for (size_t size = 0; size < bytes.size(); ++size) {
    CdrReader reader(std::span<const uint8_t>(bytes).first(size));
    reader.ReadString();
    EXPECT_EQ(reader.Read<double>(), 0) << size;
    EXPECT_EQ(reader.Finish().code(), absl::StatusCode::kInvalidArgument)
        << size;
  }
}

TEST(CdrReaderTest, CountsAreComparedWithTheBytesThatAreLeft) {
  const std::vector<uint8_t> bytes = {0, 1, 0, 0, 0xff, 0xff, 0xff, 0x7f, 1};
  CdrReader reader(bytes);
  EXPECT_EQ(reader.ReadCount(8), 0U);
  EXPECT_THAT(std::string(reader.status().message()),
              HasSubstr("more elements are announced"));
}

TEST(CdrReaderTest, OtherEncodingsAreRefused) {
  for (const int number : {2, 3, 6, 7, 10}) {
    const auto kind = static_cast<uint8_t>(number);
    const std::vector<uint8_t> bytes = {0, kind, 0, 0, 1, 0, 0, 0};
    CdrReader reader(bytes);
    EXPECT_EQ(reader.Read<uint32_t>(), 0U);
    EXPECT_THAT(std::string(reader.Finish().message()),
                HasSubstr("not plain CDR"));
  }
}

TEST(CdrReaderTest, ABoolIsTrueForAnyByteButZero) {
  const std::vector<uint8_t> bytes = {0, 1, 0, 0, 0, 1, 0x80};
  CdrReader reader(bytes);
  EXPECT_FALSE(reader.Read<bool>());
  EXPECT_TRUE(reader.Read<bool>());
  EXPECT_TRUE(reader.Read<bool>());
}

TEST(CdrReaderTest, MoreThanPaddingBehindTheMessageIsAnError) {
  std::vector<uint8_t> bytes = {0, 1, 0, 0, 5, 0, 0, 0};
  CdrReader reader(bytes);
  reader.Read<uint8_t>();
  EXPECT_TRUE(reader.Finish().ok());
  bytes.push_back(0);
  CdrReader longer(bytes);
  longer.Read<uint8_t>();
  EXPECT_THAT(std::string(longer.Finish().message()),
              HasSubstr("4 bytes are left"));
}

TEST(CdrReaderTest, AStringWithoutItsEndIsAnError) {
  const std::vector<uint8_t> bytes = {0, 1, 0, 0, 2, 0, 0, 0, 'a', 'b'};
  CdrReader reader(bytes);
  EXPECT_EQ(reader.ReadString(), "");
  EXPECT_THAT(std::string(reader.Finish().message()),
              HasSubstr("no zero byte"));
}

}  // namespace
}  // namespace treeline::cdr
