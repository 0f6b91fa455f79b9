#include "common/image/exif.h"

#include <cstdint>
#include <string>
#include <vector>

#include "common/image/decode.h"
#include "gtest/gtest.h"

namespace treeline::image {
namespace {

std::string Number(uint32_t value, size_t bytes, bool little) {
  std::string text;
  for (size_t i = 0; i < bytes; ++i) {
    const size_t shift = 8 * (little ? i : bytes - 1 - i);
    text += static_cast<char>(value >> shift);
  }
  return text;
}

struct Tag {
  uint32_t tag = 0x0112;
  uint32_t type = 3;
  uint32_t count = 1;
  uint32_t value = 1;
};

std::string Directory(const std::vector<Tag>& tags, bool little) {
  std::string bytes = Number(static_cast<uint32_t>(tags.size()), 2, little);
  for (const Tag& tag : tags) {
    bytes += Number(tag.tag, 2, little) + Number(tag.type, 2, little) +
             Number(tag.count, 4, little);
    bytes += tag.type == 4
                 ? Number(tag.value, 4, little)
                 : Number(tag.value, 2, little) + std::string(2, '\0');
  }
  return bytes + Number(0, 4, little);
}

std::string Tiff(const std::vector<Tag>& tags, bool little) {
  return (little ? std::string("II*\0", 4) : std::string("MM\0*", 4)) +
         Number(8, 4, little) + Directory(tags, little);
}

std::string Segment(char marker, const std::string& content) {
  return std::string("\xff") + marker +
         Number(static_cast<uint32_t>(content.size() + 2), 2, false) + content;
}

std::string App1(const std::string& tiff) {
  return Segment('\xe1', std::string("Exif\0\0", 6) + tiff);
}

// A picture with segments after its first two bytes.
std::string JpegWith(const std::string& segments) {
  const std::string jpeg =
      EncodeJpeg({.width = 4,
                  .height = 3,
                  .rgb = std::vector<uint8_t>(size_t{3} * 4 * 3, 128)},
                 90)
          .value();
  return jpeg.substr(0, 2) + segments + jpeg.substr(2);
}

std::optional<QuarterTurn> TurnOf(uint32_t value, bool little) {
  return ReadExifUprightTurn(JpegWith(
      App1(Tiff({{.tag = 0x010f}, {.value = value}, {.tag = 1}}, little))));
}

TEST(ExifTest, ReadsTheFourTurnsInBothByteOrders) {
  for (const bool little : {false, true}) {
    EXPECT_EQ(TurnOf(1, little), QuarterTurn::kNone);
    EXPECT_EQ(TurnOf(3, little), QuarterTurn::kHalf);
    EXPECT_EQ(TurnOf(6, little), QuarterTurn::kClockwise);
    EXPECT_EQ(TurnOf(8, little), QuarterTurn::kCounterclockwise);
  }
}

TEST(ExifTest, MirroredPicturesAndUnknownValuesSayNothing) {
  for (const uint32_t value : {0u, 2u, 4u, 5u, 7u, 9u, 65535u}) {
    EXPECT_EQ(TurnOf(value, true), std::nullopt) << value;
  }
}

TEST(ExifTest, TheDecoderTakesTheSamePicture) {
  const std::string jpeg = JpegWith(App1(Tiff({{.value = 6}}, true)));
  const auto image = DecodeColor(jpeg);
  ASSERT_TRUE(image.ok()) << image.status();
  EXPECT_EQ(image->width, 4);
  EXPECT_EQ(image->height, 3);
}

TEST(ExifTest, PassesOverOtherSegmentsAndFillBytes) {
  const std::string exif = App1(Tiff({{.value = 6}}, false));
  EXPECT_EQ(ReadExifUprightTurn(JpegWith(Segment('\xe0', "JFIF") +
                                         Segment('\xe1', "http://ns.adobe") +
                                         "\xff\xff\xff" + exif.substr(1))),
            QuarterTurn::kClockwise);
}

TEST(ExifTest, TheFirstExifSegmentCounts) {
  EXPECT_EQ(ReadExifUprightTurn(JpegWith(App1(Tiff({{.value = 6}}, false)) +
                                         App1(Tiff({{.value = 3}}, false)))),
            QuarterTurn::kClockwise);
}

TEST(ExifTest, APictureWithoutItSaysNothing) {
  EXPECT_EQ(ReadExifUprightTurn(JpegWith("")), std::nullopt);
  EXPECT_EQ(ReadExifUprightTurn(""), std::nullopt);
  EXPECT_EQ(ReadExifUprightTurn("\x89PNG\r\n"), std::nullopt);
}

TEST(ExifTest, BrokenTagsSayNothing) {
  const auto turn_of = [](const std::string& tiff) {
    return ReadExifUprightTurn(JpegWith(App1(tiff)));
  };
  EXPECT_EQ(turn_of(Tiff({{.type = 4, .value = 6}}, true)), std::nullopt);
  EXPECT_EQ(turn_of(Tiff({{.count = 2, .value = 6}}, true)), std::nullopt);
  EXPECT_EQ(turn_of(Tiff({{.tag = 0x0113, .value = 6}}, true)), std::nullopt);
  const std::string good = Tiff({{.value = 6}}, true);
  ASSERT_EQ(turn_of(good), QuarterTurn::kClockwise);
  // Byte order, directory beyond the end, more tags than there are.
  EXPECT_EQ(turn_of("XX" + good.substr(2)), std::nullopt);
  EXPECT_EQ(turn_of(good.substr(0, 4) + "\xff\xff\xff\xff" + good.substr(8)),
            std::nullopt);
  EXPECT_EQ(turn_of(Tiff({{.tag = 1}}, true).substr(0, 8) + "\xff\xff"),
            std::nullopt);
}

TEST(ExifTest, WhatIsCutOffSaysNothing) {
  const std::string tiff = Tiff({{.value = 6}}, true);
  const std::string start = "\xff\xd8";
  for (size_t bytes = 0; bytes < tiff.size() - 6; ++bytes) {
    EXPECT_EQ(ReadExifUprightTurn(start + App1(tiff.substr(0, bytes))),
              std::nullopt)
        << bytes;
  }
  const std::string whole = start + App1(tiff);
  for (size_t bytes = 0; bytes < whole.size(); ++bytes) {
    EXPECT_EQ(ReadExifUprightTurn(whole.substr(0, bytes)), std::nullopt)
        << bytes;
  }
}

TEST(ExifTest, LooksAtNoMoreThanItSays) {
  std::string many;
  for (int i = 0; i < 64; ++i) many += Segment('\xe2', "");
  const std::string exif = App1(Tiff({{.value = 6}}, true));
  EXPECT_EQ(ReadExifUprightTurn(JpegWith(many.substr(4) + exif)),
            QuarterTurn::kClockwise);
  EXPECT_EQ(ReadExifUprightTurn(JpegWith(many + exif)), std::nullopt);
  std::vector<Tag> tags(256, Tag{.tag = 1});
  tags.back() = {.value = 6};
  EXPECT_EQ(ReadExifUprightTurn(JpegWith(App1(Tiff(tags, true)))),
            QuarterTurn::kClockwise);
  tags.push_back({});
  EXPECT_EQ(ReadExifUprightTurn(JpegWith(App1(Tiff(tags, true)))),
            std::nullopt);
}

// The tag is in a directory of its own, which the first one points to.
TEST(ReadExifFocal35_mm, FindsTheLens) {
  constexpr uint32_t kFirstDirectoryEnds = 8 + 2 + 12 + 4;
  const auto with = [](const Tag& pointer, const Tag& focal, bool little) {
    return JpegWith(App1(Tiff({pointer}, little) + Directory({focal}, little)));
  };
  const Tag pointer = {.tag = 0x8769, .type = 4, .value = kFirstDirectoryEnds};
  const Tag focal = {.tag = 0xa405, .value = 26};
  for (const bool little : {false, true}) {
    EXPECT_EQ(ReadExifFocal35_mm(with(pointer, focal, little)), 26);
  }
  EXPECT_EQ(
      ReadExifFocal35_mm(with(pointer, {.tag = 0xa405, .value = 0}, true)),
      std::nullopt);
  EXPECT_EQ(ReadExifFocal35_mm(with(pointer, {.tag = 0xa406}, true)),
            std::nullopt);
  EXPECT_EQ(ReadExifFocal35_mm(with({}, focal, true)), std::nullopt);
  for (const uint32_t outside : {0xffffffffu, 0xfffffffeu, 1000u}) {
    const Tag astray = {.tag = 0x8769, .type = 4, .value = outside};
    EXPECT_EQ(ReadExifFocal35_mm(with(astray, focal, true)), std::nullopt);
  }
  EXPECT_EQ(ReadExifFocal35_mm(JpegWith("")), std::nullopt);
}

}  // namespace
}  // namespace treeline::image
