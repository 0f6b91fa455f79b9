#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "common/mcap/mcap_compression.h"
#include "common/mcap/mcap_reader.h"
#include "common/mcap/mcap_writer.h"

namespace treeline::mcap {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr uint64_t kEver = std::numeric_limits<uint64_t>::max();

std::vector<uint8_t> Bytes(uint8_t value, size_t size) {
  return std::vector<uint8_t>(size, value);
}

class McapTest : public ::testing::TestWithParam<Compression> {
 protected:
  // Twenty messages on two topics, in chunks of three or four.
  std::string Written() {
    const std::string path = folder_.path() + "/log.mcap";
    auto writer = McapWriter::Open(
        path, {.compression = GetParam(), .chunk_bytes = 1000});
    EXPECT_TRUE(writer.ok()) << writer.status();
    const uint16_t scans =
        (*writer)->AddChannel("/scan", "sensor_msgs/msg/LaserScan", "text a");
    const uint16_t odometry =
        (*writer)->AddChannel("/odom", "nav_msgs/msg/Odometry", "text b");
    for (uint8_t i = 0; i < 20; ++i) {
      EXPECT_TRUE(
          (*writer)
              ->Write(i % 2 == 0 ? scans : odometry, 1000 + i, Bytes(i, 250))
              .ok());
    }
    EXPECT_TRUE((*writer)->Close().ok());
    return base::ReadFile(path).value();
  }

  static std::vector<int> ValuesIn(McapReader& reader, uint64_t from_ns,
                                   uint64_t to_ns) {
    std::vector<int> values;
    const absl::Status status =
        reader.Read(from_ns, to_ns, [&](const McapMessage& message) {
          EXPECT_EQ(message.bytes.size(), 250U);
          EXPECT_EQ(message.log_time_ns,
                    1000 + static_cast<uint8_t>(message.bytes[0]));
          values.push_back(message.bytes[0]);
          return absl::OkStatus();
        });
    EXPECT_TRUE(status.ok()) << status;
    return values;
  }

  base::TestingFolder folder_;
};

INSTANTIATE_TEST_SUITE_P(Compressions, McapTest,
                         ::testing::Values(Compression::kNone,
                                           Compression::kLz4,
                                           Compression::kZstd));

TEST_P(McapTest, ComesBackByItsSummary) {
  const std::string file = Written();
  auto reader = McapReader::Open(file);
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_TRUE(reader->has_summary());
  EXPECT_GT(reader->chunks(), 4U);
  ASSERT_EQ(reader->channels().size(), 2U);
  const McapChannel& scan = reader->channels().at(1);
  EXPECT_EQ(scan.topic, "/scan");
  EXPECT_EQ(scan.message_encoding, "cdr");
  EXPECT_EQ(scan.schema_name, "sensor_msgs/msg/LaserScan");
  EXPECT_EQ(scan.schema_encoding, "ros2msg");
  EXPECT_EQ(scan.schema_text, "text a");
  EXPECT_EQ(ValuesIn(*reader, 0, kEver).size(), 20U);
  EXPECT_THAT(ValuesIn(*reader, 1003, 1006), ElementsAre(3, 4, 5));
}

TEST_P(McapTest, ATimeOutsideUnpacksNothing) {
  std::string file = Written();
  // The first chunk is broken; who wants the last message does not notice.
  file[120] = static_cast<char>(file[120] ^ 0x55);
  auto reader = McapReader::Open(file);
  ASSERT_TRUE(reader.ok());
  EXPECT_THAT(ValuesIn(*reader, 1019, 1020), ElementsAre(19));
  EXPECT_EQ(
      reader
          ->Read(0, kEver, [](const McapMessage&) { return absl::OkStatus(); })
          .code(),
      absl::StatusCode::kDataLoss);
}

TEST_P(McapTest, AFileThatBreaksOffIsReadAsFarAsItGoes) {
  const std::string file = Written();
  for (size_t size = 8; size + 40 < file.size(); size += 97) {
    auto reader = McapReader::Open(absl::string_view(file).substr(0, size));
    ASSERT_TRUE(reader.ok()) << reader.status();
    EXPECT_FALSE(reader->has_summary());
    const std::vector<int> values = ValuesIn(*reader, 0, kEver);
    for (size_t i = 0; i < values.size(); ++i) {
      EXPECT_EQ(values[i], static_cast<int>(i));
    }
  }
}

TEST_P(McapTest, AMessageIsReadAgainWhereItWas) {
  const std::string file = Written();
  auto reader = McapReader::Open(file);
  ASSERT_TRUE(reader.ok());
  std::vector<McapPlace> places;
  ASSERT_TRUE(reader
                  ->Read(0, kEver,
                         [&](const McapMessage& message) {
                           places.push_back(message.place);
                           return absl::OkStatus();
                         })
                  .ok());
  ASSERT_EQ(places.size(), 20U);
  // Forwards, and to and fro between chunks.
  for (size_t i = 0; i < 20; ++i) {
    for (const size_t at : {i, 19 - i}) {
      const auto message = reader->Fetch(places[at]);
      ASSERT_TRUE(message.ok()) << message.status();
      EXPECT_EQ(message->log_time_ns, 1000 + at);
      EXPECT_EQ(message->bytes, std::string(250, static_cast<char>(at)));
    }
  }
  for (const McapPlace wrong :
       {McapPlace{99, 0}, McapPlace{0, 1}, McapPlace{0, 1'000'000},
        McapPlace{McapPlace::kInNoChunk, file.size() + 1}}) {
    EXPECT_FALSE(reader->Fetch(wrong).ok());
  }
}

TEST_P(McapTest, AnErrorNamesTheByte) {
  std::string file = Written();
  file[120] = static_cast<char>(file[120] ^ 0x55);
  auto reader = McapReader::Open(file);
  ASSERT_TRUE(reader.ok());
  const absl::Status status = reader->Read(
      0, kEver, [](const McapMessage&) { return absl::OkStatus(); });
  // The first chunk, behind magic and header.
  const size_t header_bytes = static_cast<uint8_t>(file[9]);
  EXPECT_THAT(std::string(status.message()),
              HasSubstr(absl::StrCat("at byte ", 8 + 9 + header_bytes, " of ",
                                     file.size())));
}

TEST(McapErrorsTest, OtherFilesAreNoMcap) {
  EXPECT_EQ(McapReader::Open("").status().code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(McapReader::Open("#ROSBAG V2.0\n").status().code(),
            absl::StatusCode::kDataLoss);
}

TEST(McapErrorsTest, AFolderThatIsNotThereIsNamed) {
  EXPECT_THAT(
      std::string(
          McapWriter::Open("/no/such/folder/x.mcap", {}).status().message()),
      HasSubstr("/no/such/folder/x.mcap"));
}

TEST(McapCompressionTest, SizesAreChecked) {
  const std::string text(5000, 'a');
  for (const Compression compression :
       {Compression::kNone, Compression::kLz4, Compression::kZstd}) {
    const std::string packed = Compress(compression, text).value();
    EXPECT_EQ(Decompress(compression, packed, text.size()).value(), text);
    EXPECT_FALSE(Decompress(compression, packed, text.size() - 1).ok());
    EXPECT_FALSE(Decompress(compression, packed, text.size() + 1).ok());
    EXPECT_FALSE(
        Decompress(compression,
                   absl::string_view(packed).substr(0, packed.size() - 1),
                   text.size())
            .ok());
  }
  EXPECT_EQ(Crc32("123456789"), 0xcbf43926U);
}

}  // namespace
}  // namespace treeline::mcap
